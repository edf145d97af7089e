"""A small design whose sessions take milliseconds, and the bytes of the tables that it gives."""

from __future__ import annotations

import hashlib
from pathlib import Path

from sjasim.config import DanceConfig, SessionConfig
from sjasim.studies.dataset import table_file
from sjasim.studies.study_design import StudyDesign
from sjasim.studies.table_format import TABLES

SHORT = SessionConfig(fidelity="timing", iterations=1, dance=DanceConfig(rehearsal=False))
"""Sessions of one iteration without a rehearsal."""


def small_design(**changes: object) -> StudyDesign:
    """Three groups, two methods, one iteration."""
    return StudyDesign(**{"groups": 3, "session": SHORT, **changes})


def digests(folder: Path) -> dict[str, str]:
    """Digest of each table's file."""
    return {name: hashlib.sha256((folder / table_file(name)).read_bytes()).hexdigest() for name in TABLES}
