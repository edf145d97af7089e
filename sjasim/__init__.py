"""sjasim: three dancers and a robot, in simulation, to try group coordination before people are recruited.

The public names are loaded when they are first used, so that importing the package stays quick and brings in
neither MuJoCo nor rerun.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .analysis.calibration.event_table_fit import fit_timing
    from .analysis.session_metrics import measures
    from .anticipation import synchrony
    from .config import SessionConfig
    from .core.session_log import SessionLog
    from .sensors.recordings.detect import detect_events
    from .session.session import run_session

__version__ = "0.1.0"

__all__ = [
    "SessionConfig", "SessionLog", "__version__", "detect_events", "fit_timing", "measures", "run_session", "synchrony",
]  # fmt: skip

_PUBLIC = {
    "SessionConfig": (".config", "SessionConfig"),
    "SessionLog": (".core.session_log", "SessionLog"),
    "detect_events": (".sensors.recordings.detect", "detect_events"),
    "fit_timing": (".analysis.calibration.event_table_fit", "fit_timing"),
    "measures": (".analysis.session_metrics", "measures"),
    "run_session": (".session.session", "run_session"),
    "synchrony": (".anticipation.synchrony", None),
}


def __getattr__(name: str) -> object:
    """Load a public name when it is first asked for."""
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    place, attribute = _PUBLIC[name]
    module = importlib.import_module(place, __name__)
    value: object = getattr(module, attribute) if attribute else module
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _pick_gl() -> None:
    """Choose an off-screen OpenGL for MuJoCo on a Linux machine without a display, before MuJoCo is loaded.

    A choice made by the user stands. With no library at all rendering is disabled; sensors cast rays and need none.
    """
    if "MUJOCO_GL" in os.environ or not sys.platform.startswith("linux") or os.environ.get("DISPLAY"):
        return
    for library, name in (("libEGL.so.1", "egl"), ("libOSMesa.so.8", "osmesa")):
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        os.environ["MUJOCO_GL"] = name
        return
    os.environ["MUJOCO_GL"] = "disable"


def _forget_stale(*places: Path) -> None:
    """Drop compiled functions that are older than the newest source of any.

    Numba sees when a function's own file has changed, not when one has that holds what it calls: after an update of
    the sources the old code would go on being called, without a word.
    """
    kept = [index for place in places for index in place.rglob("*.nbi")]
    written = (path for place in places for path in place.rglob("*.py")) if kept else ()
    marks = (b"@njit", b"@compiled_")
    sources = (path for path in written if any(mark in path.read_bytes() for mark in marks))
    newest_s = max((path.stat().st_mtime for path in sources), default=0.0)
    with contextlib.suppress(OSError):  # who may not write there has no caches of their own there either
        for index in kept:
            if index.stat().st_mtime < newest_s:
                index.unlink(missing_ok=True)


def _register_environments() -> None:
    """Make the Gymnasium ids known; from a clone that is not installed they are found beside the package."""
    try:
        importlib.import_module("sjasim_envs")
    except ModuleNotFoundError as missing:
        skin = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "envs")
        if missing.name != "sjasim_envs" or not os.path.isdir(os.path.join(skin, "sjasim_envs")):
            raise
        sys.path.append(skin)
        importlib.import_module("sjasim_envs")


_pick_gl()
_here = Path(__file__).parent
_forget_stale(_here, _here.parent / "sjasim_envs", _here.parent / "envs")
_register_environments()
