"""Compiled core of joint sensing: which true joints a sensor can see, and the error and tracking state of each."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..core import INFERRED, NOT_TRACKED, TRACKED, Array, BoolArray, IntArray
from ..core.compiled import compiled_entry, compiled_inner
from .raycast.occlusion import PROJECTED_COLUMNS, mark_occluded, project_geoms


class ErrorColumn(IntEnum):
    """First column of each part of a joint's error state."""

    BIAS = 0
    """Constant error x, y, z [m]."""
    DRIFT = 3
    """Slowly varying error x, y, z [m]."""
    SCALE = 6
    """Present scale of both errors."""
    OCCLUDED_SCALE = 7
    """Scale that is approached while the joint is occluded; 1 is approached while it is visible."""
    GAIN = 8
    """Gain of the first-order filter of the scale, for the interval since the last frame."""
    KEPT = 9
    """Share of the drift that is kept over this interval."""
    INNOVATION = 10
    """Standard deviation of what the drift gains over this interval [m]."""
    HELD = 11
    """1 for a joint that the rest of the body holds in place, so that it is tracked while occluded; else 0."""


ERROR_WIDTH = 12
"""Number of columns of a joint's error state."""


class SensorColumn(IntEnum):
    """First column of each part of the numbers that describe a sensor."""

    ROTATION = 0
    """Rotation sensor from world, row-major (9)."""
    POSITION = 9
    """Position in the world (3) [m]."""
    TANGENTS = 12
    """Tangents of half the horizontal and half the vertical field of view (2)."""
    RANGE = 14
    """Nearest and farthest depth (2) [m]."""


SENSOR_WIDTH = 16
"""Number of columns that describe a sensor."""

SETTLED_SCALE = 1.5
"""Largest error scale of a visible joint that counts as tracked; assumed. A joint that was occluded is inferred until
its error has come down to this."""

LIMBS = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb", "Knee", "Ankle", "Foot")) for name in JOINTS])
"""(25,) Which joints are of arms and legs."""

BODY_DEPTH_M = np.where(LIMBS, 0.13, 0.20)
"""(25,) Largest distance between a joint and the surface of its own body in front of it at which the joint is visible
[m]; assumed. A trunk is that thick, also from the side. A limb is thinner, and is occluded by its own trunk."""

_TORSO_NAMES = ("SpineBase", "SpineMid", "SpineShoulder", "ShoulderLeft", "ShoulderRight", "HipLeft", "HipRight")

TORSO = np.array([JOINT_INDEX[name] for name in _TORSO_NAMES])
"""Joints of the torso. While any of them is visible, the person's occluded joints are known too."""


@compiled_entry
def observe_joints(
    true_joints: Array,
    geoms: IntArray,
    shapes: Array,
    geom_positions: Array,
    geom_rotations: Array,
    dancers: IntArray,
    sensor: Array,
    errors: Array,
    noise: Array,
    visible: BoolArray,
    joints: Array,
    state: NDArray[np.int8],
) -> None:
    """Write every person's joints with their errors, and their tracking states, for one frame.

    Args:
        true_joints: (D, J, 3) true joints in the world [m].
        geoms: (G, 3) the first array of `Solids`.
        shapes: (G, 7) the second array of `Solids`.
        geom_positions: the third array of `Solids`.
        geom_rotations: the fourth array of `Solids`.
        dancers: (P,) dancer behind each person.
        sensor: (`SENSOR_WIDTH`,) see `SensorColumn`.
        errors: (P, J, `ERROR_WIDTH`) error states, updated in place; see `ErrorColumn`.
        noise: (P J, 3) unit white noise.
        visible: (P, J) output: in view and not occluded.
        joints: (P, J, 3) output in the sensor's frame [m]; NaN where a joint is not tracked.
        state: (P, J) output: tracking states.
    """
    projected = np.empty((len(geoms), PROJECTED_COLUMNS))
    project_geoms(sensor, geoms, shapes, geom_positions, geom_rotations, projected)

    joint_count = true_joints.shape[1]
    in_view = np.empty(joint_count, np.bool_)
    for p in range(len(dancers)):
        dancer = dancers[p]
        _transform(true_joints[dancer], sensor, joints[p], visible[p])
        for j in range(joint_count):
            in_view[j] = visible[p, j]
        mark_occluded(joints[p], dancer, BODY_DEPTH_M, geoms, shapes, projected, visible[p])
        _update_errors(errors[p], visible[p], noise[p * joint_count : (p + 1) * joint_count])
        _add_errors(errors[p], in_view, visible[p], joints[p], state[p])


@compiled_inner
def _transform(points: Array, sensor: Array, local: Array, in_view: BoolArray) -> None:
    """Write world points in the sensor's frame, and which of them are in its field of view and range."""
    for j in range(len(points)):
        x = points[j, 0] - sensor[SensorColumn.POSITION]
        y = points[j, 1] - sensor[SensorColumn.POSITION + 1]
        z = points[j, 2] - sensor[SensorColumn.POSITION + 2]
        for k in range(3):
            local[j, k] = sensor[3 * k] * x + sensor[3 * k + 1] * y + sensor[3 * k + 2] * z

        depth = local[j, 2]
        in_width = abs(local[j, 0]) <= sensor[SensorColumn.TANGENTS] * depth
        in_height = abs(local[j, 1]) <= sensor[SensorColumn.TANGENTS + 1] * depth
        in_range = depth >= sensor[SensorColumn.RANGE] and depth <= sensor[SensorColumn.RANGE + 1]
        in_view[j] = in_width and in_height and in_range


@compiled_inner
def _update_errors(errors: Array, visible: BoolArray, noise: Array) -> None:
    """Advance one person's error states by a frame, in place."""
    for j in range(len(errors)):
        target = 1.0 if visible[j] else errors[j, ErrorColumn.OCCLUDED_SCALE]
        errors[j, ErrorColumn.SCALE] += errors[j, ErrorColumn.GAIN] * (target - errors[j, ErrorColumn.SCALE])
        for k in range(3):
            kept = errors[j, ErrorColumn.KEPT] * errors[j, ErrorColumn.DRIFT + k]
            errors[j, ErrorColumn.DRIFT + k] = kept + errors[j, ErrorColumn.INNOVATION] * noise[j, k]


@compiled_inner
def _add_errors(errors: Array, in_view: BoolArray, visible: BoolArray, joints: Array, state: NDArray[np.int8]) -> None:
    """Write one person's tracking states, and add the errors to the joints that are known."""
    torso_visible = False
    for j in TORSO:
        torso_visible = torso_visible or visible[j]

    for j in range(len(joints)):
        if not (torso_visible and in_view[j]):
            state[j] = NOT_TRACKED
            for k in range(3):
                joints[j, k] = np.nan
            continue

        scale = errors[j, ErrorColumn.SCALE]
        settled = visible[j] and scale <= SETTLED_SCALE
        state[j] = TRACKED if settled or errors[j, ErrorColumn.HELD] > 0.0 else INFERRED
        for k in range(3):
            joints[j, k] += scale * (errors[j, ErrorColumn.BIAS + k] + errors[j, ErrorColumn.DRIFT + k])
