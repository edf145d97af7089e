"""A session log computed from formulas, with known errors; tests get it from the fixture ``make_session_log``.

Dancers move at trapezoidal speeds about the beats. Every event is detected `DETECTION_S` after its true onset and
stamped with a clock error of `CLOCK_ERROR_S`; the robot follows `DETECTION_S` + `ROBOT_LAG_S` after the first dancer.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sjasim.anticipation.synchrony import most_synchronous
from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import Timetable, timetable
from sjasim.config import SessionConfig
from sjasim.config.toml_file import to_plain
from sjasim.core import ROBOT, Array, Cue, DeviceEvent, Event, Kind, Move, MoveCommand, dancer_name
from sjasim.core.method_io import Step
from sjasim.core.session_log import AgentEvent, Decision, Followed, Notice, SessionLog

RAMP_S = 0.25
CRUISE_M_S = 0.25
ONSET_S = 0.10 / CRUISE_M_S * RAMP_S
"""Time from the beginning of the ramp until the speed crosses 0.10 m/s."""

DETECTION_S = 0.12
CLOCK_ERROR_S = 0.0015
ROBOT_LAG_S = 0.18
DEVICE_OFFSET_S = 0.4

GROUND_TRUTH_HZ = 60
ODOMETRY_HZ = 50
JOINTS_HZ = 30

DIRECTION = {Kind.START_FORWARD: 1.0, Kind.START_BACKWARD: -1.0}
MOVE = {Kind.START_FORWARD: Move.FORWARD, Kind.START_BACKWARD: Move.BACKWARD, Kind.CLAP: Move.TURN}
"""Kind that begins a move -> the robot's command for it."""


class Plan(NamedTuple):
    """What the functions below share: configuration, timetable, and its steps."""

    config: SessionConfig
    table: Timetable
    steps: tuple[Step, ...]

    @property
    def duration_s(self) -> float:
        return self.table.end_s() + self.config.dance.tail_s


def make_session_log(
    method: str = "sia",
    seed: int = 0,
    iterations: int = 2,
    spread_s: float = 0.05,
    robot: bool = True,
    joints: bool = True,
    late_s: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> SessionLog:
    """A log whose true event times are normally distributed about the beats.

    Args:
        method: anticipation method in the configuration; SIA's log has rows of followed dancers.
        seed: of the event times.
        iterations: number of danced iterations.
        spread_s: standard deviation of the event times [s].
        robot: whether the log has commands, events and odometry of a robot.
        joints: whether the log has joints.
        late_s: constant lateness of each dancer [s]; its length is the number of dancers.
    """
    config = SessionConfig(method=method, seed=seed, iterations=iterations)
    table = timetable(config)
    plan = Plan(config, table, tuple(table.choreography.steps()))

    rng = np.random.default_rng(seed)
    beats = np.array([[table.time_s(i, step.beat) for step in plan.steps] for i in range(iterations + 1)])
    shape = (len(late_s), iterations + 1, len(plan.steps))
    true_s = beats + np.asarray(late_s)[:, None, None] + spread_s * rng.standard_normal(shape)
    robot_s = true_s[0] + DETECTION_S + ROBOT_LAG_S
    events, device_events = make_events(true_s, plan)
    commands = tuple(make_commands(robot_s, plan)) if robot else ()

    return SessionLog(
        config=to_plain(config),
        versions={"numpy": "2"},
        cues=tuple(make_cues(true_s, plan)),
        device_events=device_events,
        events=events,
        commands=commands,
        decisions=tuple(make_decisions(commands, plan)),
        robot_events=tuple(make_robot_events(robot_s, plan)) if robot else (),
        notices=(Notice(3.0, "west", "no message for 2.0 s"),),
        odometry=make_odometry(robot_s, plan) if robot else {},
        truth=make_truth(true_s, plan),
        joints=make_joints(plan) if joints else None,
        followed=tuple(make_followed(events, method, iterations)),
        cost={"sim_s": plan.duration_s, "cpu_s": 1.0, "wall_s": 1.5},
    )


def make_followed(events, method, iterations):
    """SIA follows nobody at first, then the most synchronous person of the iteration before; others log nothing."""
    before = None
    for i in range(1, iterations + 1) if method == "sia" else ():
        names = sorted({event.person for event in events})
        last = [event for event in events if event.iteration == i - 1]
        series = {name: [(e.t_s, e.kind) for e in last if e.person == name] for name in names}
        columns = {name: ([t for t, _ in rows], [kind for _, kind in rows]) for name, rows in series.items()}
        before = most_synchronous(columns, before, 0.25).person
        yield Followed(i, before if i > 1 else "")


def make_cues(true_s, plan):
    """One cue per move, and the turn half a beat after the clap."""
    for d, i, k in np.ndindex(true_s.shape):
        step = plan.steps[k]
        if step.kind in DIRECTION:
            duration_s = true_s[d, i, k + 1] - true_s[d, i, k]
            yield Cue(dancer_name(d), MOVE[step.kind], i, k, step.beat, true_s[d, i, k], duration_s)
        elif step.kind is Kind.CLAP:
            yield Cue(dancer_name(d), Move.CLAP, i, k, step.beat, true_s[d, i, k], 0.0)
            yield Cue(dancer_name(d), Move.TURN, i, k, step.beat + 0.5, true_s[d, i, k] + 0.25, 1.5)


def make_events(true_s, plan):
    """Regular events as logged, the device events behind them, and one early device event that was lost."""
    events = []
    device_events = []
    for d, i, k in np.ndindex(true_s.shape):
        kind = plan.steps[k].kind
        sent_s = true_s[d, i, k] + DETECTION_S
        sensor = ("north", "west", "south", "east")[(i - 1) % 4]
        device = DeviceEvent(sensor, d + 10, kind, sent_s + DEVICE_OFFSET_S, False, None)
        device_events.append((device, sent_s))

        t_s = sent_s + CLOCK_ERROR_S
        events.append(Event(dancer_name(d), kind, t_s, t_s + 0.02, False, plan.table.iteration_at(t_s), sensor))

    early = DeviceEvent("north", 10, Kind.START_FORWARD, 5.0, True, 4.9)
    return tuple(events), (*device_events, (early, 4.6))


def make_commands(robot_s, plan):
    """One command per step from iteration 1 on, sent the robot's lag before its event."""
    number = 0
    for i in range(1, len(robot_s)):
        for k, step in enumerate(plan.steps):
            number += 1
            move = MOVE.get(step.kind, Move.STOP)
            yield MoveCommand(number, move, robot_s[i, k] - ROBOT_LAG_S, 0.25, 0.0, i, k, "synthetic")


def make_decisions(commands, plan):
    """One decision per command: SIA answers the first dancer from iteration 2 on, other methods answer a schedule."""
    for command in commands:
        follows = plan.config.method == "sia" and command.iteration > 1
        key = (command.iteration, command.ordinal, plan.steps[command.ordinal].kind)
        person = "dancer_1" if follows else ""
        yield Decision(command.t_start_s, *key, "sent", command.t_start_s, person, "seen" if follows else "scheduled")


def make_robot_events(robot_s, plan):
    """The robot's events from iteration 1 on."""
    for i in range(1, len(robot_s)):
        for k, step in enumerate(plan.steps):
            yield AgentEvent(i, ROBOT, Kind.TURN if step.kind is Kind.CLAP else step.kind, robot_s[i, k])


def displacement(times_s, event_s, steps) -> Array:
    """Displacement along the heading in one iteration [m], on trapezoids of speed that cross 0.10 m/s at the events."""
    middles = (times_s[1:] + times_s[:-1]) / 2
    speed = np.zeros_like(middles)
    for k, step in enumerate(steps):
        if step.kind in DIRECTION:
            up_s = event_s[k] - ONSET_S
            down_s = event_s[k + 1] - (RAMP_S - ONSET_S)
            shape = np.clip((middles - up_s) / RAMP_S, 0, 1) * np.clip(1 - (middles - down_s) / RAMP_S, 0, 1)
            speed += DIRECTION[step.kind] * CRUISE_M_S * shape
    return np.concatenate([[0.0], np.cumsum(speed * np.diff(times_s))])


def motion(times_s, event_s, plan, slot, first):
    """(N, 2) position and (N,) heading of one agent: back and forth in each iteration, then a quarter turn.

    Args:
        times_s: (N,) times [s].
        event_s: (I, K) event times of all iterations [s].
        plan: of the session.
        slot: (2,) position at which every iteration begins [m].
        first: first iteration in which the agent moves.
    """
    xy = np.tile(np.asarray(slot, dtype=float), (len(times_s), 1))
    heading = np.full(len(times_s), plan.table.heading_rad(first), dtype=float)

    for i in range(first, len(event_s)):
        facing = plan.table.heading_rad(i)
        moved = displacement(times_s, event_s[i], plan.steps)
        # Back to the slot after the clap, too slowly for an event.
        moved -= moved[-1] * np.clip((times_s - event_s[i, -1]) / 1.0, 0, 1)
        xy += moved[:, None] * [np.cos(facing), np.sin(facing)]
        heading += np.pi / 2 * np.clip((times_s - event_s[i, -1]) / 1.5, 0, 1)

    return xy, heading


def make_truth(true_s, plan):
    """Columns of the ground-truth table; rows are ordered by time, then dancer."""
    times = np.arange(int(plan.duration_s * GROUND_TRUTH_HZ)) / GROUND_TRUTH_HZ
    dancers = len(true_s)
    slots = layout(plan.config).dancers

    moving = {name: np.empty((len(times), dancers)) for name in ("x_m", "y_m", "heading_rad", "hands_m")}
    for d in range(dancers):
        xy, moving["heading_rad"][:, d] = motion(times, true_s[d], plan, slots[d], plan.table.first)
        moving["x_m"][:, d], moving["y_m"][:, d] = xy.T
        since_clap_s = np.min(np.abs(times[:, None] - true_s[d, :, -1]), axis=1)
        moving["hands_m"][:, d] = np.minimum(0.6, 0.04 + since_clap_s)

    constants = {"z_m": 0.95, "tether_x_n": 3.0, "tether_y_n": 4.0, "tether_torque_nm": 1.0, "load_n": 693.0}
    constants |= {"weight_n": 700.0, "spine_seen": 1.0, "hands_seen": 1.0, "fallen": 0.0}
    return {
        "t_s": np.repeat(times, dancers),
        "dancer": np.tile(np.arange(dancers), len(times)),
        **{name: column.ravel() for name, column in moving.items()},
        **{name: np.full(len(times) * dancers, value) for name, value in constants.items()},
    }


def make_odometry(robot_s, plan):
    """Columns of the odometry table; the estimate equals the truth."""
    times = np.arange(int(plan.duration_s * ODOMETRY_HZ)) / ODOMETRY_HZ
    xy, heading = motion(times, robot_s, plan, layout(plan.config).robot, 1)
    return {
        "t_s": times,
        "x_m": xy[:, 0],
        "y_m": xy[:, 1],
        "heading_rad": heading,
        "step_m": np.zeros(len(times)),
        "yaw_rate_rad_s": np.gradient(heading, times),
        "true_x_m": xy[:, 0],
        "true_y_m": xy[:, 1],
        "true_heading_rad": heading,
    }


def make_joints(plan):
    """(F, D, 25, 3) joints of dancers who stand at their slots [m], as vertical columns."""
    frames = int(plan.duration_s * JOINTS_HZ)
    slots = layout(plan.config).dancers
    joints = np.zeros((frames, plan.config.dancers, 25, 3), dtype=np.float32)
    joints[..., :2] = slots[None, :, None]
    joints[..., 2] = np.linspace(0.1, 1.7, 25)
    return joints
