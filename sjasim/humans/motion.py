"""From cues to motion: footsteps on time, a centre-of-mass plan that the feet can carry, joint targets.

Along the heading the pelvis follows a speed profile that crosses the onset speed exactly at the cue's times, and
footholds are put under it. Across the heading the centre of mass follows from the weight changing feet (linear
inverted pendulum, divergent component previewed backwards). Legs are closed-form.

Source: englsberger2015, section III (divergent component of motion); kajita2014, section 4 (zero-moment point).
The speed profile's shape, step times and arm swing are assumed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

from ..assets.names import ACTUATED_INDEX, ARM_JOINTS, LEG_JOINTS
from ..errors import ConfigError
from ..types import Array, Cue, Move
from . import arms, footsteps
from .anatomy import Anatomy
from .dynamics import hinge_torques
from .kinematics import com_offsets, legs
from .profile import SHORTEST_S, SpeedProfile, smooth, speed_profile
from .reference import Reference

GRAVITY = 9.81
LEG_COLUMNS = np.array([[ACTUATED_INDEX[f"{joint}_{side}"] for joint in LEG_JOINTS] for side in "LR"])
ARM_COLUMNS = np.array([ACTUATED_INDEX[f"{joint}_{side}"] for side in "LR" for joint in ARM_JOINTS])
PREVIEW_S = 1.2
"""How far before a cue its motion begins to show; cues should be known this early."""
LEAN_S_M = 0.15
"""The trunk leans into a walk by this angle per speed [rad s/m] (assumed)."""
LEAN_LEAD_S = 0.10
"""And does so this early: people lean before they step (assumed)."""
SHORTEST_TURN_S = 1.0
"""Four steps of a turn take at least so long [s] (assumed)."""
EASE_SHARE = 0.15
"""In a turn the pelvis follows the balance rather than a line; it passes over to it, and back, in this share of it."""
LAGS_S = {Move.FORWARD: (-0.006, 0.0), Move.BACKWARD: (0.003, 0.009)}
"""How late bodies cross the onset speed behind their plan at a start and at a stop [s]; the plan leads by as much.

Measured on six builds over the whole range, which dance with people's jitter.
"""
SETTLE_S = 1.5
"""After the last touch-down a plan stands still within this time."""


@njit(cache=True)
def _pendulum(zmp: Array, omega_dt: float, first: Array) -> Array:
    """(T, 2) centre of mass that stays bounded over a ZMP path (T, 2), starting at ``first`` (2,) [m]."""
    n = len(zmp)
    decay = np.exp(-omega_dt)
    xi = np.empty_like(zmp)
    com = np.empty_like(zmp)
    for k in range(2):
        xi[n - 1, k] = zmp[n - 1, k]
        for i in range(n - 2, -1, -1):
            xi[i, k] = zmp[i + 1, k] + (xi[i + 1, k] - zmp[i + 1, k]) * decay
        com[0, k] = first[k]
        for i in range(1, n):
            com[i, k] = xi[i, k] + (com[i - 1, k] - xi[i, k]) * decay
    return com


class Planner:
    """Plans one dancer, cue by cue; what lies before the present is never touched again.

    Args:
        anatomy: the dancer's build.
        slot: (2,) where the dancer stands and returns to [m].
        heading_rad: initial heading.
        move_m: nominal length of a move.
        turn_rad: angle of a turn, counter-clockwise positive.
        rate_hz: control rate.
        reference: where the plan is written, one row per control tick.
    """

    def __init__(
        self,
        anatomy: Anatomy,
        slot: Array,
        heading_rad: float,
        move_m: float,
        turn_rad: float,
        rate_hz: int,
        reference: Reference,
    ) -> None:
        self._anatomy = anatomy
        self._chains = anatomy.chains()
        self._poses = arms.arm_poses(anatomy.model)
        self._slot: Array = np.asarray(slot, dtype=np.float64)
        self._move_m, self._turn_rad = move_m, turn_rad
        self._dt = 1.0 / rate_hz
        self._ahead = 0.026 * anatomy.build.stature_m
        self._heading = heading_rad
        self._at = self._slot
        self._busy_until_s = 0.0
        ticks = len(reference.yaw)
        self._times: Array = np.arange(ticks, dtype=np.float64) * self._dt
        self._arms = np.tile(self._poses.stand, (ticks, 2))
        self._trunk = np.zeros(ticks)
        self._path: Array = np.tile(self._slot, (ticks, 1))
        self._axis = np.full(ticks, heading_rad)
        self._free = np.zeros(ticks)
        self._com = np.zeros((ticks, 2))
        self._omega = float(np.sqrt(GRAVITY / (1.04 * anatomy.standing_m)))
        self._reference = reference
        self._yaw = reference.yaw
        self._yaw[:] = heading_rad
        self._steps = footsteps.Feet(self._slot, heading_rad, anatomy.hip_m, anatomy.ankle_m, self._times, reference)
        self._stand(heading_rad)

    def _stand(self, heading_rad: float) -> None:
        """Find the posture at rest and how far the pelvis is ahead of the ankles in it."""
        posture = np.zeros((1, 25))
        posture[:, ARM_COLUMNS] = self._arms[:1]
        half, ankle = self._anatomy.hip_m, self._anatomy.ankle_m
        flat = np.array([[[0.0, half, ankle], [0.0, -half, ankle]]])
        pelvis = np.array([[0.0, 0.0, self._anatomy.standing_m]])
        for _ in range(5):
            legs(pelvis, np.zeros(1), flat, np.zeros((1, 2)), self._chains.leg, posture, LEG_COLUMNS)
            pelvis[0, 0] = self._ahead - float(self._offsets(posture, np.zeros(1))[0, 0])
        self._lean = float(pelvis[0, 0])
        self._com[:] = self._slot + self._ahead * _unit(heading_rad)
        self._solve(0)

    @property
    def omega(self) -> float:
        """Rate of the pendulum that the plan assumes [1/s]."""
        return self._omega

    def extend(self, cues: Sequence[Cue], now_s: float) -> None:
        """Plan further cues, in order of time.

        Args:
            cues: moves that follow everything planned so far.
            now_s: the present; motion before it stays as it was.

        Raises:
            ConfigError: a cue lies in the past, begins before the one before it has ended, or is too short.
        """
        for cue in cues:
            self._check(cue, now_s)
            if cue.move in (Move.FORWARD, Move.BACKWARD):
                self._walk(cue, now_s)
            elif cue.move is Move.TURN:
                self._turn(cue)
            elif cue.move is Move.CLAP:
                arms.clap(self._arms, self._times, cue.t_s, self._poses)
            self._busy_until_s = cue.t_s + cue.duration_s
        if cues:
            self._solve(max(0, int(max(now_s, cues[0].t_s - PREVIEW_S) / self._dt)))

    def _check(self, cue: Cue, now_s: float) -> None:
        name = f"{cue.dancer}: {cue.move} cue"
        earliest = max(self._busy_until_s, now_s)
        if not earliest - 1e-9 <= cue.t_s < np.inf:
            raise ConfigError(
                f"{name}.t_s", cue.t_s, f"{earliest:.3f} s or later, after the present and the move before it"
            )
        shortest = {Move.CLAP: 0.0, Move.TURN: SHORTEST_TURN_S}.get(cue.move, SHORTEST_S)
        if not shortest <= cue.duration_s < np.inf:
            raise ConfigError(f"{name}.duration_s", cue.duration_s, f"{shortest:g} s or longer")

    def _walk(self, cue: Cue, now_s: float) -> None:
        sign = 1.0 if cue.move is Move.FORWARD else -1.0
        ahead = float((self._at - self._slot) @ _unit(self._heading))
        wanted = self._move_m - ahead if cue.move is Move.FORWARD else ahead
        start_lag, stop_lag = LAGS_S[cue.move]
        start_s = cue.t_s - start_lag
        profile = speed_profile(max(wanted, 0.0), cue.duration_s + start_lag - stop_lag)
        way = sign * _unit(self._heading)
        moving = self._times > start_s - profile.rise_s
        self._path[moving] += profile.travelled(self._times[moving] - start_s)[:, None] * way
        plan = footsteps.walk(profile, start_s, self._steps.last, max(self._steps.settled_s, now_s))
        for step in plan.steps:
            self._steps.swing(step, self._at + step.along * way, self._heading)
        self._at = self._at + profile.distance_m * way
        since = self._times + LEAN_LEAD_S - start_s
        near = (since > -profile.rise_s) & (since < profile.duration_s + profile.rise_s)
        self._trunk[near] += sign * LEAN_S_M * profile.speed(since[near])
        self._swing_arms(start_s, profile, plan)

    def _swing_arms(self, start_s: float, profile: SpeedProfile, plan: footsteps.Walk) -> None:
        span = (self._times >= plan.start_s) & (self._times <= plan.end_s)
        speed = profile.speed(self._times[span] - start_s)
        swing = -np.cos(np.pi * (self._times[span] - plan.start_s) / plan.step_s)
        arms.walk(self._arms, span, speed, swing if plan.steps[0].side == 1 else -swing)

    def _turn(self, cue: Cue) -> None:
        after = slice(int(np.searchsorted(self._times, cue.t_s)), None)
        since = (self._times[after] - cue.t_s) / cue.duration_s
        self._yaw[after] = self._heading + self._turn_rad * smooth(since)
        for step in footsteps.turn(cue.t_s, cue.duration_s, self._steps.settled_s):
            self._steps.swing(step, self._at, self._heading + self._turn_rad * step.along)
        self._heading += self._turn_rad
        self._axis[after][since >= 0.5] = self._heading
        self._free[after] = smooth(since / EASE_SHARE) * smooth((1.0 - since) / EASE_SHARE)

    def _offsets(self, joints: Array, yaw: Array) -> Array:
        c = self._chains
        return np.asarray(
            com_offsets(
                joints, yaw, c.parent, c.offset, c.mass, c.centre, c.hinge_segment, c.hinge_column,
                c.hinge_axis, c.hinge_sign,
            )
        )  # fmt: skip

    def _solve(self, first: int) -> None:
        """Redo centre of mass, pelvis and joints from a tick on; after the last step all stands still."""
        r = self._reference
        settled = int((max(self._steps.settled_s, self._busy_until_s) + SETTLE_S) / self._dt)
        last = min(len(self._times), max(first + 2, settled))
        span = slice(first, last)
        weight = self._steps.weight(span)
        com = _pendulum(self._steps.zmp(span, weight, self._ahead), self._omega * self._dt, self._com[first])
        axis = np.stack([np.cos(self._axis[span]), np.sin(self._axis[span])], axis=1)
        along = ((self._path[span] * axis).sum(axis=1, keepdims=True) + self._lean) * axis
        free = self._free[span][:, None]
        joints = np.zeros((last - first, 25))
        joints[:, ARM_COLUMNS] = self._arms[span]
        joints[:, ACTUATED_INDEX["abdomen_y"]] = self._trunk[span]
        offset = np.zeros((last - first, 2))
        pelvis = np.empty((last - first, 3))
        for _ in range(2):
            loose = com - offset
            across = loose - (loose * axis).sum(axis=1, keepdims=True) * axis
            pelvis[:, :2] = free * loose + (1.0 - free) * (across + along)
            pelvis[:, 2] = footsteps.pelvis_height(pelvis, self._yaw[span], r.ankles[span], self._anatomy, self._dt)
            legs(pelvis, self._yaw[span], r.ankles[span], r.foot_yaw[span], self._chains.leg, joints, LEG_COLUMNS)
            offset = self._offsets(joints, self._yaw[span])[:, :2]
        real = pelvis[:, :2] + offset
        r.joints[span], r.pelvis[span], r.weight[span], self._com[span] = joints, pelvis, weight, com
        r.dcm[span] = real + np.gradient(real, self._dt, axis=0) / self._omega
        r.torque[span] = hinge_torques(self._chains, joints, pelvis, self._yaw[span], r.ankles[span], weight, self._dt)
        for array in (r.joints, r.pelvis, r.torque, r.weight, r.dcm, self._com):
            array[last:] = array[last - 1]


def _unit(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])
