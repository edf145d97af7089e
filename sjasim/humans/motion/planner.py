"""The motion planner of a dancer: from cues to footsteps, a feasible centre of mass, joint targets and torques.

Along the heading the pelvis follows a speed profile that crosses the onset speed exactly at the cue's times, and
footsteps are placed under it. Across the heading the centre of mass follows from the weight shift between the feet, as
a linear inverted pendulum. Leg angles are in closed form.

Source: englsberger2015, section III (divergent component of motion); kajita2014, section 4 (zero-moment point). The
shape of the speed profile, step times and arm swing are assumed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...assets.names import ACTUATED_INDEX, ARM_JOINTS, LEG_JOINTS
from ...core import Array, Cue, Move
from ...core.compiled import compiled_entry
from ...core.errors import ConfigError
from ..body.anatomy import Anatomy
from ..body.inverse_dynamics import GRAVITY, hinge_torques, place_chains
from ..body.kinematics import com_offsets, leg_angles
from . import arms, footsteps
from .pendulum import bounded_com, write_divergent_component
from .reference_trajectory import ReferenceTrajectory
from .speed_profile import MIN_DURATION_S, SpeedProfile, minimum_jerk, speed_profile

LEG_COLUMNS = np.array([[ACTUATED_INDEX[f"{joint}_{side}"] for joint in LEG_JOINTS] for side in "LR"])
"""(2, 6) columns of the left and the right leg's hinges."""

ARM_COLUMNS = np.array([ACTUATED_INDEX[f"{joint}_{side}"] for side in "LR" for joint in ARM_JOINTS])
"""(8,) columns of the left and the right arm's hinges."""

PREVIEW_S = 1.2
"""Time before a cue at which its motion begins to show [s]; cues should be known this early."""

MIN_TURN_S = 1.0
"""Shortest turn, which has four steps [s] (assumed)."""

LEAN_S_M = 0.15
"""Angle by which the trunk leans into a walk, per speed [rad s/m] (assumed)."""

LEAN_LEAD_S = 0.10
"""Time by which this lean comes before the speed: people lean before they step [s] (assumed)."""

BLEND_SHARE = 0.15
"""Share of a turn in which the pelvis passes over from its path to the centre of mass, and at the end back."""

SHORT_MOVE_S = 1.2
"""A move shorter than this stops late, because its feet come together after the pelvis stops [s]."""

SHORT_MOVE_LAG = 0.048
"""This lateness per second by which the move is shorter; measured as `LAGS_S`, on moves of .8 s."""

HEIGHT_SMOOTHING_S = 0.12
"""Time within which the pelvis goes down before a long step, and up after it [s] (assumed)."""

STANDING_ROWS = 2
"""Number of rows of standing with which a plan begins."""

LAGS_S = {Move.FORWARD: (-0.006, 0.0), Move.BACKWARD: (0.003, 0.009)}
"""Move -> lateness with which bodies cross the onset speed behind their plan, at the start and at the stop [s].

The plan leads by as much. Measured on six builds over the whole range that perform with the timing noise of people.
"""

MAX_SIDEWAYS = 0.25
"""A dancer beside the slot returns to it during moves, by at most this distance sideways per distance along the
heading, at which no foot is set into the other (assumed)."""

SETTLING_S = 1.6
"""Time after a move until the dancer rests: the feet stand, the arms hang, the sway is gone [s] (assumed)."""

SOLE_CENTRE = 0.026
"""Distance from the ankles forward to the point of the sole that carries the weight, as a share of stature."""

PENDULUM_HEIGHT = 1.04
"""Height of the centre of mass, as a share of the standing pelvis' height."""


@compiled_entry
def _place_pelvis(path: Array, axis: Array, free: Array, com: Array, offset: Array, lean: float, pelvis: Array) -> None:
    """Write the pelvis' place on the floor: along the heading on its path, across it under the centre of mass.

    Args:
        path: (T, 2) path of the pelvis [m].
        axis: (T, 2) unit vectors along the heading.
        free: (T,) share in which the pelvis follows the centre of mass alone.
        com: (T, 2) centre of mass [m].
        offset: (T, 2) centre of mass relative to the pelvis [m].
        lean: distance of the pelvis before its path [m].
        pelvis: (T, 3) output.
    """
    for t in range(len(path)):
        ahead_x = axis[t, 0]
        ahead_y = axis[t, 1]
        share = free[t]
        along = path[t, 0] * ahead_x + path[t, 1] * ahead_y + lean
        x = com[t, 0] - offset[t, 0]
        y = com[t, 1] - offset[t, 1]

        # Replaces the component along the heading by the path's.
        off = x * ahead_x + y * ahead_y
        pelvis[t, 0] = share * x + (1.0 - share) * ((x - off * ahead_x) + along * ahead_x)
        pelvis[t, 1] = share * y + (1.0 - share) * ((y - off * ahead_y) + along * ahead_y)


class Planner:
    """Plans the motion of one dancer, cue by cue; rows before the present never change.

    Args:
        anatomy: tables of the dancer's build.
        slot: (2,) where the dancer stands and returns to [m].
        heading_rad: initial heading.
        move_m: nominal length of a move.
        turn_rad: angle of a turn, counter-clockwise positive.
        rate_hz: control rate.
        reference: trajectory that the plan is written to, a row for each control step.
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
        self._move_m = move_m
        self._turn_rad = turn_rad
        self._sole_m = SOLE_CENTRE * anatomy.build.stature_m
        self._mass_shares: Array = self._chains.point_mass / self._chains.point_mass.sum()
        self._omega = float(np.sqrt(GRAVITY / (PENDULUM_HEIGHT * anatomy.standing_m)))

        # Where the last move planned so far leads to.
        self._heading = heading_rad
        self._place = self._slot
        self._busy_until_s = 0.0

        self._dt = 1.0 / rate_hz
        self._kernel = footsteps.smoothing_kernel(HEIGHT_SMOOTHING_S, self._dt)
        ticks = len(reference.yaw)
        self._times: Array = np.arange(ticks, dtype=np.float64) * self._dt
        self._reference = reference
        self._allocate(ticks)

        reference.planned_rows[:] = STANDING_ROWS
        self._feet = footsteps.FootTrajectories(
            self._slot, heading_rad, anatomy.hip_m, anatomy.ankle_m, self._times, reference
        )
        self._plan_standing(heading_rad)

    def _allocate(self, ticks: int) -> None:
        """Make the arrays that the plan needs beside the reference trajectory, a row for each control step."""
        self._arms = np.full((ticks, 8), 0.0)
        self._trunk = np.full(ticks, 0.0)
        self._path = np.full((ticks, 2), 0.0)
        self._axis = np.full(ticks, 0.0)
        self._free = np.full(ticks, 0.0)
        self._com = np.full((ticks, 2), 0.0)

        r = self._reference
        own = (self._arms, self._trunk, self._path, self._axis, self._free, self._com)
        self._columns = (*own, r.rows)

    def _plan_standing(self, heading_rad: float) -> None:
        """Find the posture at rest, and how far the pelvis is before the ankles in it."""
        posture = np.zeros((1, 25))
        posture[:, ARM_COLUMNS] = np.tile(self._poses.stand, 2)
        half = self._anatomy.hip_m
        ankle = self._anatomy.ankle_m
        ankles = np.array([[[0.0, half, ankle], [0.0, -half, ankle]]])
        pelvis = np.array([[0.0, 0.0, self._anatomy.standing_m]])

        # The posture depends on the place of the pelvis and the centre of mass on the posture; five iterations reach
        # the fixed point.
        for _ in range(5):
            leg_angles(pelvis, np.zeros(1), ankles, np.zeros((1, 2)), self._chains.leg, posture, LEG_COLUMNS)
            pelvis[0, 0] = self._sole_m - float(com_offsets(self._chains, posture, np.zeros(1))[0, 0])
        self._lean = float(pelvis[0, 0])

        planned = slice(0, STANDING_ROWS)
        self._arms[planned] = posture[0, ARM_COLUMNS]
        self._path[planned] = self._slot
        self._axis[planned] = heading_rad
        self._reference.yaw[planned] = heading_rad
        self._com[planned] = self._slot + self._sole_m * _unit(heading_rad)
        self._solve(0)

    @property
    def omega(self) -> float:
        """Rate of the inverted pendulum that the plan assumes [1/s]."""
        return self._omega

    def extend(self, cues: Sequence[Cue], now_s: float) -> None:
        """Plan further cues, in order of time.

        Args:
            cues: moves that follow everything planned so far.
            now_s: present session time; motion before it does not change.

        Raises:
            ConfigError: a cue lies in the past, begins before the one before it has ended, or is too short.
        """
        first: int | None = None
        for cue in cues:
            self._check(cue, now_s)
            window = self._window(cue, now_s)

            if cue.move in (Move.FORWARD, Move.BACKWARD):
                self._plan_walk(cue, now_s, window)
            elif cue.move is Move.TURN:
                self._plan_turn(cue, window)
            elif cue.move is Move.CLAP:
                arms.write_clap(self._arms[window], self._times[window], cue.t_s, self._poses)

            self._busy_until_s = cue.t_s + cue.duration_s
            first = window.start if first is None else first

        if first is not None:
            self._solve(first)

    def _check(self, cue: Cue, now_s: float) -> None:
        """Raise for a cue that cannot be performed."""
        name = f"{cue.dancer}: {cue.move} cue"
        earliest = max(self._busy_until_s, now_s)
        # The tolerance admits cues that lie exactly at a limit that was computed in another order.
        if not earliest - 1e-9 <= cue.t_s < np.inf:
            raise ConfigError(
                f"{name}.t_s", cue.t_s, f"{earliest:.3f} s or later, after the present and the move before it"
            )

        shortest = {Move.CLAP: 0.0, Move.TURN: MIN_TURN_S}.get(cue.move, MIN_DURATION_S)
        if not shortest <= cue.duration_s < np.inf:
            raise ConfigError(f"{name}.duration_s", cue.duration_s, f"{shortest:g} s or longer")

    def _window(self, cue: Cue, now_s: float) -> slice:
        """Rows that a cue may change: from its preview, at least the last two, to the rest after it."""
        begin = int(max(now_s, cue.t_s - PREVIEW_S) / self._dt)
        self._extend_rest(int((cue.t_s + cue.duration_s + SETTLING_S) / self._dt))

        end = int(self._reference.planned_rows[0])
        return slice(min(begin, end - 2), end)

    def _extend_rest(self, row: int) -> None:
        """Plan rest up to a row, by repeating the last planned one, unless it is planned already."""
        planned = int(self._reference.planned_rows[0])
        row = min(row, len(self._times))

        if row > planned:
            for column in self._columns:
                column[planned:row] = column[planned - 1]
            self._reference.planned_rows[0] = row

    def _plan_walk(self, cue: Cue, now_s: float, window: slice) -> None:
        """Plan the pelvis' path, the footsteps, the lean of the trunk and the arm swing of a move."""
        forward = cue.move is Move.FORWARD
        sign = 1.0 if forward else -1.0
        ahead = float((self._place - self._slot) @ _unit(self._heading))
        wanted = self._move_m - ahead if forward else ahead

        start_lag, stop_lag = LAGS_S[cue.move]
        stop_lag += SHORT_MOVE_LAG * max(SHORT_MOVE_S - cue.duration_s, 0.0)
        # The plan leads by the lag of the bodies, so that the true onsets are at the cue's times.
        start_s = cue.t_s - start_lag
        profile = speed_profile(max(wanted, 0.0), cue.duration_s + start_lag - stop_lag)

        direction = sign * _unit(self._heading) + self._sideways(profile.distance_m)
        since = self._times[window] - start_s
        self._path[window] += profile.distance_at(since)[:, None] * direction
        self._trunk[window] += sign * LEAN_S_M * profile.speed_at(since + LEAN_LEAD_S)

        walk = footsteps.plan_walk(profile, start_s, self._feet.last_side, max(self._feet.landed_s, now_s))
        for step in walk.steps:
            self._feet.swing(step, self._place + step.along * direction, self._heading)
        self._place = self._place + profile.distance_m * direction
        self._swing_arms(start_s, profile, walk, window)

    def _sideways(self, distance_m: float) -> Array:
        """(2,) motion back to the slot, across the heading, per distance along it."""
        left = _unit(self._heading + np.pi / 2.0)
        off = float((self._slot - self._place) @ left) / distance_m
        return np.asarray(min(max(off, -MAX_SIDEWAYS), MAX_SIDEWAYS) * left)

    def _swing_arms(self, start_s: float, profile: SpeedProfile, walk: footsteps.Walk, window: slice) -> None:
        """Swing the arms against the legs."""
        times = self._times[window]
        span = (times >= walk.start_s) & (times <= walk.end_s)
        speed = profile.speed_at(times[span] - start_s)
        swing = -np.cos(np.pi * (times[span] - walk.start_s) / walk.step_s)
        arms.add_arm_swing(self._arms[window], span, speed, swing if walk.steps[0].side == 1 else -swing)

    def _plan_turn(self, cue: Cue, window: slice) -> None:
        """Plan heading and footsteps of a turn, in which the pelvis follows the centre of mass instead of a path."""
        since = (self._times[window] - cue.t_s) / cue.duration_s
        self._reference.yaw[window] = self._heading + self._turn_rad * minimum_jerk(since)

        for step in footsteps.plan_turn(cue.t_s, cue.duration_s, self._feet.landed_s):
            self._feet.swing(step, self._place, self._heading + self._turn_rad * step.along)

        self._heading += self._turn_rad
        # The axis changes in the middle of the turn, where the pelvis follows the centre of mass alone.
        self._axis[window][since >= 0.5] = self._heading
        self._free[window] = minimum_jerk(since / BLEND_SHARE) * minimum_jerk((1.0 - since) / BLEND_SHARE)

    def _solve(self, first: int) -> None:
        """Compute centre of mass, pelvis, joints and torques from a row on, to the last that is planned."""
        r = self._reference
        span = slice(first, int(r.planned_rows[0]))
        # Copies are contiguous. Views of the trajectory are not, and compiled functions would be compiled for them too.
        yaw = r.yaw[span].copy()
        ankles = r.ankles[span].copy()
        weight = self._feet.weight(span)

        zmp = self._feet.zero_moment_point(span, weight, self._sole_m)
        com = bounded_com(zmp, self._omega * self._dt, self._com[first])
        pelvis, joints = self._postures(span, com)

        placed = place_chains(self._chains, joints, pelvis, yaw)
        r.joints[span] = joints
        r.pelvis[span] = pelvis
        r.weight[span] = weight
        self._com[span] = com
        write_divergent_component(np.asarray(self._mass_shares @ placed.points), self._dt, self._omega, r.dcm[span])
        r.torque[span] = hinge_torques(self._chains, placed, ankles, weight, self._dt)

    def _postures(self, span: slice, com: Array) -> tuple[Array, Array]:
        """Pelvis (T, 3) [m] and joints (T, 25) [rad] that carry a motion of the centre of mass (T, 2) [m]."""
        r = self._reference
        yaw = r.yaw[span].copy()
        ankles = r.ankles[span].copy()
        foot_yaw = r.foot_yaw[span].copy()
        axis = np.stack([np.cos(self._axis[span]), np.sin(self._axis[span])], axis=1)
        joints = np.zeros((len(yaw), 25))
        joints[:, ARM_COLUMNS] = self._arms[span]
        joints[:, ACTUATED_INDEX["abdomen_y"]] = self._trunk[span]
        pelvis = np.empty((len(yaw), 3))

        # The first pass takes the centre of mass of standing, the second one that of the first pass' postures.
        offset = (self._sole_m - self._lean) * axis
        for final in (False, True):
            _place_pelvis(self._path[span], axis, self._free[span], com, offset, self._lean, pelvis)
            pelvis[:, 2] = footsteps.pelvis_height(
                pelvis, yaw, ankles, self._chains.leg, self._anatomy.standing_m, self._kernel
            )
            leg_angles(pelvis, yaw, ankles, foot_yaw, self._chains.leg, joints, LEG_COLUMNS)
            if not final:
                offset = com_offsets(self._chains, joints, yaw)

        return pelvis, joints


def _unit(angle: float) -> Array:
    """(2,) unit vector of a heading [rad]."""
    return np.array([np.cos(angle), np.sin(angle)])
