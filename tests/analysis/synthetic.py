"""A session log made by formula: dancers on trapezoids of speed, a robot behind them, known errors everywhere."""

from __future__ import annotations

import numpy as np

from sjasim.anticipation.synchrony import most_synchronous
from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import timetable
from sjasim.config import SessionConfig
from sjasim.config.toml_file import to_plain
from sjasim.core import ROBOT, Cue, DeviceEvent, Event, Kind, Move, MoveCommand, dancer_name
from sjasim.core.session_log import AgentEvent, Decision, Followed, Notice, SessionLog

RAMP_S = 0.25
CRUISE_M_S = 0.25
ONSET_S = 0.10 / CRUISE_M_S * RAMP_S
"""From the ramp's beginning to the crossing of .10 m/s."""

DETECTION_S = 0.12
CLOCK_ERROR_S = 0.0015
ROBOT_LAG_S = 0.18
DEVICE_OFFSET_S = 0.4
SIGN = {Kind.START_FORWARD: 1.0, Kind.START_BACKWARD: -1.0}
MOVE = {Kind.START_FORWARD: Move.FORWARD, Kind.START_BACKWARD: Move.BACKWARD, Kind.CLAP: Move.TURN}


def session(method="sia", seed=0, iterations=2, spread_s=0.05, robot=True, joints=True, late=(0.0, 0.0, 0.0)):
    """A log whose true event times are drawn about the beats, one column of ``late`` per dancer."""
    config = SessionConfig(method=method, seed=seed, iterations=iterations)
    table = timetable(config)
    rng = np.random.default_rng(seed)
    steps = table.choreography.steps()
    shape = (len(late), iterations + 1, len(steps))
    beats = np.array([[table.time_s(i, step.beat) for step in steps] for i in range(iterations + 1)])
    true_s = beats + np.asarray(late)[:, None, None] + spread_s * rng.standard_normal(shape)
    robot_s = true_s[0] + DETECTION_S + ROBOT_LAG_S
    events, device_events = observed(true_s, steps, table)
    return SessionLog(
        config=to_plain(config),
        versions={"numpy": "2"},
        cues=tuple(cues(true_s, steps)),
        device_events=device_events,
        events=events,
        commands=tuple(commands(robot_s, steps)) if robot else (),
        decisions=(Decision(9.0, 1, 0, Kind.START_FORWARD, "send", 9.0, "dancer_1", "seen early"),),
        robot_events=tuple(robot_events(robot_s, steps)) if robot else (),
        notices=(Notice(3.0, "west", "no message for 2.0 s"),),
        odometry=odometry(robot_s, steps, table, config) if robot else {},
        truth=truth(true_s, steps, table, config),
        joints=skeletons(config, table) if joints else None,
        followed=tuple(followed(events, method, iterations)),
        cost={"sim_s": table.end_s() + config.dance.tail_s, "cpu_s": 1.0, "wall_s": 1.5},
    )


def followed(events, method, iterations):
    """SIA follows nobody at first, then the most synchronous dancer of the iteration before; others follow all."""
    before = None
    for i in range(1, iterations + 1) if method == "sia" else ():
        names = sorted({event.person for event in events})
        last = [event for event in events if event.iteration == i - 1]
        series = {name: [(e.t_s, e.kind) for e in last if e.person == name] for name in names}
        columns = {name: ([t for t, _ in rows], [kind for _, kind in rows]) for name, rows in series.items()}
        before = most_synchronous(columns, before, 0.25).person
        yield Followed(i, before if i > 1 else "")


def cues(true_s, steps):
    """One cue per move, and the turn half a beat after the clap."""
    for d, i, k in np.ndindex(true_s.shape):
        if steps[k].kind in SIGN:
            move, length = MOVE[steps[k].kind], true_s[d, i, k + 1] - true_s[d, i, k]
            yield Cue(dancer_name(d), move, i, k, steps[k].beat, true_s[d, i, k], length)
        elif steps[k].kind is Kind.CLAP:
            yield Cue(dancer_name(d), Move.CLAP, i, k, steps[k].beat, true_s[d, i, k], 0.0)
            yield Cue(dancer_name(d), Move.TURN, i, k, steps[k].beat + 0.5, true_s[d, i, k] + 0.25, 1.5)


def observed(true_s, steps, table):
    """Regular events as logged, and the device events behind them."""
    events, device_events = [], []
    for d, i, k in np.ndindex(true_s.shape):
        sent_s = true_s[d, i, k] + DETECTION_S
        sensor = ("north", "west", "south", "east")[(i - 1) % 4]
        device = DeviceEvent(sensor, d + 10, steps[k].kind, sent_s + DEVICE_OFFSET_S, False, None)
        device_events.append((device, sent_s))
        t_s = sent_s + CLOCK_ERROR_S
        events.append(Event(dancer_name(d), steps[k].kind, t_s, t_s + 0.02, False, table.iteration_at(t_s), sensor))
    early = DeviceEvent("north", 10, Kind.START_FORWARD, 5.0, True, 4.9)
    return tuple(events), (*device_events, (early, 4.6))


def commands(robot_s, steps):
    """One command per step from iteration 1 on, sent the robot's lag before its event."""
    number = 0
    for i in range(1, len(robot_s)):
        for k, step in enumerate(steps):
            number += 1
            move = MOVE.get(step.kind, Move.STOP)
            yield MoveCommand(number, move, robot_s[i, k] - ROBOT_LAG_S, 0.25, 0.0, i, k, "synthetic")


def robot_events(robot_s, steps):
    """The robot's events from iteration 1 on."""
    for i in range(1, len(robot_s)):
        for k, step in enumerate(steps):
            yield AgentEvent(i, ROBOT, Kind.TURN if step.kind is Kind.CLAP else step.kind, robot_s[i, k])


def travel(times_s, row_s, steps):
    """Displacement along the heading [m] of one agent in one iteration, on trapezoids that cross .10 at its events."""
    middles = (times_s[1:] + times_s[:-1]) / 2
    speed = np.zeros_like(middles)
    for k, step in enumerate(steps):
        if step.kind in SIGN:
            up, down = row_s[k] - ONSET_S, row_s[k + 1] - (RAMP_S - ONSET_S)
            shape = np.clip((middles - up) / RAMP_S, 0, 1) * np.clip(1 - (middles - down) / RAMP_S, 0, 1)
            speed += SIGN[step.kind] * CRUISE_M_S * shape
    return np.concatenate([[0.0], np.cumsum(speed * np.diff(times_s))])


def motion(times_s, rows_s, steps, table, slot, first):
    """x, y, heading of one agent: back and forth along each iteration's heading, then a quarter turn."""
    xy, heading = np.tile(np.asarray(slot, dtype=float), (len(times_s), 1)), np.zeros(len(times_s))
    heading[:] = table.heading_rad(first)
    for i in range(first, len(rows_s)):
        facing = table.heading_rad(i)
        moved = travel(times_s, rows_s[i], steps)
        moved -= moved[-1] * np.clip((times_s - rows_s[i, -1]) / 1.0, 0, 1)  # home again, too slowly for an event
        xy += moved[:, None] * [np.cos(facing), np.sin(facing)]
        heading += np.pi / 2 * np.clip((times_s - rows_s[i, -1]) / 1.5, 0, 1)
    return xy, heading


def truth(true_s, steps, table, config):
    """The truth table's columns, rows ordered by tick, then dancer."""
    times = np.arange(int((table.end_s() + config.dance.tail_s) * 60)) / 60
    dancers, count = len(true_s), len(times)
    slots = layout(config).dancers
    columns = {name: np.empty((count, dancers)) for name in ("x_m", "y_m", "heading_rad", "hands_m")}
    for d in range(dancers):
        xy, columns["heading_rad"][:, d] = motion(times, true_s[d], steps, table, slots[d], table.first)
        columns["x_m"][:, d], columns["y_m"][:, d] = xy.T
        away = np.min(np.abs(times[:, None] - true_s[d, :, -1]), axis=1)
        columns["hands_m"][:, d] = np.minimum(0.6, 0.04 + away)
    flat = {name: column.ravel() for name, column in columns.items()}
    size = count * dancers
    constants = {"z_m": 0.95, "tether_x_n": 3.0, "tether_y_n": 4.0, "tether_torque_nm": 1.0, "load_n": 693.0}
    constants |= {"weight_n": 700.0, "spine_seen": 1.0, "hands_seen": 1.0, "fallen": 0.0}
    filled = {name: np.full(size, value) for name, value in constants.items()}
    return {"t_s": np.repeat(times, dancers), "dancer": np.tile(np.arange(dancers), count), **flat, **filled}


def odometry(robot_s, steps, table, config):
    """The odometry table's columns at 50 Hz; belief and truth agree."""
    times = np.arange(int((table.end_s() + config.dance.tail_s) * 50)) / 50
    slot = layout(config).robot
    xy, heading = motion(times, robot_s, steps, table, slot, 1)
    rate = np.gradient(heading, times)
    columns = {"t_s": times, "x_m": xy[:, 0], "y_m": xy[:, 1], "heading_rad": heading}
    columns |= {"step_m": np.zeros(len(times)), "yaw_rate_rad_s": rate}
    return columns | {"true_x_m": xy[:, 0], "true_y_m": xy[:, 1], "true_heading_rad": heading}


def skeletons(config, table):
    """Standing figures at 30 Hz, enough to be drawn."""
    count = int((table.end_s() + config.dance.tail_s) * 30)
    slots = layout(config).dancers
    joints = np.zeros((count, config.dancers, 25, 3), dtype=np.float32)
    joints[..., :2] = slots[None, :, None]
    joints[..., 2] = np.linspace(0.1, 1.7, 25)
    return joints
