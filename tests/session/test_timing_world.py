"""The event-level world: what it draws, what it refuses, and that a session in it is like any other."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from sjasim.choreography.timetable import timetable
from sjasim.config import BodyConfig, FaultConfig, RobotConfig, SessionConfig
from sjasim.core import Cue, Kind, Move, MoveCommand
from sjasim.core.errors import ConfigError
from sjasim.session.session import Session, run_session
from sjasim.session.timing_statistics import DETECTED_KINDS, QUANTILES, ROBOT_KINDS, DelayStatistics
from sjasim.session.timing_world import EventSampler, TimedRobot

TIMING = SessionConfig(fidelity="timing", sensing="joints", humans="musicians")


def statistics(delay_s: float = 0.2, missed: float = 0.0, rate: float = 0.0) -> DelayStatistics:
    return DelayStatistics(missed, np.full(len(QUANTILES), delay_s), rate)


def sampler(**changes) -> EventSampler:
    """A sampler with delays of .2 s, and of .1 s for early events."""
    regular = dict.fromkeys(DETECTED_KINDS, statistics()) | changes.pop("regular", {})
    early = dict.fromkeys(DETECTED_KINDS[:-1], statistics(0.1)) | changes.pop("early", {})
    return EventSampler(regular, early, np.random.default_rng(1))


def cues(count: int = 2) -> list[Cue]:
    return [Cue("dancer_1", Move.FORWARD, 1, 0, 0.0, 10.0 + 4.0 * k, 2.0) for k in range(count)]


def run(config: SessionConfig) -> Session:
    session = Session(config)
    session.advance(session.end_s)
    return session


def test_every_event_of_a_cue_is_detected_with_its_delay():
    found = sampler().detected(0, cues(1))
    assert [(kind, early) for _, kind, early in found if not early] == [
        (Kind.START_FORWARD, False),
        (Kind.STOP_FORWARD, False),
    ]
    assert sorted(t_s for t_s, _, early in found if not early) == pytest.approx([10.2, 12.2])


def test_a_stop_is_missed_with_its_start():
    found = sampler(regular={Kind.START_FORWARD: statistics(missed=1.0)}).detected(0, cues())
    assert not any(kind is Kind.STOP_FORWARD for _, kind, _ in found)


def test_an_early_stop_needs_a_move_that_was_detected_before():
    found = sampler().detected(0, cues(2))
    early_stops = [t_s for t_s, kind, early in found if early and kind is Kind.STOP_FORWARD]
    assert early_stops == pytest.approx([16.1])
    # Another dancer's moves do not help.
    shared = sampler()
    shared.detected(0, cues(1))
    assert not any(early and kind is Kind.STOP_FORWARD for _, kind, early in shared.detected(1, cues(1)))


def test_misses_and_false_events_have_their_rates():
    lossy = sampler(regular={Kind.CLAP: statistics(missed=0.3, rate=2.0)})
    claps = [Cue("dancer_1", Move.CLAP, 1, 8, 32.0, float(k), 0.0) for k in range(3000)]
    assert len(lossy.detected(0, claps)) / 3000 == pytest.approx(0.7, abs=0.03)
    found = lossy.false_events(60.0 * 500)
    assert len(found) / 500 == pytest.approx(2.0, abs=0.2)
    assert {(kind, early) for _, kind, early in found} == {(Kind.CLAP, False)}


def command(number: int, move: Move) -> MoveCommand:
    return MoveCommand(number, move, 0.0, 0.25, 0.0, 1, 0, "test")


def robot(**changes) -> TimedRobot:
    table = dict.fromkeys(ROBOT_KINDS, statistics(0.3)) | changes.pop("table", {})
    return TimedRobot(table, dataclasses.replace(TIMING, **changes), np.random.default_rng(1))


def test_the_robot_starts_stops_and_turns():
    base = robot()
    assert base.receive(1.0, command(1, Move.FORWARD)) == [(pytest.approx(1.3), Kind.START_FORWARD)]
    assert base.receive(1.1, command(1, Move.FORWARD)) == []
    assert base.receive(3.0, command(2, Move.STOP)) == [(pytest.approx(3.3), Kind.STOP_FORWARD)]
    assert base.receive(4.0, command(3, Move.STOP)) == []
    assert base.receive(5.0, command(4, Move.TURN)) == [(pytest.approx(5.3), Kind.TURN)]


def test_a_reversal_is_a_stop_and_a_start_in_this_order():
    base = robot()
    base.receive(1.0, command(1, Move.FORWARD))
    found = base.receive(2.0, command(2, Move.BACKWARD))
    assert [kind for _, kind in found] == [Kind.STOP_FORWARD, Kind.START_BACKWARD]
    assert found[0][0] < found[1][0]


def test_the_robots_latency_adds_to_what_was_measured():
    slow = robot(robot=RobotConfig(command_latency_s=0.45))
    assert slow.receive(1.0, command(1, Move.FORWARD))[0][0] == pytest.approx(1.6)


@pytest.mark.parametrize("kind", ["dead_robot", "robot_blocked"])
def test_a_failed_robot_does_nothing_more(kind):
    failed = robot(faults=(FaultConfig(kind, "robot", 2.0),))
    assert failed.receive(1.0, command(1, Move.FORWARD))
    assert failed.receive(2.5, command(2, Move.STOP)) == []


def test_commands_that_the_robot_ignores_have_their_rate():
    lazy = robot(table={Kind.TURN: statistics(missed=0.25)})
    done = [lazy.receive(float(k), command(k + 1, Move.TURN)) for k in range(2000)]
    assert sum(map(bool, done)) / 2000 == pytest.approx(0.75, abs=0.04)


def test_a_session_has_events_commands_and_a_robot_that_follows():
    session = run(TIMING)
    table = timetable(TIMING)
    assert len(session.world.robot_events) >= 34
    assert len(session.commands) == 36
    assert session.world.time_s == pytest.approx(session.end_s)
    assert [item.sensor for item in session.handovers] == ["east", "north", "west", "south", "east"]
    assert all(event.iteration == table.iteration_at(event.t_s) for event in session.events)
    assert not session.world.notices
    assert not session.server.notices


def test_clocks_are_exact_and_nobody_counts_as_dead():
    log = run_session(TIMING)
    sent = {round(t_s, 9) for _, t_s in log.device_events}
    assert all(round(event.t_s, 9) in sent for event in log.events)
    assert not any("dead" in notice.what for notice in log.notices)


def test_the_same_seed_gives_the_same_session_and_another_seed_another():
    first, again, other = (run_session(dataclasses.replace(TIMING, seed=seed)) for seed in (3, 3, 4))
    assert first.events == again.events
    assert first.robot_events == again.robot_events
    assert first.decisions == again.decisions
    assert first.events != other.events


def test_dividing_a_session_into_calls_changes_nothing():
    whole = run(TIMING)
    parts = Session(TIMING)
    for share in np.linspace(0.01, 1.0, 57):
        parts.advance(share * parts.end_s)
    parts.advance(parts.end_s)
    assert parts.events == whole.events
    assert parts.world.robot_events == whole.world.robot_events


def test_all_methods_meet_the_same_performance_under_one_name():
    dances = [run(dataclasses.replace(TIMING, method=method, performance="take")) for method in ("eca", "sia", "none")]
    assert dances[0].world.cues == dances[1].world.cues == dances[2].world.cues
    assert not dances[2].world.robot_events
    fresh = [run(dataclasses.replace(TIMING, method=method)).world.cues for method in ("eca", "sia")]
    assert fresh[0] != fresh[1]


def test_a_late_dancer_is_late_and_one_who_stops_stops():
    late = (FaultConfig("dancer_late", "dancer_2", 0.0, 0.7), FaultConfig("dancer_stops", "dancer_3", 40.0))
    plain = run(TIMING)
    faulty = run(dataclasses.replace(TIMING, faults=late))
    shift = [b.t_s - a.t_s for a, b in zip(own(plain, "dancer_2", 0), own(faulty, "dancer_2", 0), strict=True)]
    assert shift == pytest.approx([0.7] * len(shift))
    assert max(event.t_s for event in faulty.events if event.person == "dancer_3") < 44.0


def own(session: Session, dancer: str, iteration: int) -> list[Cue]:
    return [cue for cue in session.world.cues if cue.dancer == dancer and cue.iteration == iteration]


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"faults": (FaultConfig("dead_sensor", "north", 10.0),)}, r"faults\[0\].kind"),
        ({"body": BodyConfig(stature_m=(1.5, 1.6))}, "body"),
        ({"robot": RobotConfig(cruise_m_s=0.3)}, "robot"),
    ],
)
def test_what_has_no_effect_is_refused(changes, field):
    with pytest.raises(ConfigError, match=field):
        Session(dataclasses.replace(TIMING, **changes))


def test_depth_sensing_detects_less_than_true_joints():
    count = {}
    for sensing in ("joints", "depth"):
        configs = (dataclasses.replace(TIMING, sensing=sensing, seed=seed) for seed in range(12))
        count[sensing] = sum(len(run(config).events) for config in configs)
    assert count["depth"] < count["joints"]


def test_a_world_without_frames_has_empty_ground_truth():
    world = run(TIMING).world
    assert world.recorder.truth() == {}
    assert world.recorder.odometry() == {}
    assert world.recorder.joints().shape == (0, 3, 25, 3)
    assert world.recorder.skeletons().shape == (0, 3, 25, 4)
    assert world.latest_frame("north") is None
    assert world.next_instant_s(1.25) == 1.25
    assert not math.isnan(world.time_s)
