"""Loaded before any test.

The package chooses an offscreen OpenGL, which must precede MuJoCo's own choice. Compiled functions are forgotten
that are older than the newest source of any: numba sees when their own file has changed, not when one has that holds
what they call.
"""

from pathlib import Path

import sjasim

_ROOT = Path(sjasim.__file__).parent
_newest_s = max(path.stat().st_mtime for path in _ROOT.rglob("*.py") if "@njit" in path.read_text(encoding="utf-8"))
for _index in _ROOT.rglob("*.nbi"):
    if _index.stat().st_mtime < _newest_s:
        _index.unlink(missing_ok=True)
