"""Short sessions with physics: one iteration without rehearsal by metronomic dancers, with joint sensing."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.config import DanceConfig, FaultConfig, SessionConfig
from sjasim.session.session import run_session

SHORT = SessionConfig(
    method="eca", humans="metronomic", sensing="joints", iterations=1, dance=DanceConfig(rehearsal=False)
)


def run_short_session(*faults, **changes):
    """Run `SHORT` with faults, given as tuples, and with changed fields.

    Returns:
        its ``log``, its ``measures``, and its ``notices`` as (source, text).
    """
    given = tuple(FaultConfig(*fault) for fault in faults)
    log = run_session(dataclasses.replace(SHORT, faults=given, **changes))
    notices = [(notice.source, notice.what) for notice in log.notices]
    return SimpleNamespace(log=log, measures=measures(log), notices=notices)


def regular_events(session, person):
    """Events of a person that are not early ones, in order of time."""
    return [event for event in session.log.events if event.person == person and not event.early]


@pytest.fixture(scope="session")
def clean():
    """The short session without faults."""
    return run_short_session()
