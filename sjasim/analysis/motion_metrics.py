"""How well bodies do what they planned: times of starts and stops, how crisp they are, how far feet slide.

Pure functions over sampled motion; where the samples come from is the caller's business.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core import Array, Cue, Kind, Move
from .ground_truth_events import detect_claps, detect_moves

NEAR_S = 0.4
"""A true event this close to a planned one is that one."""
SLOW_M_S, BRISK_M_S = 0.05, 0.25
"""A start rises from the first to the second of these speeds [m/s]."""
LANDED_S = 0.05
"""A foot counts as standing so long after its planned touch-down; until then the sole settles (assumed) [s]."""


def timing_errors(t_s: Array, roots: Array, hands_m: Array, cues: Sequence[Cue]) -> list[tuple[Kind, float]]:
    """(kind, true minus planned time [s]) of every start, stop and clap of one dancer; NaN where it never came.

    Args:
        t_s: (N,) ticks [s].
        roots: (N, 4 or more) pelvis x, y, z [m] and heading [rad].
        hands_m: (N,) distance of the palms [m].
        cues: what the dancer planned.
    """
    found = detect_moves(t_s, roots[:, 0], roots[:, 1], roots[:, 3])
    found += [(time, Kind.CLAP) for time in detect_claps(t_s, hands_m)]
    errors: list[tuple[Kind, float]] = []
    for cue in cues:
        for kind, planned_s in cue.events():
            gaps = [time - planned_s for time, other in found if other is kind and abs(time - planned_s) < NEAR_S]
            errors.append((kind, min(gaps, key=abs, default=float("nan"))))
    return errors


def rise_times(t_s: Array, roots: Array, cues: Sequence[Cue]) -> Array:
    """(K,) time that the start of each walk takes from `SLOW_M_S` to `BRISK_M_S` along the heading [s].

    NaN where it gets no faster. The sway from foot to foot lies across the heading and does not count.

    Args:
        t_s: (N,) ticks [s].
        roots: (N, 4 or more) pelvis x, y, z [m] and heading [rad].
        cues: what the dancer planned; its K walks are looked at.
    """
    middles, heading = (t_s[1:] + t_s[:-1]) / 2, (roots[1:, 3] + roots[:-1, 3]) / 2
    east, north = np.diff(roots[:, :2], axis=0).T / np.diff(t_s)
    along = east * np.cos(heading) + north * np.sin(heading)
    found: list[float] = []
    for cue in cues:
        if cue.move in (Move.FORWARD, Move.BACKWARD):
            speed = along if cue.move is Move.FORWARD else -along
            before = np.flatnonzero((middles <= cue.t_s) & (speed < SLOW_M_S))
            after = np.flatnonzero((middles > cue.t_s) & (middles < cue.t_s + cue.duration_s) & (speed > BRISK_M_S))
            rises = len(before) and len(after)
            slow = _rising(middles, speed, int(before[-1]), SLOW_M_S) if rises else 0.0
            found.append(_rising(middles, speed, int(after[0]) - 1, BRISK_M_S) - slow if rises else float("nan"))
    return np.array(found)


def foot_slips(t_s: Array, feet: Array, landing: Array) -> Array:
    """(K,) how far each standing foot strays, at most, from where it stood `LANDED_S` after touch-down [m].

    A stance lasts to the next lift-off; those of feet that never swing do not count.

    Args:
        t_s: (N,) ticks [s].
        feet: (N, 2, 2) ankles on the floor, left and right [m].
        landing: (N, 2) planned time until a swinging foot lands [s]; 0 for a standing one.
    """
    found: list[float] = []
    for side in range(2):
        swinging = landing[:, side] > 0
        downs = np.flatnonzero(swinging[:-1] & ~swinging[1:]) + 1
        lifts = np.flatnonzero(~swinging[:-1] & swinging[1:]) + 1
        for down in downs:
            lift = next((int(tick) for tick in lifts if tick > down), None)
            first = int(np.searchsorted(t_s, t_s[down] + LANDED_S))
            if lift is not None and first < lift:
                stance = feet[first:lift, side]
                found.append(float(np.hypot(*(stance - stance[0]).T).max()))
    return np.array(found)


def _rising(t_s: Array, values: Array, index: int, level: float) -> float:
    """When a signal that is below a level at ``index`` and above it one sample later passes it [s]."""
    share = (level - values[index]) / (values[index + 1] - values[index])
    return float(t_s[index] + share * (t_s[index + 1] - t_s[index]))
