"""The session loop: the same seed gives the same session, however it is stepped; no event is lost or counted twice."""

import copy
import dataclasses
import json
import pickle
import subprocess
import sys

import numpy as np
import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.config import DanceConfig, FaultConfig, SessionConfig, SynchronyConfig
from sjasim.config.toml_file import to_toml
from sjasim.core import Kind
from sjasim.core.errors import ConfigError, UnknownNameError
from sjasim.session.session import Session, run_session

SHORT = SessionConfig(
    method="sia", sensing="joints", iterations=1, seed=5, dance=DanceConfig(rehearsal=False, lead_in_s=2.0)
)
MACHINE_DEPENDENT = ("cost", "versions")
"""Keys of session.json that differ between runs of the same session."""


def summary(log):
    """session.json without the keys that depend on the machine."""
    plain = json.loads(json.dumps(measures(log).as_dict()))
    return {key: value for key, value in plain.items() if key not in MACHINE_DEPENDENT}


@pytest.fixture(scope="module")
def progress_shares():
    """What `run_session` reported to its progress callback."""
    return []


@pytest.fixture(scope="module")
def short_log(progress_shares):
    """The log of the short session."""
    return run_session(SHORT, progress_shares.append)


def test_the_same_seed_gives_the_same_session_in_another_process(short_log, tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(to_toml(SHORT), encoding="utf-8")
    other = subprocess.run(
        [sys.executable, "-m", "sjasim.run", "--config", str(path), "--json"],
        capture_output=True,
        text=True,
        check=True,
    )
    found = {key: value for key, value in json.loads(other.stdout).items() if key not in MACHINE_DEPENDENT}
    assert found == summary(short_log)


def test_steps_of_random_length_give_the_same_log(short_log):
    session = Session(SHORT)
    rng = np.random.default_rng(0)
    while session.time_s < session.end_s - 1e-9:
        session.advance(min(session.time_s + rng.uniform(0.0005, 0.7), session.end_s))
    stepped = session.log()

    for field in ("cues", "device_events", "events", "commands", "decisions", "robot_events", "notices"):
        assert getattr(stepped, field) == getattr(short_log, field), field
    for table in ("truth", "odometry"):
        columns = getattr(short_log, table)
        assert columns
        for name, column in columns.items():
            assert np.array_equal(getattr(stepped, table)[name], column, equal_nan=True), name


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_session_cannot_be_copied_or_pickled(copied):
    session = Session(SHORT)
    session.advance(3.0)
    with pytest.raises(TypeError, match="run another Session with the same configuration"):
        copied(session)
    # The refused copy has not touched the session.
    session.advance(3.5)
    assert session.time_s == pytest.approx(3.5, abs=0.01)


def people_and_cues(**changes):
    """Builds of the dancers and the first cues of a session that is not run."""
    world = Session(dataclasses.replace(SHORT, **changes)).world
    return [body.build for body in world.anatomies], tuple(world.cues)


def test_another_seed_gives_other_people_and_another_performance():
    people, cues = people_and_cues()
    other_people, other_cues = people_and_cues(seed=6)
    assert people != other_people
    assert [cue.t_s for cue in cues] != [cue.t_s for cue in other_cues]


def test_methods_meet_the_same_people_in_different_performances():
    people, cues = people_and_cues(method="sia")
    same_people, other_cues = people_and_cues(method="eca")
    assert same_people == people
    assert [cue.t_s for cue in other_cues] != [cue.t_s for cue in cues]


def test_a_named_performance_is_the_same_under_every_method():
    sia = people_and_cues(method="sia", performance="take 1")
    assert sia == people_and_cues(method="eca", performance="take 1")


def test_tau_reaches_the_method_and_the_metrics():
    session = Session(dataclasses.replace(SHORT, synchrony=SynchronyConfig(tau_s=1.0)))
    assert session.context.tau_s == 1.0


def test_every_event_comes_from_one_device_event_in_order_of_arrival(short_log):
    """An event that both clients report at a hand-over counts once."""
    events = short_log.events
    assert len(events) > 20
    keys = [(event.person, event.kind, event.early, event.t_s) for event in events]
    assert len(set(keys)) == len(keys)
    assert [event.t_arrival_s for event in events] == sorted(event.t_arrival_s for event in events)

    reported = [(event.sensor, event.kind, event.early) for event, _ in short_log.device_events]
    for key in {(event.sensor, event.kind, event.early) for event in events}:
        counted = sum((event.sensor, event.kind, event.early) == key for event in events)
        assert counted <= reported.count(key)


@pytest.mark.slow
def test_no_event_is_lost_or_counted_twice_at_a_hand_over():
    config = dataclasses.replace(SHORT, method="eca", humans="metronomic", iterations=2, dance=DanceConfig())
    log = run_session(config)

    for kind, per_iteration in ((Kind.START_FORWARD, 2), (Kind.STOP_BACKWARD, 2), (Kind.CLAP, 1)):
        for person in ("dancer_1", "dancer_2", "dancer_3"):
            detected = [e.t_s for e in log.events if (e.person, e.kind, e.early) == (person, kind, False)]
            planned = [t_s for cue in log.cues for one, t_s in cue.events() if cue.dancer == person and one is kind]
            assert len(planned) == 3 * per_iteration
            assert 1 < len(detected) <= len(planned)
            assert min(np.diff(detected)) > 1.0

    detector = measures(log).detector
    assert detector.precision == 1.0
    assert detector.recall == 1.0


def test_progress_rises_to_one(short_log, progress_shares):
    assert len(progress_shares) > 10
    assert sorted(progress_shares) == progress_shares
    assert progress_shares[-1] == 1.0


@pytest.mark.parametrize(
    ("kind", "target", "allowed"),
    [
        ("dead_sensor", "up", "north, west, south, east"),
        ("clock_jump", "dancer_1", "north"),
        ("dancer_stops", "dancer_4", "dancer_1, dancer_2, dancer_3"),
        ("dead_robot", "dancer_1", "robot"),
    ],
)
def test_a_fault_must_name_an_existing_target(kind, target, allowed):
    with pytest.raises(ConfigError, match=target) as caught:
        Session(dataclasses.replace(SHORT, faults=(FaultConfig(kind, target),)))
    assert caught.value.field == "faults[0].target"
    assert allowed in caught.value.allowed


@pytest.mark.parametrize("changes", [{"method": "sai"}, {"humans": "nobody"}, {"sensing": "sonar"}])
def test_unknown_names_are_refused_before_a_session_begins(changes):
    with pytest.raises(UnknownNameError):
        Session(dataclasses.replace(SHORT, **changes))
