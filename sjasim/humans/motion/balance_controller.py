"""BalanceController control: small corrections to the planned joint targets that keep a dancer on its feet; all dancers in one call.

The error of the divergent component of motion moves the pressure under the standing feet (ankles) and the next
foothold (hips of the swinging leg); pitch, roll and yaw errors go to the hips.

Source: englsberger2015, section IV (capture-point control). Gains were found by an evolution strategy on
simulated dances with jitter and sideways pushes of 27 Ns while walking; a push decides more than a calm dance. Roll
and decay were found anew at 150 and 50 steps a second, on pushes of 22 and 27 Ns.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from math import cos, exp, sin

import numpy as np
from numba import njit

from ...assets.names import ACTUATED_INDEX, LEG_JOINTS
from ...core import Array, IntArray, Servos
from .reference_trajectory import ANKLES, DCM, JOINTS, LANDING, PELVIS, TORQUE, YAW, ReferenceTrajectory
from .reference_trajectory import WEIGHT as WEIGHT_LEFT

_LEGS = np.array([[ACTUATED_INDEX[f"{joint}_{side}"] for joint in LEG_JOINTS] for side in "LR"])
HIP_Z, HIP_X, HIP_Y, _, ANKLE_Y, ANKLE_X = range(6)
HINGES = 25
(
    PRESSURE_ALONG, PRESSURE_ACROSS, PITCH, PITCH_RATE, ROLL, STEP_ALONG, STEP_ACROSS, DRIFT, YAW_GAIN, DECAY, AHEAD,
    EFFORT,
) = range(12)  # fmt: skip
COM, VELOCITY, ROOT, RATE, LEFT, RIGHT = 0, 3, 6, 12, 18, 21
"""Where the parts of `types.DancerStates.rows` begin."""
STIFFNESS, LEAD, ROOT_LEAD, WEIGHT, LEG, OMEGA = 0, 25, 50, 55, 56, 57
"""Where the parts of a dancer's actuators begin: stiffness, leads of hinges and tether, body weight, leg length; behind
them the pendulum's rate."""


@dataclass(frozen=True, slots=True)
class BalanceGains:
    """Dimensionless but where noted.

    Attributes:
        pressure_along: pressure point per DCM error, fore and aft.
        pressure_across: the same sideways.
        pitch: hip angle per pitch.
        pitch_rate: hip angle per pitch rate [s].
        roll: hip angle per roll; below nothing, so that a pushed trunk swings out and its momentum spares the feet.
        step_along: foothold per DCM error at landing, fore and aft.
        step_across: the same sideways.
        drift: how much of the standing foot's drift the next foothold takes back.
        yaw: hip angle per yaw error.
        decay: what remains of a foothold's correction after a sixtieth of a second of standing.
        ahead: how far targets run ahead of the plan, against the delay of held targets, as a share of a tick.
        effort: share of the plan's torques that is fed forward.
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


@njit(cache=True)
def _turned(yaw: float, x: float, y: float) -> tuple[float, float]:
    """A horizontal vector seen from a heading: forward, left."""
    c, s = cos(yaw), sin(yaw)
    return c * x + s * y, c * y - s * x


@njit(cache=True)
def _limited(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@njit(cache=True)
def _follow_plan(d: int, i: int, a: int, b: int, rate: float, plan: Array, servo: Array, gain: Array, u: Array) -> None:
    """Targets that servos with damping need: the plan's row plus its rate times their lead, and what its torques take.

    Its rate is a difference of neighbouring rows; targets run ahead of the plan, since they are held for a tick.
    """
    per, ahead, effort = rate / max(b - a, 1), gain[AHEAD] / rate, gain[EFFORT]
    for k in range(HINGES):
        rise = (servo[d, LEAD + k] + ahead) * per * (plan[d, b, JOINTS + k] - plan[d, a, JOINTS + k])
        torque = plan[d, i, TORQUE + k] + ahead * per * (plan[d, b, TORQUE + k] - plan[d, a, TORQUE + k])
        u[d, k] = (plan[d, i, JOINTS + k] + rise) + effort * torque / servo[d, STIFFNESS + k]
    for k in range(3):  # the tether takes x, y and, behind z, yaw
        column, lead = PELVIS + k if k < 2 else YAW, servo[d, ROOT_LEAD + k]
        u[d, HINGES + k] = plan[d, i, column] + (lead + ahead) * per * (plan[d, b, column] - plan[d, a, column])


@njit(cache=True)
def _stand(
    d: int,
    side: int,
    on: float,
    push: tuple[float, float],
    off: float,
    felt: Array,
    servo: Array,
    gain: Array,
    u: Array,
) -> None:
    """Standing leg: the ankle moves the pressure point, the hip rights the trunk."""
    hz, hx, hy = _LEGS[side, HIP_Z], _LEGS[side, HIP_X], _LEGS[side, HIP_Y]
    ay, ax, load = _LEGS[side, ANKLE_Y], _LEGS[side, ANKLE_X], servo[d, WEIGHT]
    u[d, ay] += on * load * push[0] / servo[d, STIFFNESS + ay]
    u[d, ax] -= on * load * push[1] / servo[d, STIFFNESS + ax]
    u[d, hy] += on * (gain[PITCH] * felt[d, ROOT + 4] + gain[PITCH_RATE] * felt[d, RATE + 4])
    u[d, hx] += on * gain[ROLL] * felt[d, ROOT + 5]
    u[d, hz] += on * gain[YAW_GAIN] * off * 0.5


@njit(cache=True)
def _foothold(
    d: int, side: int, landing: float, omega: float, error: tuple[float, float], drift: tuple[float, float],
    off: float, gain: Array, shift: Array,
) -> None:  # fmt: skip
    """Where a swinging foot should land other than planned: forward, left [m] and yaw [rad], in place."""
    grow, sign = exp(omega * min(landing, 0.4)), 1.0 if side == 0 else -1.0
    shift[d, side, 0] = _limited(gain[STEP_ALONG] * error[0] * grow - gain[DRIFT] * drift[0], -0.15, 0.15)
    across = _limited(gain[STEP_ACROSS] * error[1] * grow - gain[DRIFT] * drift[1], -0.15, 0.15)
    shift[d, side, 1] = -sign * 0.06 if sign * across < -0.06 else across
    shift[d, side, 2] = -gain[YAW_GAIN] * off


@njit(cache=True)
def _reach(d: int, side: int, shift: Array, length: float, u: Array) -> None:
    """Move a leg's foot by a small shift, the sole staying flat."""
    along, across = shift[d, side, 0] / length, shift[d, side, 1] / length
    u[d, _LEGS[side, HIP_Y]] -= along
    u[d, _LEGS[side, ANKLE_Y]] += along
    u[d, _LEGS[side, HIP_X]] += across
    u[d, _LEGS[side, ANKLE_X]] -= across
    u[d, _LEGS[side, HIP_Z]] += shift[d, side, 2]


@njit(cache=True)
def _errors(d: int, i: int, omega: float, plan: Array, felt: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """Forward and left: how far the divergent component is off the plan, and the standing feet [m]."""
    w, yaw = plan[d, i, WEIGHT_LEFT], felt[d, ROOT + 3]
    drift = _turned(
        yaw,
        w * (felt[d, LEFT] - plan[d, i, ANKLES]) + (1 - w) * (felt[d, RIGHT] - plan[d, i, ANKLES + 3]),
        w * (felt[d, LEFT + 1] - plan[d, i, ANKLES + 1]) + (1 - w) * (felt[d, RIGHT + 1] - plan[d, i, ANKLES + 4]),
    )
    error = _turned(
        yaw,
        felt[d, COM] + felt[d, VELOCITY] / omega - plan[d, i, DCM],
        felt[d, COM + 1] + felt[d, VELOCITY + 1] / omega - plan[d, i, DCM + 1],
    )
    return error, drift


@njit(cache=True)
def _correct(
    d: int, tick: int, until: int, rate: float, plan: Array, felt: Array, servo: Array, gain: Array, shift: Array,
    u: Array,
) -> None:  # fmt: skip
    """Targets of one dancer for one tick."""
    last = until - 1
    i = min(tick, last)
    _follow_plan(d, i, min(max(tick - 1, 0), last), min(tick + 1, last), rate, plan, servo, gain, u)
    omega, w, off = servo[d, OMEGA], plan[d, i, WEIGHT_LEFT], felt[d, ROOT + 3] - plan[d, i, YAW]
    error, drift = _errors(d, i, omega, plan, felt)
    wide = 0.08 if 0.15 < w < 0.85 else 0.03
    push = (
        _limited(gain[PRESSURE_ALONG] * error[0], -0.09, 0.12),
        _limited(gain[PRESSURE_ACROSS] * error[1], -wide, wide),
    )
    for side in range(2):
        on, landing = w if side == 0 else 1.0 - w, plan[d, i, LANDING + side]
        if on >= 0.03:
            _stand(d, side, on, push, off, felt, servo, gain, u)
        if landing > 0:
            _foothold(d, side, landing, omega, error, drift, off, gain, shift)
            u[d, _LEGS[side, ANKLE_Y]] -= felt[d, ROOT + 4]
            u[d, _LEGS[side, ANKLE_X]] -= felt[d, ROOT + 5]
        else:
            for k in range(3):
                shift[d, side, k] *= gain[DECAY] ** (60.0 / rate)
        _reach(d, side, shift, servo[d, LEG], u)


@njit(cache=True)
def correct(
    tick: int, rate: float, until: IntArray, plan: Array, felt: Array, servo: Array, gain: Array, shift: Array,
    targets: Array,
) -> None:  # fmt: skip
    """Write everybody's targets for one control tick.

    Whole arrays and indices are handed on, not views of rows: making these takes longer than what is done with them.

    Args:
        tick: which one.
        rate: of the ticks [Hz].
        until: (D,) how many rows are planned.
        plan: (D, T, 67) rows of `ReferenceTrajectory`.
        felt: (D, 36) rows of `types.DancerStates`.
        servo: (D, 58) the actuators, see `STIFFNESS`.
        gain: (12,) `BalanceGains`.
        shift: (D, 2, 3) how the feet's places differ from the plan, in and out: forward, left [m], yaw [rad].
        targets: (D, 30) output: hinges, then the tether.
    """
    for d in range(len(until)):
        _correct(d, tick, until[d], rate, plan, felt, servo, gain, shift, targets)


class BalanceController:
    """Turns the reference and the felt state into actuator targets, tick by tick.

    Args:
        reference: all dancers' motion.
        omega: (D,) pendulum rates [1/s].
        rate_hz: control rate.
        servos: the dancers' actuators.
        gains: of the controller.

    Attributes:
        rate_hz: as given.
        targets: (D, 30) angles of the planned hinges [rad], then targets of the tether; see `update`.
    """

    def __init__(
        self,
        reference: ReferenceTrajectory,
        omega: Array,
        rate_hz: int,
        servos: Servos,
        gains: BalanceGains | None = None,
    ) -> None:
        s, dancers = servos, len(omega)
        servo = np.column_stack([s.stiffness, s.lead, s.root_lead, s.weight, s.leg, omega])
        gain = np.array(astuple(gains or BalanceGains()))
        self.rate_hz = float(rate_hz)
        self._reference = reference
        self._actuators = servo
        self._gains = gain
        self._foot_shift = np.zeros((dancers, 2, 3))
        self.targets = np.zeros((dancers, HINGES + 5))

    def update(self, tick: int, states: Array) -> None:
        """Write the `targets` of one control step.

        Args:
            tick: number of the step, the row of the plan.
            states: (D, 36) rows of `DancerStates`.
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
