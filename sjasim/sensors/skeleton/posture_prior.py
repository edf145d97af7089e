"""Posture prior: the most likely posture, and with it the hidden joints, from the joints that are seen.

A linear regression in the person's own frame, over the person's scale, gives all joints; which joints are seen is part
of its input. The hidden joints of limbs then come from remembered postures that resemble the seen joints. Regression
alone fails there: an arm in front of the trunk either claps, with the other arm beside it, or walks, with the other arm
behind, and no linear function covers both.

Frames: the sensor's is x to its left, height above the floor, z away from it. The person's is forward, up, left. The
yaw is relative to facing the sensor.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner
from .joint_groups import HEAD, TRUNK, TRUNK_PAIRS

JointMask = NDArray[np.bool_]

FEATURE_COUNT = 4 * len(JOINTS) + 4
"""Number of inputs of the regression: coordinates and mask of the joints, cosine and sine of the yaw, width, and 1."""

KERNEL_WIDTH_M = 0.08
"""Standard deviation of the kernel that weights remembered postures by their distance from the seen joints (assumed).

The distance is the root of the summed squares of all joints' distances.
"""

MIN_SEEN = 6
"""Fewest seen joints from which on postures are compared (assumed)."""

_JOINTS = len(JOINTS)
_INFERRED_JOINTS = np.array([j for j in range(_JOINTS) if j not in TRUNK and j != HEAD])

_NO_HAND = 2
# 0 and 1 for joints of the left and the right hand: free space rules out postures for each hand separately.
_HAND_OF = np.array(
    [int(name.endswith("Right")) if name.startswith(("Wrist", "Hand", "Thumb")) else _NO_HAND for name in JOINTS]
)


def body_from_sensor(points: Array, yaw_rad: float) -> Array:
    """Return displacements (N, 3) of the sensor's frame in the frame of a person at a yaw [m]."""
    cos = math.cos(yaw_rad)
    sin = math.sin(yaw_rad)
    x, up, z = points.T
    return np.stack([-sin * x - cos * z, up, -cos * x + sin * z], axis=1)


def sensor_from_body(points: Array, yaw_rad: float) -> Array:
    """Return displacements (N, 3) of the frame of a person at a yaw in the sensor's frame [m]."""
    cos = math.cos(yaw_rad)
    sin = math.sin(yaw_rad)
    forward, up, left = points.T
    return np.stack([-sin * forward - cos * left, up, -cos * forward + sin * left], axis=1)


@compiled_entry
def estimate_yaw(joints: Array, seen: JointMask) -> float:
    """Return the yaw from the lines across shoulders and hips; NaN if neither pair is seen.

    Args:
        joints: (25, 3) points [m].
        seen: (25,) which of them count.
    """
    x = 0.0
    z = 0.0
    for pair in range(len(TRUNK_PAIRS)):
        left = TRUNK_PAIRS[pair, 0]
        right = TRUNK_PAIRS[pair, 1]
        if seen[left] and seen[right]:
            x += joints[left, 0] - joints[right, 0]
            z += joints[left, 2] - joints[right, 2]
    return math.atan2(z, -x) if x != 0.0 or z != 0.0 else math.nan


@compiled_inner
def regression_input(
    joints: Array, seen: JointMask, mean: Array, yaw_rad: float, scale: float, width: float, row: Array, position: Array
) -> bool:
    """Write the input of the regression.

    Args:
        joints: (25, 3) points [m]; only those seen count.
        seen: (25,) which joints are tracked.
        mean: (25, 3) mean posture: forward, up from the floor, left [m].
        yaw_rad: yaw of the person.
        scale: stature over 1.75 m.
        width: width of the chest, over the scale [m].
        row: (`FEATURE_COUNT`,) output.
        position: (2,) output, x and z at which the posture stands [m].

    Returns:
        whether a joint of the trunk is seen; without one the position is unknown and the output is not valid.
    """
    cos = math.cos(yaw_rad)
    sin = math.sin(yaw_rad)
    position[0] = 0.0
    position[1] = 0.0
    # Each seen trunk joint of the mean posture says where the person stands; their mean counts.
    count = 0
    for j in TRUNK:
        if seen[j]:
            position[0] += joints[j, 0] + scale * (sin * mean[j, 0] + cos * mean[j, 2])
            position[1] += joints[j, 2] + scale * (cos * mean[j, 0] - sin * mean[j, 2])
            count += 1
    if count == 0:
        return False
    position[0] /= count
    position[1] /= count

    for k in range(len(row)):
        row[k] = 0.0
    for j in range(_JOINTS):
        if seen[j]:
            x = joints[j, 0] - position[0]
            z = joints[j, 2] - position[1]
            row[3 * j] = (-sin * x - cos * z) / scale - mean[j, 0]
            row[3 * j + 1] = joints[j, 1] / scale - mean[j, 1]
            row[3 * j + 2] = (-cos * x + sin * z) / scale - mean[j, 2]
            row[3 * _JOINTS + j] = 1.0
    row[4 * _JOINTS] = cos
    row[4 * _JOINTS + 1] = sin
    row[4 * _JOINTS + 2] = width
    row[4 * _JOINTS + 3] = 1.0
    return True


@compiled_inner
def infer_hidden_limbs(row: Array, seen: JointMask, memory: Array, likelihood: Array, body: Array) -> None:
    """Move the limbs' hidden joints to the kernel-weighted mean of remembered postures.

    Nothing is changed if all joints are seen, or fewer than `MIN_SEEN`.

    Args:
        row: (`FEATURE_COUNT`,) from `regression_input`.
        seen: (25,) which joints are seen.
        memory: (N, 75) postures over the scale, less their mean [m].
        likelihood: (N, 2) weight of each for the left and the right hand, see `free_space.posture_likelihood`.
        body: (75,) the posture, changed in place [m].
    """
    seen_count = 0
    for j in range(_JOINTS):
        seen_count += seen[j]
    if seen_count == _JOINTS or seen_count < MIN_SEEN:
        return

    # Squared distance of each posture from the seen joints.
    postures = len(memory)
    square = np.zeros(postures)
    smallest = np.inf
    for n in range(postures):
        for j in range(_JOINTS):
            if seen[j]:
                for c in range(3 * j, 3 * j + 3):
                    square[n] += (memory[n, c] - row[c]) ** 2
        smallest = min(smallest, square[n])

    # Weights for the left hand, the right hand and all other joints.
    weights = np.zeros((3, postures))
    for n in range(postures):
        # The best posture has weight 1, so that the weights never all vanish.
        alike = math.exp((smallest - square[n]) / (2.0 * KERNEL_WIDTH_M * KERNEL_WIDTH_M))
        for group in range(3):
            weights[group, n] = alike * likelihood[n, group] if group < _NO_HAND else alike
    for group in range(3):
        total = 0.0
        for n in range(postures):
            total += weights[group, n]
        for n in range(postures):
            weights[group, n] /= total

    for j in _INFERRED_JOINTS:
        if not seen[j]:
            for c in range(3 * j, 3 * j + 3):
                body[c] = 0.0
                for n in range(postures):
                    body[c] += weights[_HAND_OF[j], n] * memory[n, c]


@compiled_entry
def estimate_posture(
    joints: Array, seen: JointMask, weights: Array, memory: Array, mean: Array, yaw_rad: float, scale: float,
    width: float, likelihood: Array, out: Array,
) -> bool:  # fmt: skip
    """Write the most likely position of every joint, given those that are seen.

    Args:
        joints: (25, 3) points [m]; only those seen count.
        seen: (25,) which joints are tracked.
        weights: (`FEATURE_COUNT`, 75) weights of the regression.
        memory: (N, 75) postures over the scale, less their mean [m].
        mean: (25, 3) mean posture: forward, up from the floor, left [m].
        yaw_rad: yaw of the person.
        scale: stature over 1.75 m.
        width: width of the chest, over the scale [m].
        likelihood: (N, 2) weight of each posture for the left and the right hand.
        out: (25, 3) output, points [m].

    Returns:
        whether a joint of the trunk is seen; without one nothing is written.
    """
    row = np.zeros(FEATURE_COUNT)
    position = np.zeros(2)
    if not regression_input(joints, seen, mean, yaw_rad, scale, width, row, position):
        return False

    # Most of the input is zero while joints are hidden.
    body = np.zeros(3 * _JOINTS)
    for k in range(FEATURE_COUNT):
        if row[k] != 0.0:
            for c in range(3 * _JOINTS):
                body[c] += row[k] * weights[k, c]
    infer_hidden_limbs(row, seen, memory, likelihood, body)

    cos = math.cos(yaw_rad)
    sin = math.sin(yaw_rad)
    for j in range(_JOINTS):
        forward = scale * (body[3 * j] + mean[j, 0])
        up = scale * (body[3 * j + 1] + mean[j, 1])
        left = scale * (body[3 * j + 2] + mean[j, 2])
        out[j, 0] = position[0] - sin * forward - cos * left
        out[j, 1] = up
        out[j, 2] = position[1] - cos * forward + sin * left
    return True
