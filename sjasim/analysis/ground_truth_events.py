"""True events from the logged truth: when speeds really crossed the onset speed and palms really met."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..choreography.timetable import Timetable
from ..core import ROBOT, Array, Cue, Kind, Move, dancer_name
from ..core.session_log import AgentEvent

ONSET_M_S = 0.10
"""Speed along the heading whose crossing is a start or a stop; the same 0.10 m/s counts for the robot's odometry."""

KEPT_S = 0.15
"""How long a new side of the onset speed must be kept; shorter is the ripple of a step."""

PALMS_M = 0.12
"""Distance of the palms below which an approach is a clap; assumed."""

TURN_RAD_S = 0.4
"""Yaw rate from which the robot turns (iqbal2016)."""

SEEN_SPINE, SEEN_HANDS = 0.5, 1.0
"""Share of torso or hand joints from which an event counts as visible; both hands are needed; assumed."""

SEEN_AROUND_S = 0.1
"""For so long before and after an event its joints must be seen; assumed."""

SETTLE_S = 0.4
"""For so long after a turn a dancer's sway is no move; assumed."""

Edge = tuple[float, Kind]

MOVES = ((1.0, Kind.START_FORWARD, Kind.STOP_FORWARD), (-1.0, Kind.START_BACKWARD, Kind.STOP_BACKWARD))


def dancer_events(
    truth: Mapping[str, NDArray[np.generic]], cues: tuple[Cue, ...], timetable: Timetable
) -> list[AgentEvent]:
    """Every dancer's true events in order of time, each with whether the active sensor could see it.

    A start and its stop that both lie inside a dancer's turn are sway, not a move, and are left out.

    Args:
        truth: the truth table's columns.
        cues: the plan; only its turns are used.
        timetable: assigns events to iterations.
    """
    events: list[AgentEvent] = []
    dancer = np.asarray(truth["dancer"]) if truth else np.zeros(0)
    for index in np.unique(dancer):
        rows = {name: np.asarray(column, dtype=np.float64)[dancer == index] for name, column in truth.items()}
        name = dancer_name(int(index))
        turns = [
            (cue.t_s, cue.t_s + cue.duration_s + SETTLE_S)
            for cue in cues
            if cue.dancer == name and cue.move is Move.TURN
        ]
        found = [
            edge
            for start, stop in _moves(rows["t_s"], rows["x_m"], rows["y_m"], rows["heading_rad"])
            if not any(begin <= start[0] and stop[0] <= end for begin, end in turns)
            for edge in (start, stop)
            if np.isfinite(edge[0])
        ]
        found += [(t_s, Kind.CLAP) for t_s in detect_claps(rows["t_s"], rows["hands_m"])]
        started = False
        for t_s, kind in sorted(found):
            hands = kind is Kind.CLAP
            seen = _seen(rows["t_s"], rows["hands_seen" if hands else "spine_seen"], t_s, hands)
            if kind in (Kind.START_FORWARD, Kind.START_BACKWARD):
                started = seen
            elif not hands:
                seen = seen and started  # who was not seen to start cannot be seen to stop
            events.append(AgentEvent(timetable.iteration_at(t_s), name, kind, t_s, seen))
    return sorted(events, key=lambda event: (event.t_s, event.agent))


def robot_events(odometry: Mapping[str, Array], timetable: Timetable) -> list[AgentEvent]:
    """The robot's true events from the true pose beside its odometry, by the dancers' rule; none without a robot."""
    if not odometry or len(odometry["t_s"]) < 3:
        return []
    t_s, heading = odometry["t_s"], np.unwrap(odometry["true_heading_rad"])
    found = detect_moves(t_s, odometry["true_x_m"], odometry["true_y_m"], heading)
    rate = np.abs(np.diff(heading) / np.diff(t_s))
    found += [(begin, Kind.TURN) for begin, _ in stretches(_middles(t_s), rate - TURN_RAD_S)]
    events = [AgentEvent(timetable.iteration_at(time), ROBOT, kind, time) for time, kind in found]
    return sorted(events, key=lambda event: event.t_s)


def detect_moves(t_s: Array, x_m: Array, y_m: Array, heading_rad: Array) -> list[tuple[float, Kind]]:
    """Starts and stops of one agent: (time, kind), by direction, then in order.

    The velocity between two ticks stands at their middle; crossings are interpolated between middles.

    Args:
        t_s: (N,) ticks [s].
        x_m: (N,) position.
        y_m: (N,) position.
        heading_rad: (N,) heading.
    """
    edges = [edge for pair in _moves(t_s, x_m, y_m, heading_rad) for edge in pair]
    return [(time, kind) for time, kind in edges if np.isfinite(time)]


def _moves(t_s: Array, x_m: Array, y_m: Array, heading_rad: Array) -> list[tuple[Edge, Edge]]:
    """The same in pairs of start and stop; the stop of a move that goes on at the end of the data is at infinity."""
    if len(t_s) < 3:
        return []
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    forward = np.diff(x_m) * (cos[1:] + cos[:-1]) / 2 + np.diff(y_m) * (sin[1:] + sin[:-1]) / 2
    velocity = forward / np.diff(t_s)
    return [
        ((begin, start), (end, stop))
        for sign, start, stop in MOVES
        for begin, end in stretches(_middles(t_s), sign * velocity - ONSET_M_S)
    ]


def stretches(t_s: Array, excess: Array) -> list[tuple[float, float]]:
    """Stretches of a positive signal, debounced: a side counts once it is kept for `KEPT_S`.

    Args:
        t_s: (N,) times [s].
        excess: (N,) signal; zero crossings are interpolated.

    Returns:
        (begin, end) of each stretch; a stretch still going on at the end of the data ends at infinity.
    """
    above = excess > 0
    flips = np.flatnonzero(above[1:] != above[:-1])
    share = excess[flips] / (excess[flips] - excess[flips + 1])
    crossings = t_s[flips] + share * (t_s[flips + 1] - t_s[flips])
    edges = np.concatenate([crossings, t_s[-1:]])
    found: list[tuple[float, float]] = []
    moving = False
    for index, crossing in enumerate(crossings):
        up = bool(above[flips[index] + 1])
        if up == moving or edges[index + 1] - crossing < KEPT_S:
            continue
        moving = up
        if up:
            found.append((float(crossing), float("inf")))
        else:
            found[-1] = (found[-1][0], float(crossing))
    return found


def detect_claps(t_s: Array, hands_m: Array) -> list[float]:
    """Times of closest approach of the palms, one for each approach below `PALMS_M`.

    Args:
        t_s: (N,) times [s].
        hands_m: (N,) distance of the palms [m].
    """
    near = np.concatenate([[False], hands_m < PALMS_M, [False]])
    begins, ends = np.flatnonzero(near[1:] & ~near[:-1]), np.flatnonzero(near[:-1] & ~near[1:])
    times: list[float] = []
    for begin, end in zip(begins, ends, strict=True):
        time = float(t_s[begin + int(np.argmin(hands_m[begin:end]))])
        if not times or t_s[begin] - times[-1] > 1.0:
            times.append(time)
    return times


def _middles(t_s: Array) -> Array:
    return np.asarray((t_s[1:] + t_s[:-1]) / 2)


def _seen(t_s: Array, share: Array, time: float, hands: bool) -> bool:
    """Whether enough of the joints is seen at every tick around ``time``; NaN, no active sensor, is not."""
    near = (t_s >= time - SEEN_AROUND_S) & (t_s <= time + SEEN_AROUND_S)
    return bool(near.any() and np.all(share[near] >= (SEEN_HANDS if hands else SEEN_SPINE)))
