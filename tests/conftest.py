"""Fixtures that several rooms of the tests share.

Importing sjasim here, before any test does, lets the package choose an offscreen OpenGL; MuJoCo chooses on its import.
"""

from __future__ import annotations

import pytest
from hypothesis import settings

import sjasim  # noqa: F401
from sjasim.choreography.timetable import Timetable, timetable
from sjasim.config import SessionConfig

# An example during which numba compiles a function takes seconds, so a deadline would fail on a cold cache.
settings.register_profile("sjasim", deadline=None)
settings.load_profile("sjasim")


@pytest.fixture(scope="session")
def paper_timetable() -> Timetable:
    """The default timetable: the paper's dance at 118 BPM after 4 s, one rehearsal and four iterations."""
    return timetable(SessionConfig())
