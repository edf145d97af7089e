"""Why dm_control cannot be imported, in one line."""

from __future__ import annotations

import sys


def explained(missing: ImportError) -> ImportError:
    """An error that says what to do about a missing dm_control: its packages end with Python 3.12."""
    reason = "dm-control supports Python up to 3.12 only" if sys.version_info >= (3, 13) else "pip install dm-control"
    return ImportError(f"sjasim.interop needs dm_control, which cannot be imported: {reason} ({missing})")
