"""Fixtures that several rooms of the tests share.

Importing sjasim here, before any test does, lets the package choose an offscreen OpenGL; MuJoCo chooses on its import.
"""

from __future__ import annotations

import pytest

import sjasim  # noqa: F401
from sjasim.choreography.timetable import Timetable, timetable
from sjasim.config import SessionConfig


@pytest.fixture(scope="session")
def paper_timetable() -> Timetable:
    """The default timetable: the paper's dance at 118 BPM after 4 s, one rehearsal and four iterations."""
    return timetable(SessionConfig())
