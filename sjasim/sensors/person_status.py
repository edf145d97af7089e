"""Position and heading of each person in the world, as a client reports them to the server."""

from __future__ import annotations

import math
from math import tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..choreography.layout import Mount
from ..core import TRACKED, Array, PersonStatus, Skeletons
from ..core.compiled import compiled_entry
from .events.frame_features import HAND_LEFT, HAND_RIGHT, SPINE_BASE, yaw_rad

STATUS_COLUMNS = 5
"""Columns of a status row: x [m], y [m], yaw [rad], share of tracked joints, share of tracked hands."""


class SensorPose(NamedTuple):
    """Pose of a sensor in the world.

    Attributes:
        world_from_sensor: (3, 4) rotation and position.
        facing_yaw_rad: heading of a person who faces the sensor.
    """

    world_from_sensor: Array
    facing_yaw_rad: float


def sensor_pose(mount: Mount) -> SensorPose:
    """Return the pose of a mounted sensor."""
    towards_sensor = -mount.world_from_sensor[:, 2]
    matrix = np.column_stack([mount.world_from_sensor, mount.position])
    return SensorPose(matrix, math.atan2(towards_sensor[1], towards_sensor[0]))


def person_statuses(skeletons: Skeletons, pose: SensorPose) -> tuple[PersonStatus, ...]:
    """Return the status of each person whose SpineBase and hips are known; other persons are left out."""
    found = np.empty((len(skeletons.joints), STATUS_COLUMNS))
    _write_statuses(skeletons.joints, skeletons.state, pose.world_from_sensor, pose.facing_yaw_rad, found)

    rows = zip(skeletons.persons.tolist(), found.tolist(), strict=True)
    return tuple(PersonStatus(person, *row) for person, row in rows if math.isfinite(row[0] + row[1] + row[2]))


@compiled_entry
def _write_statuses(
    joints: Array, state: NDArray[np.int8], world_from_sensor: Array, facing_yaw_rad: float, out: Array
) -> None:
    """Write the status row of each person.

    Args:
        joints: (P, 25, 3) joints in the sensor's frame [m].
        state: (P, 25) tracking states.
        world_from_sensor: (3, 4) rotation and position of the sensor in the world.
        facing_yaw_rad: heading of a person who faces the sensor.
        out: (P, 5) output, see `STATUS_COLUMNS`; position and yaw are NaN where SpineBase or a hip is not known.
    """
    for p in range(len(joints)):
        x = joints[p, SPINE_BASE, 0]
        y = joints[p, SPINE_BASE, 1]
        z = joints[p, SPINE_BASE, 2]
        for k in range(2):
            row = world_from_sensor[k]
            out[p, k] = row[0] * x + row[1] * y + row[2] * z + row[3]

        # The heading is wrapped to -pi..pi.
        yaw = facing_yaw_rad + yaw_rad(joints[p])
        out[p, 2] = yaw - tau * np.rint(yaw / tau)

        tracked = 0
        for j in range(state.shape[1]):
            tracked += state[p, j] == TRACKED
        out[p, 3] = tracked / state.shape[1]
        out[p, 4] = ((state[p, HAND_LEFT] == TRACKED) + (state[p, HAND_RIGHT] == TRACKED)) / 2.0
