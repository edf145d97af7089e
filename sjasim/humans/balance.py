"""Balance: small corrections to the planned joint targets that keep a dancer on its feet; all dancers in one call.

The error of the divergent component of motion moves the pressure under the standing feet (ankles) and the next
foothold (hips of the swinging leg); pitch, roll and yaw errors go to the hips.

Source: englsberger2015, section IV (capture-point control). Gains were found by trial on simulated dances.
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


@dataclass(frozen=True, slots=True)
class BalanceGains:
    """Dimensionless but where noted.

    Attributes:
        pressure_along: pressure point per DCM error, fore and aft.
        pressure_across: the same sideways.
        pitch: hip angle per pitch.
        pitch_rate: hip angle per pitch rate [s].
        roll: hip angle per roll.
        step_along: foothold per DCM error at landing, fore and aft.
        step_across: the same sideways.
        drift: how much of the standing foot's drift the next foothold takes back.
        yaw: hip angle per yaw error.
        droop: share of the pelvis' sideways droop in single support that is fed forward.
        decay: what remains of a foothold's correction after one tick of standing.
        follow: how much of the standing feet's drift the centre of mass goes along with.
    """

    pressure_along: float = 2.5
    pressure_across: float = 2.5
    pitch: float = 0.6
    pitch_rate: float = 0.0
    roll: float = 0.6
    step_along: float = 0.4
    step_across: float = 0.4
    drift: float = 0.5
    yaw: float = 0.5
    droop: float = 0.5
    decay: float = 0.94
    follow: float = 1.0


@njit(cache=True)
def _correct(
    i: int, rate: float, omega: Array, joints: Array, pelvis: Array, yaw: Array, dcm: Array, weight: Array,
    ankles: Array, landing: Array, com: Array, com_velocity: Array, root: Array, root_velocity: Array,
    feet: Array, stiffness: Array, lead: Array, root_lead: Array, load: Array, leg: Array, legs: IntArray,
    gain: tuple[float, ...], shift: Array, out: Array, out_root: Array,
) -> None:  # fmt: skip
    kpx, kpy, kp, kpr, kr, ksx, ksy, kdrift, kyaw, kdroop, decay, follow = gain
    last = joints.shape[1] - 1
    a, b = max(i - 1, 0), min(i + 1, last)
    i = min(i, last)
    per = rate / max(b - a, 1)
    el = np.zeros(2)
    dl = np.zeros(2)
    sh = np.zeros(2)
    for d in range(joints.shape[0]):
        u = out[d]
        for j in range(joints.shape[2]):
            u[j] = joints[d, i, j] + lead[d, j] * per * (joints[d, b, j] - joints[d, a, j])
        for k in range(2):
            out_root[d, k] = pelvis[d, i, k] + root_lead[d, k] * per * (pelvis[d, b, k] - pelvis[d, a, k])
        out_root[d, 2] = yaw[d, i] + root_lead[d, 2] * per * (yaw[d, b] - yaw[d, a])
        w = weight[d, i]
        c, s = cos(root[d, 3]), sin(root[d, 3])
        pitch, roll, off = root[d, 4], root[d, 5], root[d, 3] - yaw[d, i]
        ex = ey = dx = dy = 0.0
        for k in range(2):
            drift = w * (feet[d, 0, k] - ankles[d, i, 0, k]) + (1 - w) * (feet[d, 1, k] - ankles[d, i, 1, k])
            miss = com[d, k] + com_velocity[d, k] / omega[d] - dcm[d, i, k] - follow * drift
            if k == 0:
                ex, dx = miss, drift
            else:
                ey, dy = miss, drift
        el[0], el[1] = c * ex + s * ey, c * ey - s * ex
        dl[0], dl[1] = c * dx + s * dy, c * dy - s * dx
        wide = 0.08 if 0.15 < w < 0.85 else 0.03
        px = min(max(kpx * el[0], -0.09), 0.12)
        py = min(max(kpy * el[1], -wide), wide)
        for side in range(2):
            on = w if side == 0 else 1.0 - w
            sign = 1.0 if side == 0 else -1.0
            hz, hx, hy, ay, ax = legs[side, 0], legs[side, 1], legs[side, 2], legs[side, 4], legs[side, 5]
            if on >= 0.03:
                u[ay] += on * load[d] * px / stiffness[d, ay]
                u[ax] -= on * load[d] * py / stiffness[d, ax]
                u[hy] += on * (kp * pitch + kpr * root_velocity[d, 4])
                u[hx] += on * kr * roll
                u[hz] += on * kyaw * off * 0.5
                if on > 0.6:
                    u[hx] += on * sign * kdroop * 0.05 * load[d] / stiffness[d, hx]
            if landing[d, i, side] > 0:
                grow = exp(omega[d] * min(landing[d, i, side], 0.4))
                sh[0] = min(max(ksx * el[0] * grow - kdrift * dl[0], -0.15), 0.15)
                sh[1] = min(max(ksy * el[1] * grow - kdrift * dl[1], -0.15), 0.15)
                if sign * sh[1] < -0.06:
                    sh[1] = -sign * 0.06
                shift[d, side, 0], shift[d, side, 1], shift[d, side, 2] = sh[0], sh[1], -kyaw * off
                u[ay] -= pitch
                u[ax] -= roll
            else:
                for k in range(3):
                    shift[d, side, k] *= decay
            u[hy] -= shift[d, side, 0] / leg[d]
            u[ay] += shift[d, side, 0] / leg[d]
            u[hx] += shift[d, side, 1] / leg[d]
            u[ax] -= shift[d, side, 1] / leg[d]
            u[hz] += shift[d, side, 2]


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
        self._reference = reference
        self._omega = omega
        self._rate = float(rate_hz)
        self._servos = servos
        self._gains = astuple(gains or BalanceGains())
        dancers = len(omega)
        self._shift = np.zeros((dancers, 2, 3))
        self._joints = np.zeros((dancers, 25))
        self._root = np.zeros((dancers, 5))

    def targets(self, tick: int, states: DancerStates) -> JointTargets:
        """Targets for one control tick; the arrays are overwritten by the next call."""
        r, s = self._reference, self._servos
        _correct(
            tick, self._rate, self._omega, r.joints, r.pelvis, r.yaw, r.dcm, r.weight, r.ankles, r.landing,
            states.com, states.com_velocity, states.root, states.root_velocity, states.ankles, s.stiffness,
            s.lead, s.root_lead, s.weight, s.leg, _LEGS, self._gains, self._shift, self._joints, self._root,
        )  # fmt: skip
        return JointTargets(self._joints, self._root)
