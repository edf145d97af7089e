"""Footsteps: when and where each foot swings, and how the weight and the zero-moment point follow.

Step times and the height of a swing are assumed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from ...core import Array
from .reference_trajectory import ReferenceTrajectory
from .speed_profile import SpeedProfile, smooth

STEP_S = 0.50
"""Usual time from one step to the next [s]: about a beat at 118 BPM."""
LEAD_S = 0.30
"""A walk's first step begins so long before the start event [s]; then no foot leaves the floor, which shows in the
pelvis as a ripple, while the speed passes its onset."""
TRAIL_S = 0.12
"""A walk's last step ends so long after the stop event [s]."""
SUPPORT_SHARE = 0.22
"""Share of a step during which both feet stand."""
LIFT_M = 0.05
"""Height of a swing [m]."""
SHIFT_S = 0.12
"""Smoothing of the weight's passage between the feet [s]."""


@dataclass(frozen=True, slots=True)
class Step:
    """One swing: side 0 left, 1 right; from lift-off to touch-down [s]; where it lands along the move.

    ``along`` is a way in metres for a walk and a share of the angle for a turn.
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


def walk(profile: SpeedProfile, t_s: float, last_side: int, free_s: float) -> Walk:
    """Steps that keep the pelvis' profile over the feet: each foot lands where the body is at its next mid-stance.

    Args:
        profile: the pelvis' speed.
        t_s: start event.
        last_side: the foot that swung last; the other one begins.
        free_s: when it has landed; the walk's steps wait for it.
    """
    begin = max(t_s - LEAD_S, free_s)
    whole = t_s + profile.duration_s + TRAIL_S - begin
    count = max(2, round(whole / STEP_S))
    slot = whole / count
    pause = 0.5 * SUPPORT_SHARE * slot
    middles: Array = begin + (np.arange(count, dtype=np.float64) + 1.5) * slot - t_s
    ways = profile.travelled(middles)
    ways[-2:] = profile.distance_m
    steps = []
    for j in range(count):
        lift, land = begin + j * slot + pause, begin + (j + 1) * slot - pause
        steps.append(Step((last_side + 1 + j) % 2, lift, land, float(ways[j])))
    return Walk(tuple(steps), begin, begin + whole, slot)


def turn(t_s: float, duration_s: float, free_s: float) -> tuple[Step, ...]:
    """Four steps of a turn on the spot to the left: left, right to half the angle, then both to all of it.

    Args:
        t_s: when the turn begins.
        duration_s: how long it takes.
        free_s: when the step before it has landed; the turn's steps wait for it.
    """
    begin = max(t_s, free_s)
    slot = (t_s + duration_s - begin) / 4
    pause = 0.5 * SUPPORT_SHARE * slot
    return tuple(
        Step(j % 2, begin + j * slot + pause, begin + (j + 1) * slot - pause, 0.5 if j < 2 else 1.0) for j in range(4)
    )


class Feet:
    """Both feet on the grid of control ticks.

    Args:
        slot: (2,) where the dancer stands [m].
        heading_rad: initial heading.
        hip_m: half the distance between the feet.
        ankle_m: height of a standing foot's ankle.
        times: (T,) ticks [s].
        reference: where the feet are written, up to its last planned row: ankles, foot_yaw, landing.
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
        self._dt = float(times[1] - times[0])
        self.ankles, self.yaw, self.landing = reference.ankles, reference.foot_yaw, reference.landing
        self._kernel = easing(SHIFT_S / 2, self._dt)
        self._until = reference.planned_rows
        known = slice(0, int(self._until[0]))
        self.yaw[known] = heading_rad
        for side in range(2):
            self.ankles[known, side, :2] = self._beside(slot, heading_rad, side)
        self.ankles[known, :, 2] = ankle_m
        self.last = 1
        self.settled_s = 0.0

    def _beside(self, point: Array, heading_rad: float, side: int) -> Array:
        half = self._hip_m if side == 0 else -self._hip_m
        return point + half * np.array([-np.sin(heading_rad), np.cos(heading_rad)])

    def swing(self, step: Step, point: Array, heading_rad: float) -> None:
        """Swing a foot to its place beside ``point`` (2,) at a heading; it stays there."""
        until = int(self._until[0])
        first, last = (min(int(tick), until - 1) for tick in np.searchsorted(self._times, (step.lift_s, step.land_s)))
        span, after = slice(first, last), slice(last, until)
        share = (self._times[span] - step.lift_s) / (step.land_s - step.lift_s)
        ease = smooth(share)
        origin, goal = self.ankles[first, step.side, :2].copy(), self._beside(point, heading_rad, step.side)
        yaw = self.yaw[first, step.side]
        self.ankles[span, step.side, :2] = origin + ease[:, None] * (goal - origin)
        self.ankles[span, step.side, 2] = self._ankle_m + LIFT_M * np.sin(np.pi * share) ** 2
        self.yaw[span, step.side] = yaw + ease * (heading_rad - yaw)
        self.landing[span, step.side] = step.land_s - self._times[span]
        self.ankles[after, step.side, :2] = goal
        self.ankles[after, step.side, 2] = self._ankle_m
        self.yaw[after, step.side] = heading_rad
        self.last = step.side
        self.settled_s = step.land_s

    def weight(self, span: slice) -> Array:
        """(T,) share of the weight on the left foot: all on one while the other swings, eased in between."""
        return np.asarray(eased(_standing(self.landing[span]), self._kernel))

    def zmp(self, span: slice, weight: Array, ahead_m: float) -> Array:
        """(T, 2) zero-moment point: between the soles' middles, ``ahead_m`` before the ankles [m]."""
        yaw = self.yaw[span]
        soles = self.ankles[span, :, :2] + ahead_m * np.stack([np.cos(yaw), np.sin(yaw)], axis=2)
        return np.asarray(weight[:, None] * soles[:, 0] + (1.0 - weight[:, None]) * soles[:, 1])


@njit(cache=True)
def _standing(landing: Array) -> Array:
    """(T,) 0 while the left foot swings, 1 while the right one does, else a half; (T, 2) times to landing [s]."""
    out = np.empty(len(landing))
    for t in range(len(landing)):
        out[t] = 0.0 if landing[t, 0] > 0 else 1.0 if landing[t, 1] > 0 else 0.5
    return out


def easing(reach_s: float, dt_s: float) -> Array:
    """Weights (K,) of a smooth mean over so long before and after a tick."""
    kernel = np.hanning(2 * round(reach_s / dt_s) + 3)[1:-1]
    return np.asarray(kernel / kernel.sum())


@njit(cache=True)
def eased(raw: Array, kernel: Array) -> Array:
    """(T,) smooth mean of a signal that goes on as it begins and ends."""
    out, half, last = np.zeros_like(raw), len(kernel) // 2, len(raw) - 1
    for t in range(len(raw)):
        for k in range(len(kernel)):
            out[t] += kernel[k] * raw[min(max(t + k - half, 0), last)]
    return out


@njit(cache=True)
def pelvis_height(pelvis: Array, yaw: Array, ankles: Array, leg: Array, standing_m: float, kernel: Array) -> Array:
    """(T,) height of the pelvis: standing height, lower where a leg could not reach, smoothly so [m].

    Args:
        pelvis: (T, 2 or more) place on the floor [m].
        yaw: (T,) heading [rad].
        ankles: (T, 2, 3) left and right [m].
        leg: thigh, shank, half hip distance, as in `Chains.leg` [m].
        standing_m: height of the standing pelvis.
        kernel: weights of the smoothing.
    """
    reach = (leg[0] + leg[1] - 0.010) ** 2
    height = np.full(len(yaw), standing_m)
    for t in range(len(yaw)):
        for side in range(2):
            half = leg[2] if side == 0 else -leg[2]
            x = ankles[t, side, 0] - pelvis[t, 0] + half * np.sin(yaw[t])
            y = ankles[t, side, 1] - pelvis[t, 1] - half * np.cos(yaw[t])
            height[t] = min(height[t], np.sqrt(max(reach - x * x - y * y, 0.04)) + ankles[t, side, 2])
    lowered: Array = np.minimum(eased(height, kernel), height + 0.006)
    return lowered
