"""The dancers' planned motion on the grid of control ticks: written by the planners, read by the balance controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..types import Array, IntArray


@dataclass(frozen=True, slots=True)
class Reference:
    """Motion of one dancer (T rows) or of all (D, T rows).

    Attributes:
        joints: (T, 25) hinge angles [rad].
        pelvis: (T, 3) [m].
        yaw: (T,) heading [rad].
        dcm: (T, 2) divergent component of motion, com + velocity / omega [m].
        weight: (T,) share of the weight on the left foot.
        ankles: (T, 2, 3) left and right [m].
        foot_yaw: (T, 2) [rad].
        landing: (T, 2) time until a swinging foot lands [s]; 0 for a standing one.
        torque: (T, 25) hinge torques that the motion takes [Nm].
        until: (1,) how many rows are planned; whoever reads on finds the dancer at rest in the last of them. For all
            dancers (D,).
    """

    joints: Array
    pelvis: Array
    yaw: Array
    dcm: Array
    weight: Array
    ankles: Array
    foot_yaw: Array
    landing: Array
    torque: Array
    until: IntArray

    @classmethod
    def empty(cls, dancers: int, ticks: int) -> Reference:
        """All zero, with a leading axis for the dancers; its memory is touched here, not while people dance."""
        shapes = ((25,), (3,), (), (2,), (), (2, 3), (2,), (2,), (25,))
        joints, pelvis, yaw, dcm, weight, ankles, foot_yaw, landing, torque = (
            np.full((dancers, ticks, *shape), 0.0) for shape in shapes
        )
        until = np.zeros(dancers, dtype=np.int64)
        return cls(joints, pelvis, yaw, dcm, weight, ankles, foot_yaw, landing, torque, until)

    def of(self, dancer: int) -> Reference:
        """One dancer's rows, as views: writing to them writes to all."""
        return Reference(
            self.joints[dancer],
            self.pelvis[dancer],
            self.yaw[dancer],
            self.dcm[dancer],
            self.weight[dancer],
            self.ankles[dancer],
            self.foot_yaw[dancer],
            self.landing[dancer],
            self.torque[dancer],
            self.until[dancer : dancer + 1],
        )
