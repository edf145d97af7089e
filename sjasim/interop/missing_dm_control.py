"""The error message for a missing dm_control."""

from __future__ import annotations

import sys


def missing_dm_control(error: ImportError) -> ImportError:
    """An error that says how to install dm_control, whose packages exist for Python up to 3.12 only."""
    remedy = "dm-control supports Python up to 3.12 only" if sys.version_info >= (3, 13) else "pip install dm-control"
    return ImportError(f"sjasim.interop needs dm_control, which cannot be imported: {remedy} ({error})")
