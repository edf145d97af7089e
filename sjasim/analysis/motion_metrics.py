"""Accuracy with which bodies perform planned motion: timing of starts and stops, rise times, and foot slip.

All functions are pure functions of sampled motion.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core import Array, Cue, Kind, Move
from .ground_truth_events import detect_claps, detect_moves

MATCH_WITHIN_S = 0.4
"""Largest distance between a planned event and the true one that performs it [s]."""

RISE_FROM_M_S = 0.05
"""Speed at which the rise of a start begins [m/s]."""

RISE_TO_M_S = 0.25
"""Speed at which the rise of a start ends [m/s]."""

SETTLING_S = 0.05
"""Time after a planned touch-down in which the sole settles; slip counts from then on [s]; assumed."""


def timing_errors(t_s: Array, roots: Array, hands_m: Array, cues: Sequence[Cue]) -> list[tuple[Kind, float]]:
    """Kind and error (true minus planned time [s]) of every planned start, stop and clap of one dancer.

    The error is NaN where no true event of the kind is near.

    Args:
        t_s: (N,) sample times [s].
        roots: (N, 4 or more) pelvis x, y, z [m] and heading [rad].
        hands_m: (N,) distances of the palms [m].
        cues: the dancer's plan.
    """
    found = detect_moves(t_s, roots[:, 0], roots[:, 1], roots[:, 3])
    found += [(time, Kind.CLAP) for time in detect_claps(t_s, hands_m)]

    errors: list[tuple[Kind, float]] = []
    for cue in cues:
        for kind, planned_s in cue.events():
            near = [
                time - planned_s for time, other in found if other is kind and abs(time - planned_s) < MATCH_WITHIN_S
            ]
            errors.append((kind, min(near, key=abs, default=float("nan"))))
    return errors


def rise_times(t_s: Array, roots: Array, cues: Sequence[Cue]) -> Array:
    """(K,) time that the start of each walk takes from `RISE_FROM_M_S` to `RISE_TO_M_S` [s].

    The speed is that along the heading; the sway from foot to foot lies across it and does not count. A walk that does
    not reach the higher speed is NaN.

    Args:
        t_s: (N,) sample times [s].
        roots: (N, 4 or more) pelvis x, y, z [m] and heading [rad].
        cues: the dancer's plan, of which the K walks count.
    """
    midpoints = (t_s[1:] + t_s[:-1]) / 2
    heading = (roots[1:, 3] + roots[:-1, 3]) / 2
    velocity_x, velocity_y = np.diff(roots[:, :2], axis=0).T / np.diff(t_s)
    forward_m_s = velocity_x * np.cos(heading) + velocity_y * np.sin(heading)

    found: list[float] = []
    for cue in cues:
        if cue.move not in (Move.FORWARD, Move.BACKWARD):
            continue

        speed = forward_m_s if cue.move is Move.FORWARD else -forward_m_s
        during = (midpoints > cue.t_s) & (midpoints < cue.t_s + cue.duration_s)
        slow = np.flatnonzero((midpoints <= cue.t_s) & (speed < RISE_FROM_M_S))
        fast = np.flatnonzero(during & (speed > RISE_TO_M_S))
        if not len(slow) or not len(fast):
            found.append(float("nan"))
            continue

        begin_s = _crossing(midpoints, speed, int(slow[-1]), RISE_FROM_M_S)
        end_s = _crossing(midpoints, speed, int(fast[0]) - 1, RISE_TO_M_S)
        found.append(end_s - begin_s)
    return np.array(found)


def foot_slips(t_s: Array, feet: Array, landing: Array) -> Array:
    """(K,) largest distance of each standing foot from its position `SETTLING_S` after touch-down [m].

    A stance lasts from a touch-down to the next lift-off; feet that never swing have none.

    Args:
        t_s: (N,) sample times [s].
        feet: (N, 2, 2) horizontal positions of the left and the right ankle [m].
        landing: (N, 2) planned time until a swinging foot lands [s]; 0 for a standing foot.
    """
    found: list[float] = []
    for side in range(2):
        swinging = landing[:, side] > 0
        touch_downs = np.flatnonzero(swinging[:-1] & ~swinging[1:]) + 1
        lift_offs = np.flatnonzero(~swinging[:-1] & swinging[1:]) + 1

        for touch_down in touch_downs:
            lift_off = next((int(row) for row in lift_offs if row > touch_down), None)
            first = int(np.searchsorted(t_s, t_s[touch_down] + SETTLING_S))
            if lift_off is not None and first < lift_off:
                stance = feet[first:lift_off, side]
                found.append(float(np.hypot(*(stance - stance[0]).T).max()))
    return np.array(found)


def _crossing(t_s: Array, values: Array, index: int, level: float) -> float:
    """Interpolated time at which a signal passes a level between the samples ``index`` and ``index + 1`` [s]."""
    fraction = (level - values[index]) / (values[index + 1] - values[index])
    return float(t_s[index] + fraction * (t_s[index + 1] - t_s[index]))
