"""True events of dancers and robot: when speeds crossed the onset speed, and when palms met."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..choreography.timetable import Timetable
from ..core import ROBOT, Array, Cue, Kind, Move, dancer_name
from ..core.session_log import AgentEvent

ONSET_M_S = 0.10
"""Speed along the heading whose crossing is a start or a stop [m/s]; the robot's odometry uses the same speed."""

DEBOUNCE_S = 0.15
"""Shortest time on one side of the onset speed that counts; shorter crossings are the ripple of single steps [s]."""

CLAP_DISTANCE_M = 0.12
"""Distance of the palms below which an approach is a clap [m]; assumed."""

CLAP_REFRACTORY_S = 1.0
"""Shortest time from one clap to the approach of the next [s]; assumed."""

TURN_RAD_S = 0.4
"""Yaw rate from which the robot turns [rad/s]. Source: iqbal2016."""

VISIBLE_TRUNK_SHARE = 0.5
"""Share of trunk joints that must be visible for a start or stop to count as visible; assumed."""

VISIBLE_HANDS_SHARE = 1.0
"""Share of hand joints that must be visible for a clap to count as visible: both hands are needed; assumed."""

VISIBILITY_WINDOW_S = 0.1
"""Time before and after an event in which its joints must be visible [s]; assumed."""

SWAY_AFTER_TURN_S = 0.4
"""Time after a turn in which a dancer still sways without a move [s]; assumed."""

Edge = tuple[float, Kind]
"""Time [s] and kind of a start or a stop."""

DIRECTIONS = ((1.0, Kind.START_FORWARD, Kind.STOP_FORWARD), (-1.0, Kind.START_BACKWARD, Kind.STOP_BACKWARD))
"""Sign of the speed along the heading, and kinds of the events at both ends of such a move."""


def dancer_events(
    truth: Mapping[str, NDArray[np.generic]], cues: tuple[Cue, ...], timetable: Timetable
) -> list[AgentEvent]:
    """True events of every dancer in order of time, each with whether the active sensor could see it.

    A start and its stop that both lie inside a dancer's turn are sway, not a move, and are left out. A stop counts as
    visible only if its start was visible too, since no detector can see a stop whose start it missed.

    Args:
        truth: columns of the ground-truth table; without any, there are no events.
        cues: the dancers' plans, of which only the turns are used.
        timetable: assigns events to iterations.
    """
    events: list[AgentEvent] = []
    dancer = np.asarray(truth["dancer"]) if truth else np.zeros(0)

    for index in np.unique(dancer):
        rows = {name: np.asarray(column, dtype=np.float64)[dancer == index] for name, column in truth.items()}
        name = dancer_name(int(index))
        found = _dancer_edges(rows, name, cues)

        start_visible = False
        for t_s, kind in sorted(found):
            if kind is Kind.CLAP:
                visible = _visible(rows["t_s"], rows["hands_seen"], t_s, VISIBLE_HANDS_SHARE)
            else:
                visible = _visible(rows["t_s"], rows["spine_seen"], t_s, VISIBLE_TRUNK_SHARE)
                if kind in (Kind.START_FORWARD, Kind.START_BACKWARD):
                    start_visible = visible
                else:
                    visible = visible and start_visible
            events.append(AgentEvent(timetable.iteration_at(t_s), name, kind, t_s, visible))

    return sorted(events, key=lambda event: (event.t_s, event.agent))


def robot_events(odometry: Mapping[str, Array], timetable: Timetable) -> list[AgentEvent]:
    """True events of the robot in order of time, from the true poses in its odometry table; empty without a robot.

    Args:
        odometry: columns of the odometry table.
        timetable: assigns events to iterations.
    """
    if not odometry or len(odometry["t_s"]) < 3:
        return []

    t_s = odometry["t_s"]
    heading = np.unwrap(odometry["true_heading_rad"])
    found = detect_moves(t_s, odometry["true_x_m"], odometry["true_y_m"], heading)
    yaw_rate = np.abs(np.diff(heading) / np.diff(t_s))
    found += [(begin, Kind.TURN) for begin, _ in debounced_intervals(_midpoints(t_s), yaw_rate - TURN_RAD_S)]

    events = [AgentEvent(timetable.iteration_at(time), ROBOT, kind, time) for time, kind in found]
    return sorted(events, key=lambda event: event.t_s)


def detect_moves(t_s: Array, x_m: Array, y_m: Array, heading_rad: Array) -> list[Edge]:
    """Starts and stops of one agent: all forward ones in order of time, then all backward ones.

    The velocity between two samples is assigned to their midpoint; crossings of the onset speed are interpolated.

    Args:
        t_s: (N,) sample times [s].
        x_m: (N,) positions [m].
        y_m: (N,) positions [m].
        heading_rad: (N,) headings [rad].
    """
    edges = [edge for pair in _start_stop_pairs(t_s, x_m, y_m, heading_rad) for edge in pair]
    return [(time, kind) for time, kind in edges if np.isfinite(time)]


def detect_claps(t_s: Array, hands_m: Array) -> list[float]:
    """Times of closest approach of the palms, one for each approach below `CLAP_DISTANCE_M` [s].

    Args:
        t_s: (N,) sample times [s].
        hands_m: (N,) distances of the palms [m].
    """
    near = np.concatenate([[False], hands_m < CLAP_DISTANCE_M, [False]])
    begins = np.flatnonzero(near[1:] & ~near[:-1])
    ends = np.flatnonzero(near[:-1] & ~near[1:])

    times: list[float] = []
    for begin, end in zip(begins, ends, strict=True):
        time = float(t_s[begin + int(np.argmin(hands_m[begin:end]))])
        if not times or t_s[begin] - times[-1] > CLAP_REFRACTORY_S:
            times.append(time)
    return times


def debounced_intervals(t_s: Array, excess: Array) -> list[tuple[float, float]]:
    """Intervals in which a signal is positive; a change of sign counts once it lasts for `DEBOUNCE_S`.

    Args:
        t_s: (N,) sample times [s].
        excess: (N,) signal; zero crossings are interpolated.

    Returns:
        (begin, end) of each interval [s]; an interval that lasts beyond the data ends at infinity.
    """
    positive = excess > 0
    flips = np.flatnonzero(positive[1:] != positive[:-1])
    fraction = excess[flips] / (excess[flips] - excess[flips + 1])
    crossings = t_s[flips] + fraction * (t_s[flips + 1] - t_s[flips])
    # The end of the data closes the last stretch, so that a change shortly before it does not count.
    stretch_ends = np.concatenate([crossings, t_s[-1:]])

    found: list[tuple[float, float]] = []
    inside = False
    for index, crossing in enumerate(crossings):
        rises = bool(positive[flips[index] + 1])
        if rises == inside or stretch_ends[index + 1] - crossing < DEBOUNCE_S:
            continue

        inside = rises
        if rises:
            found.append((float(crossing), float("inf")))
        else:
            found[-1] = (found[-1][0], float(crossing))
    return found


def _dancer_edges(rows: Mapping[str, Array], name: str, cues: tuple[Cue, ...]) -> list[Edge]:
    """Starts, stops and claps of one dancer, without the sway inside turns."""
    turns = [
        (cue.t_s, cue.t_s + cue.duration_s + SWAY_AFTER_TURN_S)
        for cue in cues
        if cue.dancer == name and cue.move is Move.TURN
    ]
    edges = [
        edge
        for start, stop in _start_stop_pairs(rows["t_s"], rows["x_m"], rows["y_m"], rows["heading_rad"])
        if not any(begin <= start[0] and stop[0] <= end for begin, end in turns)
        for edge in (start, stop)
        if np.isfinite(edge[0])
    ]
    return edges + [(t_s, Kind.CLAP) for t_s in detect_claps(rows["t_s"], rows["hands_m"])]


def _start_stop_pairs(t_s: Array, x_m: Array, y_m: Array, heading_rad: Array) -> list[tuple[Edge, Edge]]:
    """Start and stop of each move; the stop of a move that lasts beyond the data is at infinity."""
    if len(t_s) < 3:
        return []

    cos = np.cos(heading_rad)
    sin = np.sin(heading_rad)
    forward_m = np.diff(x_m) * (cos[1:] + cos[:-1]) / 2 + np.diff(y_m) * (sin[1:] + sin[:-1]) / 2
    velocity = forward_m / np.diff(t_s)
    return [
        ((begin, start), (end, stop))
        for sign, start, stop in DIRECTIONS
        for begin, end in debounced_intervals(_midpoints(t_s), sign * velocity - ONSET_M_S)
    ]


def _midpoints(t_s: Array) -> Array:
    """(N - 1,) times halfway between samples [s]."""
    return np.asarray((t_s[1:] + t_s[:-1]) / 2)


def _visible(t_s: Array, visible_share: Array, time: float, least_share: float) -> bool:
    """Whether enough joints are visible at every sample around a time.

    A share that is NaN, without an active sensor, is not enough.
    """
    near = (t_s >= time - VISIBILITY_WINDOW_S) & (t_s <= time + VISIBILITY_WINDOW_S)
    return bool(near.any() and np.all(visible_share[near] >= least_share))
