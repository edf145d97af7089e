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

from ...assets.names import ACTUATED_INDEX, ARM_JOINTS, LEG_JOINTS
from ...core import Array, Cue, Move
from ...core.errors import ConfigError
from ..body.anatomy import Anatomy
from ..body.inverse_dynamics import hinge_torques, place_chains
from ..body.kinematics import com_offsets, leg_angles
from . import arms, footsteps
from .reference_trajectory import ReferenceTrajectory
from .speed_profile import SHORTEST_S, SpeedProfile, smooth, speed_profile

GRAVITY = 9.81
LEG_COLUMNS = np.array([[ACTUATED_INDEX[f"{joint}_{side}"] for joint in LEG_JOINTS] for side in "LR"])
ARM_COLUMNS = np.array([ACTUATED_INDEX[f"{joint}_{side}"] for side in "LR" for joint in ARM_JOINTS])
PREVIEW_S = 1.2
"""How far before a cue its motion begins to show; cues should be known this early."""
LEAN_S_M = 0.15
"""The trunk leans into a walk by this angle per speed [rad s/m] (assumed)."""
LEAN_LEAD_S = 0.10
"""And does so this early: people lean before they step (assumed)."""
MIN_TURN_S = 1.0
"""Four steps of a turn take at least so long [s] (assumed)."""
EASE_SHARE = 0.15
"""In a turn the pelvis follows the balance rather than a line; it passes over to it, and back, in this share of it."""
HASTE_LAG_S, HASTE_S = 0.048, 1.2
"""A move shorter than the second is stopped late by the first times what it lacks, for its feet still come together;
measured as below, on moves of .8 s."""
HEIGHT_EASE_S = 0.12
"""The pelvis goes down before a long step, and up after it, within this time (assumed)."""
STANDING_ROWS = 2
"""A plan begins with so many rows of standing."""
LAGS_S = {Move.FORWARD: (-0.006, 0.0), Move.BACKWARD: (0.003, 0.009)}
"""How late bodies cross the onset speed behind their plan at a start and at a stop [s]; the plan leads by as much.

Measured on six builds over the whole range, which dance with people's jitter.
"""
ASIDE = 0.25
"""A dancer beside the slot walks at most by this way sideways per way ahead: back in line in a move or two, and never
one foot into the other (assumed)."""
AFTER_S = 1.6
"""So long after its end a move has come to rest: the feet stand, the arms hang, the sway is gone (assumed)."""


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


@njit(cache=True)
def _put(path: Array, axis: Array, free: Array, com: Array, offset: Array, lean: float, pelvis: Array) -> None:
    """Write the pelvis' place on the floor: on its path along the heading, under the centre of mass across it.

    Args:
        path: (T, 2) where the pelvis is to be [m].
        axis: (T, 2) unit vectors along the heading.
        free: (T,) share in which it follows the centre of mass alone.
        com: (T, 2) centre of mass [m].
        offset: (T, 2) how far it is before the pelvis [m].
        lean: how far the pelvis is before its path [m].
        pelvis: (T, 3) output.
    """
    for t in range(len(path)):
        ahead_x, ahead_y, share = axis[t, 0], axis[t, 1], free[t]
        along = path[t, 0] * ahead_x + path[t, 1] * ahead_y + lean
        x, y = com[t, 0] - offset[t, 0], com[t, 1] - offset[t, 1]
        off = x * ahead_x + y * ahead_y
        pelvis[t, 0] = share * x + (1.0 - share) * ((x - off * ahead_x) + along * ahead_x)
        pelvis[t, 1] = share * y + (1.0 - share) * ((y - off * ahead_y) + along * ahead_y)


@njit(cache=True)
def _divergent(com: Array, dt_s: float, omega: float, out: Array) -> None:
    """Write the divergent component (T, 2) of a motion of the centre of mass (T, 2 or more) [m]."""
    last = len(com) - 1
    for t in range(last + 1):
        a, b = max(t - 1, 0), min(t + 1, last)
        per = 2.0 * dt_s if b - a == 2 else dt_s
        for k in range(2):
            out[t, k] = com[t, k] + (com[b, k] - com[a, k]) / per / omega


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
        reference: ReferenceTrajectory,
    ) -> None:
        self._anatomy = anatomy
        self._chains = anatomy.chains()
        self._poses = arms.arm_poses(anatomy.model)
        self._slot: Array = np.asarray(slot, dtype=np.float64)
        self._move_m, self._turn_rad = move_m, turn_rad
        self._dt = 1.0 / rate_hz
        self._ahead = 0.026 * anatomy.build.stature_m
        self._share: Array = self._chains.point_mass / self._chains.point_mass.sum()
        self._heading = heading_rad
        self._at = self._slot
        self._busy_until_s = 0.0
        ticks = len(reference.yaw)
        self._times: Array = np.arange(ticks, dtype=np.float64) * self._dt
        self._arms, self._trunk, self._path, self._axis, self._free, self._com = (
            np.full((ticks, *shape), 0.0) for shape in ((8,), (), (2,), (), (), (2,))
        )
        self._omega = float(np.sqrt(GRAVITY / (1.04 * anatomy.standing_m)))
        self._kernel = footsteps.easing(HEIGHT_EASE_S, self._dt)
        self._reference = r = reference
        self._columns = (
            self._arms, self._trunk, self._path, self._axis, self._free, self._com, r.joints, r.pelvis, r.yaw, r.dcm,
            r.weight, r.ankles, r.foot_yaw, r.landing, r.torque,
        )  # fmt: skip
        r.planned_rows[:] = STANDING_ROWS
        self._steps = footsteps.Feet(self._slot, heading_rad, anatomy.hip_m, anatomy.ankle_m, self._times, reference)
        self._stand(heading_rad)

    def _stand(self, heading_rad: float) -> None:
        """Find the posture at rest and how far the pelvis is ahead of the ankles in it."""
        posture = np.zeros((1, 25))
        posture[:, ARM_COLUMNS] = np.tile(self._poses.stand, 2)
        half, ankle = self._anatomy.hip_m, self._anatomy.ankle_m
        flat = np.array([[[0.0, half, ankle], [0.0, -half, ankle]]])
        pelvis = np.array([[0.0, 0.0, self._anatomy.standing_m]])
        for _ in range(5):
            leg_angles(pelvis, np.zeros(1), flat, np.zeros((1, 2)), self._chains.leg, posture, LEG_COLUMNS)
            pelvis[0, 0] = self._ahead - float(com_offsets(self._chains, posture, np.zeros(1))[0, 0])
        self._lean = float(pelvis[0, 0])
        known = slice(0, STANDING_ROWS)
        self._arms[known] = posture[0, ARM_COLUMNS]
        self._path[known], self._axis[known], self._reference.yaw[known] = self._slot, heading_rad, heading_rad
        self._com[known] = self._slot + self._ahead * _unit(heading_rad)
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
        first: int | None = None
        for cue in cues:
            self._check(cue, now_s)
            begin = int(max(now_s, cue.t_s - PREVIEW_S) / self._dt)
            self._rest_until(int((cue.t_s + cue.duration_s + AFTER_S) / self._dt))
            window = slice(min(begin, int(self._reference.planned_rows[0]) - 2), int(self._reference.planned_rows[0]))
            if cue.move in (Move.FORWARD, Move.BACKWARD):
                self._walk(cue, now_s, window)
            elif cue.move is Move.TURN:
                self._turn(cue, window)
            elif cue.move is Move.CLAP:
                arms.clap(self._arms[window], self._times[window], cue.t_s, self._poses)
            self._busy_until_s = cue.t_s + cue.duration_s
            first = window.start if first is None else first
        if first is not None:
            self._solve(first)

    def _rest_until(self, row: int) -> None:
        """Plan rest up to a row, if it is not planned already."""
        known, row = int(self._reference.planned_rows[0]), min(row, len(self._times))
        if row > known:
            for column in self._columns:
                column[known:row] = column[known - 1]
            self._reference.planned_rows[0] = row

    def _check(self, cue: Cue, now_s: float) -> None:
        name = f"{cue.dancer}: {cue.move} cue"
        earliest = max(self._busy_until_s, now_s)
        if not earliest - 1e-9 <= cue.t_s < np.inf:
            raise ConfigError(
                f"{name}.t_s", cue.t_s, f"{earliest:.3f} s or later, after the present and the move before it"
            )
        shortest = {Move.CLAP: 0.0, Move.TURN: MIN_TURN_S}.get(cue.move, SHORTEST_S)
        if not shortest <= cue.duration_s < np.inf:
            raise ConfigError(f"{name}.duration_s", cue.duration_s, f"{shortest:g} s or longer")

    def _walk(self, cue: Cue, now_s: float, window: slice) -> None:
        sign = 1.0 if cue.move is Move.FORWARD else -1.0
        ahead = float((self._at - self._slot) @ _unit(self._heading))
        wanted = self._move_m - ahead if cue.move is Move.FORWARD else ahead
        start_lag, stop_lag = LAGS_S[cue.move]
        stop_lag += HASTE_LAG_S * max(HASTE_S - cue.duration_s, 0.0)
        start_s = cue.t_s - start_lag
        profile = speed_profile(max(wanted, 0.0), cue.duration_s + start_lag - stop_lag)
        way = sign * _unit(self._heading) + self._aside(profile.distance_m)
        since = self._times[window] - start_s
        self._path[window] += profile.travelled(since)[:, None] * way
        plan = footsteps.walk(profile, start_s, self._steps.last, max(self._steps.settled_s, now_s))
        for step in plan.steps:
            self._steps.swing(step, self._at + step.along * way, self._heading)
        self._at = self._at + profile.distance_m * way
        self._trunk[window] += sign * LEAN_S_M * profile.speed(since + LEAN_LEAD_S)
        self._swing_arms(start_s, profile, plan, window)

    def _aside(self, distance_m: float) -> Array:
        """(2,) how far a move also leads back beside the slot, per way ahead."""
        beside = _unit(self._heading + np.pi / 2.0)
        off = float((self._slot - self._at) @ beside) / distance_m
        return np.asarray(min(max(off, -ASIDE), ASIDE) * beside)

    def _swing_arms(self, start_s: float, profile: SpeedProfile, plan: footsteps.Walk, window: slice) -> None:
        times = self._times[window]
        span = (times >= plan.start_s) & (times <= plan.end_s)
        speed = profile.speed(times[span] - start_s)
        swing = -np.cos(np.pi * (times[span] - plan.start_s) / plan.step_s)
        arms.walk(self._arms[window], span, speed, swing if plan.steps[0].side == 1 else -swing)

    def _turn(self, cue: Cue, window: slice) -> None:
        since = (self._times[window] - cue.t_s) / cue.duration_s
        self._reference.yaw[window] = self._heading + self._turn_rad * smooth(since)
        for step in footsteps.turn(cue.t_s, cue.duration_s, self._steps.settled_s):
            self._steps.swing(step, self._at, self._heading + self._turn_rad * step.along)
        self._heading += self._turn_rad
        self._axis[window][since >= 0.5] = self._heading
        self._free[window] = smooth(since / EASE_SHARE) * smooth((1.0 - since) / EASE_SHARE)

    def _solve(self, first: int) -> None:
        """Redo centre of mass, pelvis and joints from a row on, to the last that is planned."""
        r = self._reference
        span = slice(first, int(r.planned_rows[0]))
        yaw, ankles, weight = self._reference.yaw[span], r.ankles[span], self._steps.weight(span)
        com = _pendulum(self._steps.zmp(span, weight, self._ahead), self._omega * self._dt, self._com[first])
        axis = np.stack([np.cos(self._axis[span]), np.sin(self._axis[span])], axis=1)
        joints = np.zeros((len(yaw), 25))
        joints[:, ARM_COLUMNS] = self._arms[span]
        joints[:, ACTUATED_INDEX["abdomen_y"]] = self._trunk[span]
        pelvis, offset = np.empty((len(yaw), 3)), (self._ahead - self._lean) * axis
        for final in (False, True):
            _put(self._path[span], axis, self._free[span], com, offset, self._lean, pelvis)
            pelvis[:, 2] = footsteps.pelvis_height(
                pelvis, yaw, ankles, self._chains.leg, self._anatomy.standing_m, self._kernel
            )
            leg_angles(pelvis, yaw, ankles, r.foot_yaw[span], self._chains.leg, joints, LEG_COLUMNS)
            if not final:
                offset = com_offsets(self._chains, joints, yaw)
        placed = place_chains(self._chains, joints, pelvis, yaw)
        r.joints[span], r.pelvis[span], r.weight[span], self._com[span] = joints, pelvis, weight, com
        _divergent(np.asarray(self._share @ placed.points), self._dt, self._omega, r.dcm[span])
        r.torque[span] = hinge_torques(self._chains, placed, ankles, weight, self._dt)


def _unit(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])
