"""Fixtures that several rooms of the tests share.

Importing sjasim here, before any test does, lets the package choose an offscreen OpenGL; MuJoCo chooses on its import.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import settings

import sjasim  # noqa: F401
from sjasim.choreography.timetable import Timetable, timetable
from sjasim.config import SessionConfig
from sjasim.core.session_log import SessionLog

from . import synthetic_log

# An example during which numba compiles a function takes seconds, so a deadline would fail on a cold cache.
settings.register_profile("sjasim", deadline=None)
settings.load_profile("sjasim")


@pytest.fixture(scope="session")
def paper_timetable() -> Timetable:
    """The default timetable: the paper's dance at 118 BPM after 4 s, one rehearsal and four iterations."""
    return timetable(SessionConfig())


@pytest.fixture(scope="session")
def make_session_log() -> Callable[..., SessionLog]:
    """`synthetic_log.make_session_log`, which computes the log of a session from formulas, with known errors."""
    return synthetic_log.make_session_log
