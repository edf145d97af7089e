"""The dancers' planned motion on the grid of control ticks: written by the planners, read by the balance controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core import Array, IntArray

JOINTS, PELVIS, YAW, DCM, WEIGHT, ANKLES, FOOT_YAW, LANDING, TORQUE, WIDTH = 0, 25, 28, 29, 31, 32, 38, 40, 42, 67
"""Where the parts of a row of the plan begin, and how long it is."""


@dataclass(frozen=True, slots=True)
class ReferenceTrajectory:
    """Motion of one dancer (T rows) or of all (D, T rows).

    Whoever reads one tick of everything reads ``rows``, where it lies together; all else are views of these.

    Attributes:
        rows: (T, 67) the plan, a tick per row.
        joints: (T, 25) hinge angles [rad].
        pelvis: (T, 3) [m].
        yaw: (T,) heading [rad].
        dcm: (T, 2) divergent component of motion, com + velocity / omega [m].
        weight: (T,) share of the weight on the left foot.
        ankles: (T, 2, 3) left and right [m].
        foot_yaw: (T, 2) [rad].
        landing: (T, 2) time until a swinging foot lands [s]; 0 for a standing one.
        torque: (T, 25) hinge torques that the motion takes [Nm].
        planned_rows: (1,) how many rows are planned; whoever reads on finds the dancer at rest in the last of them. For all
            dancers (D,).
    """

    rows: Array
    joints: Array
    pelvis: Array
    yaw: Array
    dcm: Array
    weight: Array
    ankles: Array
    foot_yaw: Array
    landing: Array
    torque: Array
    planned_rows: IntArray

    @classmethod
    def empty(cls, dancers: int, ticks: int) -> ReferenceTrajectory:
        """All zero, with a leading axis for the dancers; its memory is touched here, not while people dance."""
        return cls._over(np.full((dancers, ticks, WIDTH), 0.0), np.zeros(dancers, dtype=np.int64))

    @classmethod
    def _over(cls, rows: Array, planned_rows: IntArray) -> ReferenceTrajectory:
        ticks = rows.shape[:-1]
        return cls(
            rows=rows,
            joints=rows[..., JOINTS:PELVIS],
            pelvis=rows[..., PELVIS:YAW],
            yaw=rows[..., YAW],
            dcm=rows[..., DCM:WEIGHT],
            weight=rows[..., WEIGHT],
            ankles=rows[..., ANKLES:FOOT_YAW].reshape(*ticks, 2, 3),
            foot_yaw=rows[..., FOOT_YAW:LANDING],
            landing=rows[..., LANDING:TORQUE],
            torque=rows[..., TORQUE:],
            planned_rows=planned_rows,
        )

    def for_dancer(self, dancer: int) -> ReferenceTrajectory:
        """One dancer's rows, as views: writing to them writes to all."""
        return ReferenceTrajectory._over(self.rows[dancer], self.planned_rows[dancer : dancer + 1])
