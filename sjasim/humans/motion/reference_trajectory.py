"""The reference trajectory: planned motion, a row for each control step.

The planners write it, and the balance controller reads it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from ...core import Array, IntArray


class PlanColumn(IntEnum):
    """First column of each part of a row of `ReferenceTrajectory.rows`; its attributes document the parts."""

    JOINTS = 0
    PELVIS = 25
    YAW = 28
    DCM = 29
    WEIGHT = 31
    ANKLES = 32
    FOOT_YAW = 38
    LANDING = 40
    TORQUE = 42


PLAN_WIDTH = 67
"""Number of columns of `ReferenceTrajectory.rows`."""


@dataclass(frozen=True, slots=True)
class ReferenceTrajectory:
    """Planned motion of one dancer (T rows), or of all (D, T rows).

    ``rows`` holds all parts, so that one row is read at once; the other arrays are views of it.

    Attributes:
        rows: (T, `PLAN_WIDTH`) the plan, see `PlanColumn`.
        joints: (T, 25) hinge angles [rad].
        pelvis: (T, 3) place of the pelvis [m].
        yaw: (T,) its heading [rad].
        dcm: (T, 2) divergent component of motion: centre of mass + velocity / omega [m].
        weight: (T,) share of the weight on the left foot.
        ankles: (T, 2, 3) left and right [m].
        foot_yaw: (T, 2) headings of the feet [rad].
        landing: (T, 2) time until a swinging foot lands [s]; 0 for a standing one.
        torque: (T, 25) hinge torques that the motion needs [Nm].
        planned_rows: (1,) number of rows planned so far; later rows stand for the last planned one, in which the dancer
            rests. For all dancers (D,).
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
        """Trajectories of all dancers, without a planned row."""
        # Filling, unlike np.zeros, makes the system provide the memory now and not while the dancers dance.
        rows = np.full((dancers, ticks, PLAN_WIDTH), 0.0)
        return cls._over(rows, np.zeros(dancers, dtype=np.int64))

    @classmethod
    def _over(cls, rows: Array, planned_rows: IntArray) -> ReferenceTrajectory:
        """The trajectory whose parts are views of some rows."""
        ticks = rows.shape[:-1]
        return cls(
            rows=rows,
            joints=rows[..., PlanColumn.JOINTS : PlanColumn.PELVIS],
            pelvis=rows[..., PlanColumn.PELVIS : PlanColumn.YAW],
            yaw=rows[..., PlanColumn.YAW],
            dcm=rows[..., PlanColumn.DCM : PlanColumn.WEIGHT],
            weight=rows[..., PlanColumn.WEIGHT],
            ankles=rows[..., PlanColumn.ANKLES : PlanColumn.FOOT_YAW].reshape(*ticks, 2, 3),
            foot_yaw=rows[..., PlanColumn.FOOT_YAW : PlanColumn.LANDING],
            landing=rows[..., PlanColumn.LANDING : PlanColumn.TORQUE],
            torque=rows[..., PlanColumn.TORQUE :],
            planned_rows=planned_rows,
        )

    def for_dancer(self, dancer: int) -> ReferenceTrajectory:
        """The trajectory of one dancer, as views of this one."""
        return ReferenceTrajectory._over(self.rows[dancer], self.planned_rows[dancer : dancer + 1])
