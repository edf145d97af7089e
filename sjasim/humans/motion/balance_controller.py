"""The balance controller: corrections of the planned joint targets that keep the dancers on their feet.

The error of the divergent component of motion moves the pressure under the standing feet (by the ankles) and the next
foothold (by the hips of the swinging leg). Errors of pitch, roll and yaw go to the hips.

Source: englsberger2015, section IV (capture-point control). The gains were found by an evolution strategy on simulated
dances with timing noise and sideways pushes of 27 Ns while walking, which decide more than calm dances; the gain of
roll and the decay were found anew at 150 steps and 50 control steps a second, on pushes of 22 and 27 Ns.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from enum import IntEnum
from math import cos, exp, sin

import numpy as np

from ...assets.names import ACTUATED_INDEX, LEG_JOINTS
from ...core import Array, IntArray, Servos
from ...core.bodies import StateColumn
from ...core.compiled import compiled_entry, compiled_inner
from .reference_trajectory import PlanColumn, ReferenceTrajectory

HINGES = 25
"""Number of planned hinges of a dancer."""

SUPPORTED = 5
"""Number of root joints at which balance support acts."""

MAX_FOOT_SHIFT_M = 0.15
"""Largest shift of a foothold [m] (assumed)."""

MAX_INWARD_SHIFT_M = 0.06
"""Largest shift of a foothold towards the other foot; it prevents collisions of the feet [m] (assumed)."""

MAX_PREDICTION_S = 0.4
"""Longest time over which the error at landing is predicted, since it grows exponentially [s] (assumed)."""

MIN_STANCE_SHARE = 0.03
"""Smallest fraction of the weight on a foot at which its ankle is used for balance (assumed)."""

_LEGS = np.array([[ACTUATED_INDEX[f"{joint}_{side}"] for joint in LEG_JOINTS] for side in "LR"])


class LegJoint(IntEnum):
    """Columns of `_LEGS`, in the order of `LEG_JOINTS`."""

    HIP_Z = 0
    HIP_X = 1
    HIP_Y = 2
    KNEE = 3
    ANKLE_Y = 4
    ANKLE_X = 5


class GainColumn(IntEnum):
    """Places of the fields of `BalanceGains` in an array."""

    PRESSURE_ALONG = 0
    PRESSURE_ACROSS = 1
    PITCH = 2
    PITCH_RATE = 3
    ROLL = 4
    STEP_ALONG = 5
    STEP_ACROSS = 6
    DRIFT = 7
    YAW = 8
    DECAY = 9
    AHEAD = 10
    EFFORT = 11


class ActuatorColumn(IntEnum):
    """First column of each part of a dancer's row of actuator data, see `Servos`."""

    STIFFNESS = 0
    """Of the 25 hinge servos [Nm/rad]."""
    LEAD = 25
    """Their damping over stiffness [s]."""
    ROOT_LEAD = 50
    """The same for the five actuators of balance support [s]."""
    WEIGHT = 55
    """Body weight [N]."""
    LEG = 56
    """Length of a leg [m]."""
    OMEGA = 57
    """Rate of the inverted pendulum [1/s]."""


@dataclass(frozen=True, slots=True)
class BalanceGains:
    """Gains of the balance controller, dimensionless unless a unit is given.

    Attributes:
        pressure_along: shift of the pressure point per error of the divergent component, fore and aft.
        pressure_across: the same sideways.
        pitch: hip angle per pitch.
        pitch_rate: hip angle per pitch rate [s].
        roll: hip angle per roll. It is negative: a pushed trunk swings out, and its momentum relieves the feet.
        step_along: shift of the foothold per predicted error at landing, fore and aft.
        step_across: the same sideways.
        drift: share of the standing foot's displacement that the next foothold corrects.
        yaw: hip angle per yaw error.
        decay: what remains of a foothold's shift after a sixtieth of a second of standing.
        ahead: time by which targets lead the plan, against the delay of held targets, in control steps.
        effort: share of the planned torques that is fed forward.
    """

    pressure_along: float = 3.9
    pressure_across: float = 2.8
    pitch: float = 0.74
    pitch_rate: float = 0.02
    roll: float = -0.4
    step_along: float = 0.07
    step_across: float = 0.48
    drift: float = 0.75
    yaw: float = 0.64
    decay: float = 0.95
    ahead: float = 0.5
    effort: float = 1.0


@compiled_inner
def _heading_frame(yaw: float, x: float, y: float) -> tuple[float, float]:
    """Forward and left component of a horizontal vector, for a heading."""
    c = cos(yaw)
    s = sin(yaw)
    return c * x + s * y, c * y - s * x


@compiled_inner
def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@compiled_inner
def _write_feedforward(
    d: int, i: int, a: int, b: int, rate: float, plan: Array, actuators: Array, gains: Array, targets: Array
) -> None:
    """Write targets that make damped servos follow the plan: its row, its rate times their lead, and its torques.

    The rate is the difference of the rows ``a`` and ``b`` around row ``i``. Targets lead the plan, because they are
    held for a control step.
    """
    per = rate / max(b - a, 1)
    ahead = gains[GainColumn.AHEAD] / rate
    effort = gains[GainColumn.EFFORT]

    for k in range(HINGES):
        joint = PlanColumn.JOINTS + k
        torque_column = PlanColumn.TORQUE + k
        lead = actuators[d, ActuatorColumn.LEAD + k]
        rise = (lead + ahead) * per * (plan[d, b, joint] - plan[d, a, joint])
        torque = plan[d, i, torque_column] + ahead * per * (plan[d, b, torque_column] - plan[d, a, torque_column])
        stiffness = actuators[d, ActuatorColumn.STIFFNESS + k]
        targets[d, k] = (plan[d, i, joint] + rise) + effort * torque / stiffness

    # Balance support follows the plan in x, y and yaw; its pitch and roll targets stay 0.
    for k in range(3):
        column = PlanColumn.PELVIS + k if k < 2 else PlanColumn.YAW + 0
        lead = actuators[d, ActuatorColumn.ROOT_LEAD + k]
        rise = (lead + ahead) * per * (plan[d, b, column] - plan[d, a, column])
        targets[d, HINGES + k] = plan[d, i, column] + rise


@compiled_inner
def _balance_stance(
    d: int, side: int, share: float, push: tuple[float, float], yaw_error: float, states: Array, actuators: Array,
    gains: Array, targets: Array,
) -> None:  # fmt: skip
    """Correct a standing leg: the ankle moves the pressure point by ``push`` [m], the hip rights the trunk."""
    hip_z = _LEGS[side, LegJoint.HIP_Z]
    hip_x = _LEGS[side, LegJoint.HIP_X]
    hip_y = _LEGS[side, LegJoint.HIP_Y]
    ankle_y = _LEGS[side, LegJoint.ANKLE_Y]
    ankle_x = _LEGS[side, LegJoint.ANKLE_X]
    load = actuators[d, ActuatorColumn.WEIGHT]
    pitch = states[d, StateColumn.ROOT + 4]
    pitch_rate = states[d, StateColumn.ROOT_VELOCITY + 4]
    roll = states[d, StateColumn.ROOT + 5]

    # Weight times lever is the ankle's torque, which the servo's stiffness turns into an angle.
    targets[d, ankle_y] += share * load * push[0] / actuators[d, ActuatorColumn.STIFFNESS + ankle_y]
    targets[d, ankle_x] -= share * load * push[1] / actuators[d, ActuatorColumn.STIFFNESS + ankle_x]
    targets[d, hip_y] += share * (gains[GainColumn.PITCH] * pitch + gains[GainColumn.PITCH_RATE] * pitch_rate)
    targets[d, hip_x] += share * gains[GainColumn.ROLL] * roll
    # The factor 0.5 was part of the model when the gains were found.
    targets[d, hip_z] += share * gains[GainColumn.YAW] * yaw_error * 0.5


@compiled_inner
def _shift_foothold(
    d: int, side: int, landing: float, omega: float, error: tuple[float, float], drift: tuple[float, float],
    yaw_error: float, gains: Array, foot_shift: Array,
) -> None:  # fmt: skip
    """Write how a swinging foot's landing place differs from the plan: forward, left [m] and yaw [rad]."""
    growth = exp(omega * min(landing, MAX_PREDICTION_S))
    sign = 1.0 if side == 0 else -1.0

    along = gains[GainColumn.STEP_ALONG] * error[0] * growth - gains[GainColumn.DRIFT] * drift[0]
    foot_shift[d, side, 0] = _clip(along, -MAX_FOOT_SHIFT_M, MAX_FOOT_SHIFT_M)

    across = gains[GainColumn.STEP_ACROSS] * error[1] * growth - gains[GainColumn.DRIFT] * drift[1]
    across = _clip(across, -MAX_FOOT_SHIFT_M, MAX_FOOT_SHIFT_M)
    foot_shift[d, side, 1] = -sign * MAX_INWARD_SHIFT_M if sign * across < -MAX_INWARD_SHIFT_M else across

    foot_shift[d, side, 2] = -gains[GainColumn.YAW] * yaw_error


@compiled_inner
def _apply_foot_shift(d: int, side: int, foot_shift: Array, length: float, targets: Array) -> None:
    """Turn a leg so that its foot moves by a small shift while the sole stays flat."""
    along = foot_shift[d, side, 0] / length
    across = foot_shift[d, side, 1] / length

    targets[d, _LEGS[side, LegJoint.HIP_Y]] -= along
    targets[d, _LEGS[side, LegJoint.ANKLE_Y]] += along
    targets[d, _LEGS[side, LegJoint.HIP_X]] += across
    targets[d, _LEGS[side, LegJoint.ANKLE_X]] -= across
    targets[d, _LEGS[side, LegJoint.HIP_Z]] += foot_shift[d, side, 2]


@compiled_inner
def _errors(
    d: int, i: int, omega: float, plan: Array, states: Array
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Errors against the plan, forward and left: of the divergent component, and of the standing feet [m]."""
    w = plan[d, i, PlanColumn.WEIGHT]
    yaw = states[d, StateColumn.ROOT + 3]
    left = StateColumn.ANKLES + 0
    right = StateColumn.ANKLES + 3
    planned = PlanColumn.ANKLES + 0

    drift = _heading_frame(
        yaw,
        w * (states[d, left] - plan[d, i, planned]) + (1 - w) * (states[d, right] - plan[d, i, planned + 3]),
        w * (states[d, left + 1] - plan[d, i, planned + 1])
        + (1 - w) * (states[d, right + 1] - plan[d, i, planned + 4]),
    )
    error = _heading_frame(
        yaw,
        states[d, StateColumn.COM] + states[d, StateColumn.COM_VELOCITY] / omega - plan[d, i, PlanColumn.DCM],
        states[d, StateColumn.COM + 1]
        + states[d, StateColumn.COM_VELOCITY + 1] / omega
        - plan[d, i, PlanColumn.DCM + 1],
    )
    return error, drift


@compiled_inner
def _correct_dancer(
    d: int, tick: int, planned_rows: int, rate: float, plan: Array, states: Array, actuators: Array, gains: Array,
    foot_shift: Array, targets: Array,
) -> None:  # fmt: skip
    """Write the targets of one dancer; see `correct`."""
    last = planned_rows - 1
    i = min(tick, last)
    before = min(max(tick - 1, 0), last)
    after = min(tick + 1, last)
    _write_feedforward(d, i, before, after, rate, plan, actuators, gains, targets)

    omega = actuators[d, ActuatorColumn.OMEGA]
    w = plan[d, i, PlanColumn.WEIGHT]
    yaw_error = states[d, StateColumn.ROOT + 3] - plan[d, i, PlanColumn.YAW]
    error, drift = _errors(d, i, omega, plan, states)

    # The pressure point stays under the sole: between heel and toes, and wider across while both feet stand.
    wide = 0.08 if 0.15 < w < 0.85 else 0.03
    push = (
        _clip(gains[GainColumn.PRESSURE_ALONG] * error[0], -0.09, 0.12),
        _clip(gains[GainColumn.PRESSURE_ACROSS] * error[1], -wide, wide),
    )

    for side in range(2):
        share = w if side == 0 else 1.0 - w
        landing = plan[d, i, PlanColumn.LANDING + side]
        if share >= MIN_STANCE_SHARE:
            _balance_stance(d, side, share, push, yaw_error, states, actuators, gains, targets)

        if landing > 0:
            _shift_foothold(d, side, landing, omega, error, drift, yaw_error, gains, foot_shift)
            # The sole lands flat, whatever the pelvis' pitch and roll.
            targets[d, _LEGS[side, LegJoint.ANKLE_Y]] -= states[d, StateColumn.ROOT + 4]
            targets[d, _LEGS[side, LegJoint.ANKLE_X]] -= states[d, StateColumn.ROOT + 5]
        else:
            for k in range(3):
                # The decay is given for a sixtieth of a second, whatever the control rate is.
                foot_shift[d, side, k] *= gains[GainColumn.DECAY] ** (60.0 / rate)

        _apply_foot_shift(d, side, foot_shift, actuators[d, ActuatorColumn.LEG], targets)


@compiled_entry
def correct(
    tick: int, rate: float, planned_rows: IntArray, plan: Array, states: Array, actuators: Array, gains: Array,
    foot_shift: Array, targets: Array,
) -> None:  # fmt: skip
    """Write the targets of all dancers for one control step.

    Inner functions take whole arrays and indices, not views of rows: making a view takes longer than what is done with
    it.

    Args:
        tick: number of the step, the row of the plan.
        rate: control rate [Hz].
        planned_rows: (D,) number of planned rows.
        plan: (D, T, `PLAN_WIDTH`) rows of `ReferenceTrajectory`.
        states: (D, `DANCER_STATE_WIDTH`) rows of `DancerStates`.
        actuators: (D, 58) data of the actuators, see `ActuatorColumn`.
        gains: (12,) `BalanceGains`, see `GainColumn`.
        foot_shift: (D, 2, 3) how the places of the feet differ from the plan, in and out: forward, left [m], yaw [rad].
        targets: (D, 30) output: hinges, then balance support.
    """
    for d in range(len(planned_rows)):
        _correct_dancer(d, tick, planned_rows[d], rate, plan, states, actuators, gains, foot_shift, targets)


class BalanceController:
    """Turns the reference trajectory and the states of all dancers into actuator targets, step by step.

    Args:
        reference: trajectories of all dancers.
        omega: (D,) pendulum rates [1/s].
        rate_hz: control rate.
        servos: the dancers' actuators.
        gains: gains of the controller.

    Attributes:
        rate_hz: as given.
        targets: (D, 30) angles of the planned hinges [rad], then targets of balance support; see `update`.
    """

    def __init__(
        self,
        reference: ReferenceTrajectory,
        omega: Array,
        rate_hz: int,
        servos: Servos,
        gains: BalanceGains | None = None,
    ) -> None:
        dancers = len(omega)
        self.rate_hz = float(rate_hz)
        self._reference = reference
        self._actuators = np.column_stack(
            [servos.stiffness, servos.lead, servos.root_lead, servos.weight, servos.leg, omega]
        )
        self._gains = np.array(astuple(gains or BalanceGains()))
        self._foot_shift = np.zeros((dancers, 2, 3))
        self.targets = np.zeros((dancers, HINGES + SUPPORTED))

    def update(self, tick: int, states: Array) -> None:
        """Write the `targets` of one control step.

        Args:
            tick: number of the step, the row of the plan.
            states: (D, `DANCER_STATE_WIDTH`) rows of `DancerStates`.
        """
        correct(
            tick,
            self.rate_hz,
            self._reference.planned_rows,
            self._reference.rows,
            states,
            self._actuators,
            self._gains,
            self._foot_shift,
            self.targets,
        )
