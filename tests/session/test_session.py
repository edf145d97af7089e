"""The conductor: the same seed gives the same session, however it is stepped; nothing is lost or doubled."""

import dataclasses
import json
import subprocess
import sys

import numpy as np
import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.config import DanceConfig, FaultConfig, SessionConfig
from sjasim.config.toml_file import to_toml
from sjasim.core import Kind
from sjasim.core.errors import ConfigError, UnknownNameError
from sjasim.session.session import Session, run_session

SHORT = SessionConfig(
    method="sia", sensing="joints", iterations=1, seed=5, dance=DanceConfig(rehearsal=False, lead_in_s=2.0)
)
shares_told: list[float] = []
UNSTEADY = ("cpu_s", "wall_s", "versions")


def summary(log):
    """session.json without what may differ from run to run."""
    plain = json.loads(json.dumps(measures(log).as_dict()))
    return {key: value for key, value in plain.items() if key not in UNSTEADY}


@pytest.fixture(scope="module")
def danced():
    shares_told.clear()
    return run_session(SHORT, shares_told.append)


def test_the_same_seed_gives_the_same_session_in_another_process(danced, tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(to_toml(SHORT), encoding="utf-8")
    other = subprocess.run(
        [sys.executable, "-m", "sjasim.run", "--config", str(path), "--json"],
        capture_output=True,
        text=True,
        check=True,
    )
    found = {key: value for key, value in json.loads(other.stdout).items() if key not in UNSTEADY}
    assert found == summary(danced)


def test_stepping_in_odd_pieces_gives_the_same_log(danced):
    session = Session(SHORT)
    rng = np.random.default_rng(0)
    while session.time_s < session.end_s - 1e-9:
        session.advance(min(session.time_s + rng.uniform(0.0005, 0.7), session.end_s))
    pieces = session.log()
    for field in ("cues", "device_events", "events", "commands", "decisions", "robot_events", "notices"):
        assert getattr(pieces, field) == getattr(danced, field), field
    for table in ("truth", "odometry"):
        for name, column in getattr(danced, table).items():
            assert np.array_equal(getattr(pieces, table)[name], column, equal_nan=True), name


def plan(**changes):
    """Builds and first cues of a session that is not danced."""
    world = Session(dataclasses.replace(SHORT, **changes)).world
    return [body.build for body in world.anatomies], tuple(world.cues)


def test_another_seed_is_another_dance_by_other_people():
    people, cues = plan()
    other_people, other_cues = plan(seed=6)
    assert people != other_people
    assert [cue.t_s for cue in cues] != [cue.t_s for cue in other_cues]


def test_the_same_people_meet_every_method_and_dance_anew():
    people, cues = plan(method="sia")
    same_people, fresh = plan(method="eca")
    assert same_people == people
    assert [cue.t_s for cue in fresh] != [cue.t_s for cue in cues]


def test_a_named_performance_is_the_same_under_every_method():
    assert plan(method="sia", performance="take 1") == plan(method="eca", performance="take 1")


def test_events_are_complete_in_order_and_single(danced):
    """Every event comes from one device event; what both clients saw in a hand-over counts once."""
    keys = [(event.person, event.kind, event.early, event.t_s) for event in danced.events]
    assert len(set(keys)) == len(keys)
    assert [event.t_arrival_s for event in danced.events] == sorted(event.t_arrival_s for event in danced.events)
    sent = [(event.sensor, event.kind, event.early) for event, _ in danced.device_events]
    for key in {(event.sensor, event.kind, event.early) for event in danced.events}:
        told = sum((event.sensor, event.kind, event.early) == key for event in danced.events)
        assert told <= sent.count(key)


@pytest.mark.slow
def test_no_event_is_lost_or_doubled_at_a_hand_over():
    config = dataclasses.replace(SHORT, method="eca", humans="metronomic", iterations=2, dance=DanceConfig())
    log = run_session(config)
    for kind, per_iteration in ((Kind.START_FORWARD, 2), (Kind.STOP_BACKWARD, 2), (Kind.CLAP, 1)):
        for person in ("dancer_1", "dancer_2", "dancer_3"):
            own = [e.t_s for e in log.events if (e.person, e.kind, e.early) == (person, kind, False)]
            true = [t_s for cue in log.cues for one, t_s in cue.events() if cue.dancer == person and one is kind]
            assert len(true) == 3 * per_iteration
            assert len(own) <= len(true)
            assert min(np.diff(own), default=9.0) > 1.0
    reported = measures(log).detector
    assert reported.precision == 1.0
    assert reported.recall == 1.0


def test_progress_rises_to_one(danced):
    assert sorted(shares_told) == shares_told
    assert shares_told[-1] == 1.0


@pytest.mark.parametrize(
    ("kind", "target", "allowed"),
    [
        ("dead_sensor", "up", "north, west, south, east"),
        ("clock_jump", "dancer_1", "north"),
        ("dancer_stops", "dancer_4", "dancer_1, dancer_2, dancer_3"),
        ("dead_robot", "dancer_1", "robot"),
    ],
)
def test_a_fault_must_hit_somebody(kind, target, allowed):
    with pytest.raises(ConfigError, match=target) as caught:
        Session(dataclasses.replace(SHORT, faults=(FaultConfig(kind, target),)))
    assert caught.value.field == "faults[0].target"
    assert allowed in caught.value.allowed


def test_unknown_names_stop_a_session_before_it_begins():
    for changes in ({"method": "sai"}, {"humans": "nobody"}, {"sensing": "sonar"}):
        with pytest.raises(UnknownNameError):
            Session(dataclasses.replace(SHORT, **changes))
