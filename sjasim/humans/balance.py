"""Balance: small corrections to the planned joint targets that keep a dancer on its feet; all dancers in one call.

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

from ..assets.names import ACTUATED_INDEX, LEG_JOINTS
from ..types import Array, DancerStates, IntArray, JointTargets, Servos
from .reference import Reference

_LEGS = np.array([[ACTUATED_INDEX[f"{joint}_{side}"] for joint in LEG_JOINTS] for side in "LR"])
HIP_Z, HIP_X, HIP_Y, _, ANKLE_Y, ANKLE_X = range(6)
(
    PRESSURE_ALONG, PRESSURE_ACROSS, PITCH, PITCH_RATE, ROLL, STEP_ALONG, STEP_ACROSS, DRIFT, YAW, DECAY, AHEAD, EFFORT,
) = range(12)  # fmt: skip
Plan = tuple[Array, Array, Array, Array, Array, Array, Array, Array]
"""Joints, pelvis, yaw, divergent component, weight, ankles, time to landing, torque: rows per tick."""
COM, VELOCITY, ROOT, RATE, LEFT, RIGHT = 0, 3, 6, 12, 18, 21
"""Where the parts of `types.DancerStates.rows` begin."""
STIFFNESS, LEAD, ROOT_LEAD, WEIGHT, LEG = 0, 25, 50, 55, 56
"""Where the parts of a dancer's actuators begin: stiffness, leads of hinges and tether, body weight, leg length."""


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
def _follow_plan(row: Array, before: Array, after: Array, per: float, lead: Array, ahead: float, out: Array) -> None:
    """Targets that servos with damping need to follow a plan: its row plus its rate times their lead."""
    for k in range(len(out)):
        out[k] = row[k] + (lead[k] + ahead) * per * (after[k] - before[k])


@njit(cache=True)
def _turned(yaw: float, x: float, y: float) -> tuple[float, float]:
    """A horizontal vector seen from a heading: forward, left."""
    c, s = cos(yaw), sin(yaw)
    return c * x + s * y, c * y - s * x


@njit(cache=True)
def _limited(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@njit(cache=True)
def _stand(
    u: Array, leg: IntArray, on: float, push: tuple[float, float], root: Array, rate: float, off: float,
    load: float, stiffness: Array, gain: Array,
) -> None:  # fmt: skip
    """Standing leg: the ankle moves the pressure point, the hip rights the trunk."""
    hz, hx, hy, ay, ax = leg[HIP_Z], leg[HIP_X], leg[HIP_Y], leg[ANKLE_Y], leg[ANKLE_X]
    u[ay] += on * load * push[0] / stiffness[ay]
    u[ax] -= on * load * push[1] / stiffness[ax]
    u[hy] += on * (gain[PITCH] * root[4] + gain[PITCH_RATE] * rate)
    u[hx] += on * gain[ROLL] * root[5]
    u[hz] += on * gain[YAW] * off * 0.5


@njit(cache=True)
def _foothold(
    shift: Array, sign: float, landing: float, omega: float, error: tuple[float, float], drift: tuple[float, float],
    off: float, gain: Array,
) -> None:  # fmt: skip
    """Where a swinging foot should land other than planned: forward, left [m] and yaw [rad], in place."""
    grow = exp(omega * min(landing, 0.4))
    shift[0] = _limited(gain[STEP_ALONG] * error[0] * grow - gain[DRIFT] * drift[0], -0.15, 0.15)
    across = _limited(gain[STEP_ACROSS] * error[1] * grow - gain[DRIFT] * drift[1], -0.15, 0.15)
    shift[1] = -sign * 0.06 if sign * across < -0.06 else across
    shift[2] = -gain[YAW] * off


@njit(cache=True)
def _reach(u: Array, leg: IntArray, shift: Array, length: float) -> None:
    """Move a leg's foot by a small shift, the sole staying flat."""
    u[leg[HIP_Y]] -= shift[0] / length
    u[leg[ANKLE_Y]] += shift[0] / length
    u[leg[HIP_X]] += shift[1] / length
    u[leg[ANKLE_X]] -= shift[1] / length
    u[leg[HIP_Z]] += shift[2]


@njit(cache=True)
def _correct(
    i: int, until: int, rate: float, omega: float, plan: Plan, felt: Array, servo: Array, gain: Array, shift: Array,
    u: Array, root_out: Array,
) -> None:  # fmt: skip
    """Targets of one dancer for one tick."""
    joints, pelvis, yaw, dcm, weight, ankles, landing, torque = plan
    root, stiffness, root_lead = felt[ROOT:RATE], servo[STIFFNESS:LEAD], servo[ROOT_LEAD:WEIGHT]
    last = until - 1
    a, b = min(max(i - 1, 0), last), min(i + 1, last)
    i = min(i, last)
    per, ahead = rate / max(b - a, 1), gain[AHEAD] / rate
    _follow_plan(joints[i], joints[a], joints[b], per, servo[LEAD:ROOT_LEAD], ahead, u)
    for k in range(len(u)):
        u[k] += gain[EFFORT] * (torque[i, k] + ahead * per * (torque[b, k] - torque[a, k])) / stiffness[k]
    _follow_plan(pelvis[i], pelvis[a], pelvis[b], per, root_lead[:2], ahead, root_out[:2])
    root_out[2] = yaw[i] + (root_lead[2] + ahead) * per * (yaw[b] - yaw[a])
    w, off = weight[i], root[3] - yaw[i]
    drift = _turned(
        root[3],
        w * (felt[LEFT] - ankles[i, 0, 0]) + (1 - w) * (felt[RIGHT] - ankles[i, 1, 0]),
        w * (felt[LEFT + 1] - ankles[i, 0, 1]) + (1 - w) * (felt[RIGHT + 1] - ankles[i, 1, 1]),
    )
    error = _turned(
        root[3],
        felt[COM] + felt[VELOCITY] / omega - dcm[i, 0],
        felt[COM + 1] + felt[VELOCITY + 1] / omega - dcm[i, 1],
    )
    wide = 0.08 if 0.15 < w < 0.85 else 0.03
    push = (
        _limited(gain[PRESSURE_ALONG] * error[0], -0.09, 0.12),
        _limited(gain[PRESSURE_ACROSS] * error[1], -wide, wide),
    )
    for side in range(2):
        on, sign = (w, 1.0) if side == 0 else (1.0 - w, -1.0)
        leg = _LEGS[side]
        if on >= 0.03:
            _stand(u, leg, on, push, root, felt[RATE + 4], off, servo[WEIGHT], stiffness, gain)
        if landing[i, side] > 0:
            _foothold(shift[side], sign, landing[i, side], omega, error, drift, off, gain)
            u[leg[ANKLE_Y]] -= root[4]
            u[leg[ANKLE_X]] -= root[5]
        else:
            shift[side] *= gain[DECAY] ** (60.0 / rate)
        _reach(u, leg, shift[side], servo[LEG])


@njit(cache=True)
def _correct_all(
    i: int, until: IntArray, rate: float, omega: Array, plan: Plan, felt: Array, servo: Array, gain: Array,
    shift: Array, out: Array, root_out: Array,
) -> None:  # fmt: skip
    joints, pelvis, yaw, dcm, weight, ankles, landing, torque = plan
    for d in range(len(omega)):
        _correct(
            i, until[d], rate, omega[d],
            (joints[d], pelvis[d], yaw[d], dcm[d], weight[d], ankles[d], landing[d], torque[d]),
            felt[d], servo[d], gain, shift[d], out[d], root_out[d],
        )  # fmt: skip


class Balance:
    """Turns the reference and the felt state into actuator targets, tick by tick.

    Args:
        reference: all dancers' motion.
        omega: (D,) pendulum rates [1/s].
        rate_hz: control rate.
        servos: the dancers' actuators.
        gains: of the controller.
    """

    def __init__(
        self, reference: Reference, omega: Array, rate_hz: int, servos: Servos, gains: BalanceGains | None = None
    ) -> None:
        r, s = reference, servos
        self._plan = (r.joints, r.pelvis, r.yaw, r.dcm, r.weight, r.ankles, r.landing, r.torque)
        self._until = r.until
        self._servo = np.column_stack([s.stiffness, s.lead, s.root_lead, s.weight, s.leg])
        self._omega = omega
        self._rate = float(rate_hz)
        self._gains = np.array(astuple(gains or BalanceGains()))
        dancers = len(omega)
        self._shift = np.zeros((dancers, 2, 3))
        self._joints = np.zeros((dancers, 25))
        self._root = np.zeros((dancers, 5))

    def targets(self, tick: int, states: DancerStates) -> JointTargets:
        """Targets for one control tick; the arrays are overwritten by the next call."""
        _correct_all(
            tick, self._until, self._rate, self._omega, self._plan, states.rows, self._servo, self._gains, self._shift,
            self._joints, self._root,
        )  # fmt: skip
        return JointTargets(self._joints, self._root)
