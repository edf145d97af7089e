"""Footsteps: when and where each foot swings, and the weight shift and the zero-moment point that follow.

Step times and the height of a swing are assumed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core import Array
from ...core.compiled import compiled_entry
from .reference_trajectory import ReferenceTrajectory
from .speed_profile import SpeedProfile, minimum_jerk

STEP_S = 0.50
"""Usual time from one step to the next [s]: about a beat at 118 BPM."""

LEAD_S = 0.30
"""Time from the begin of a walk's first step to the start event [s]. It keeps both feet on the floor while the speed
passes its onset, where a lift-off would show as a ripple of the pelvis."""

TRAIL_S = 0.12
"""Time from the stop event to the end of a walk's last step [s]."""

SUPPORT_SHARE = 0.22
"""Share of a step during which both feet stand."""

LIFT_M = 0.05
"""Height of a swing [m]."""

SHIFT_S = 0.12
"""Time over which the weight shift between the feet is smoothed [s]."""

REACH_MARGIN_M = 0.010
"""The pelvis is lowered before a leg is stretched nearer than this to its full length [m]."""

MAX_RISE_M = 0.006
"""Smoothing may lift the pelvis by no more than this above the height that the legs allow [m]."""


@dataclass(frozen=True, slots=True)
class Step:
    """One swing of a foot.

    Attributes:
        side: 0 left, 1 right.
        lift_s: session time of the lift-off.
        land_s: session time of the touch-down.
        along: where it lands: a distance along a walk [m], or a share of a turn's angle.
    """

    side: int
    lift_s: float
    land_s: float
    along: float


@dataclass(frozen=True, slots=True)
class Walk:
    """The steps of one walk, its begin and end, and the time per step [s]."""

    steps: tuple[Step, ...]
    start_s: float
    end_s: float
    step_s: float


def plan_walk(profile: SpeedProfile, t_s: float, last_side: int, free_s: float) -> Walk:
    """Steps under a moving pelvis: each foot lands where the pelvis is at that foot's next mid-stance.

    Args:
        profile: speed of the pelvis.
        t_s: session time of the start event.
        last_side: the foot that swung last; the other one begins.
        free_s: session time at which it landed; the walk does not begin before.
    """
    begin = max(t_s - LEAD_S, free_s)
    whole = t_s + profile.duration_s + TRAIL_S - begin
    count = max(2, round(whole / STEP_S))
    step_s = whole / count
    pause = 0.5 * SUPPORT_SHARE * step_s

    mid_stance: Array = begin + (np.arange(count, dtype=np.float64) + 1.5) * step_s - t_s
    places = profile.distance_at(mid_stance)
    # The last two steps bring both feet to the end of the walk.
    places[-2:] = profile.distance_m

    steps = []
    for j in range(count):
        lift_s = begin + j * step_s + pause
        land_s = begin + (j + 1) * step_s - pause
        steps.append(Step((last_side + 1 + j) % 2, lift_s, land_s, float(places[j])))

    return Walk(tuple(steps), begin, begin + whole, step_s)


def plan_turn(t_s: float, duration_s: float, free_s: float) -> tuple[Step, ...]:
    """Four steps of a turn on the spot to the left: left and right by half of the angle, then both by all of it.

    Args:
        t_s: session time at which the turn begins.
        duration_s: its duration.
        free_s: session time at which the step before it landed; the turn's steps do not begin before.
    """
    begin = max(t_s, free_s)
    step_s = (t_s + duration_s - begin) / 4
    pause = 0.5 * SUPPORT_SHARE * step_s

    return tuple(
        Step(j % 2, begin + j * step_s + pause, begin + (j + 1) * step_s - pause, 0.5 if j < 2 else 1.0)
        for j in range(4)
    )


class FootTrajectories:
    """Trajectories of both feet in a reference trajectory.

    Args:
        slot: (2,) where the dancer stands [m].
        heading_rad: initial heading.
        hip_m: half the distance between the feet.
        ankle_m: height of a standing foot's ankle.
        times: (T,) session times of the rows [s].
        reference: trajectory of the dancer, whose ``ankles``, ``foot_yaw`` and ``landing`` are written up to its last
            planned row.

    Attributes:
        last_side: the foot that swung last, 0 left, 1 right.
        landed_s: session time at which it landed.
    """

    def __init__(
        self,
        slot: Array,
        heading_rad: float,
        hip_m: float,
        ankle_m: float,
        times: Array,
        reference: ReferenceTrajectory,
    ) -> None:
        self._hip_m = hip_m
        self._ankle_m = ankle_m
        self._times = times
        self._kernel = smoothing_kernel(SHIFT_S / 2, float(times[1] - times[0]))

        self.ankles = reference.ankles
        self.yaw = reference.foot_yaw
        self.landing = reference.landing
        self._planned_rows = reference.planned_rows
        self.last_side = 1
        self.landed_s = 0.0

        planned = slice(0, int(self._planned_rows[0]))
        self.yaw[planned] = heading_rad
        for side in range(2):
            self.ankles[planned, side, :2] = self._beside(slot, heading_rad, side)
        self.ankles[planned, :, 2] = ankle_m

    def _beside(self, point: Array, heading_rad: float, side: int) -> Array:
        """(2,) place of a standing foot beside a point (2,) [m]."""
        half = self._hip_m if side == 0 else -self._hip_m
        return point + half * np.array([-np.sin(heading_rad), np.cos(heading_rad)])

    def swing(self, step: Step, point: Array, heading_rad: float) -> None:
        """Swing a foot to its place beside a point (2,), at a heading; it stays there in all later rows."""
        planned = int(self._planned_rows[0])
        first, last = (min(int(tick), planned - 1) for tick in np.searchsorted(self._times, (step.lift_s, step.land_s)))
        span = slice(first, last)
        after = slice(last, planned)
        share = (self._times[span] - step.lift_s) / (step.land_s - step.lift_s)
        ease = minimum_jerk(share)

        origin = self.ankles[first, step.side, :2].copy()
        goal = self._beside(point, heading_rad, step.side)
        yaw = self.yaw[first, step.side]
        self.ankles[span, step.side, :2] = origin + ease[:, None] * (goal - origin)
        self.ankles[span, step.side, 2] = self._ankle_m + LIFT_M * np.sin(np.pi * share) ** 2
        self.yaw[span, step.side] = yaw + ease * (heading_rad - yaw)
        self.landing[span, step.side] = step.land_s - self._times[span]

        self.ankles[after, step.side, :2] = goal
        self.ankles[after, step.side, 2] = self._ankle_m
        self.yaw[after, step.side] = heading_rad
        self.last_side = step.side
        self.landed_s = step.land_s

    def weight(self, span: slice) -> Array:
        """(T,) share of the weight on the left foot: all of it on one foot while the other swings, smoothed between."""
        return np.asarray(smoothed(_standing_share(self.landing[span]), self._kernel))

    def zero_moment_point(self, span: slice, weight: Array, ahead_m: float) -> Array:
        """(T, 2) zero-moment point: between two points ``ahead_m`` before the ankles, by the share of weight [m]."""
        yaw = self.yaw[span]
        soles = self.ankles[span, :, :2] + ahead_m * np.stack([np.cos(yaw), np.sin(yaw)], axis=2)
        return np.asarray(weight[:, None] * soles[:, 0] + (1.0 - weight[:, None]) * soles[:, 1])


@compiled_entry
def _standing_share(landing: Array) -> Array:
    """(T,) 0 while the left foot swings, 1 while the right one does, else 0.5; from times until landing (T, 2) [s]."""
    out = np.empty(len(landing))
    for t in range(len(landing)):
        out[t] = 0.0 if landing[t, 0] > 0 else 1.0 if landing[t, 1] > 0 else 0.5
    return out


def smoothing_kernel(reach_s: float, dt_s: float) -> Array:
    """(K,) weights of a smoothing over ``reach_s`` before and after a tick; they add up to 1."""
    kernel = np.hanning(2 * round(reach_s / dt_s) + 3)[1:-1]
    return np.asarray(kernel / kernel.sum())


@compiled_entry
def smoothed(raw: Array, kernel: Array) -> Array:
    """(T,) signal convolved with a symmetric kernel; beyond its ends it continues with its first and last value."""
    out = np.zeros_like(raw)
    half = len(kernel) // 2
    last = len(raw) - 1

    for t in range(len(raw)):
        for k in range(len(kernel)):
            out[t] += kernel[k] * raw[min(max(t + k - half, 0), last)]
    return out


@compiled_entry
def pelvis_height(pelvis: Array, yaw: Array, ankles: Array, leg: Array, standing_m: float, kernel: Array) -> Array:
    """(T,) height of the pelvis: that of standing, smoothly lowered where a leg could not reach its ankle [m].

    Args:
        pelvis: (T, 2 or more) place on the floor [m].
        yaw: (T,) heading [rad].
        ankles: (T, 2, 3) left and right [m].
        leg: thigh, shank, half hip distance, as in `Chains.leg` [m].
        standing_m: height of the standing pelvis.
        kernel: weights of the smoothing.
    """
    reach = (leg[0] + leg[1] - REACH_MARGIN_M) ** 2
    height = np.full(len(yaw), standing_m)

    for t in range(len(yaw)):
        for side in range(2):
            half = leg[2] if side == 0 else -leg[2]
            x = ankles[t, side, 0] - pelvis[t, 0] + half * np.sin(yaw[t])
            y = ankles[t, side, 1] - pelvis[t, 1] - half * np.cos(yaw[t])
            # The bound keeps the root real where an ankle is out of reach at any height.
            height[t] = min(height[t], np.sqrt(max(reach - x * x - y * y, 0.04)) + ankles[t, side, 2])

    lowered: Array = np.minimum(smoothed(height, kernel), height + MAX_RISE_M)
    return lowered
