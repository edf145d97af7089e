"""Short sessions on real physics: one iteration on nominal beats without rehearsal, seen as joints, unless asked."""

import dataclasses
from types import SimpleNamespace

import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.config import DanceConfig, FaultConfig, SessionConfig
from sjasim.session.session import run_session

SHORT = SessionConfig(
    method="eca", humans="metronomic", sensing="joints", iterations=1, dance=DanceConfig(rehearsal=False)
)


def dance(*faults, **changes):
    """A danced session: its log, its measures, and what was noticed of whom."""
    found = tuple(FaultConfig(*fault) for fault in faults)
    log = run_session(dataclasses.replace(SHORT, faults=found, **changes))
    notices = [(notice.source, notice.what) for notice in log.notices]
    return SimpleNamespace(log=log, measures=measures(log), notices=notices)


def heard_of(session, person):
    """Regular events of somebody, in order of time."""
    return [event for event in session.log.events if event.person == person and not event.early]


@pytest.fixture(scope="session")
def clean():
    """The short session with nothing wrong."""
    return dance()
