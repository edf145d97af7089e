"""A person's posture as a whole: from the joints that are seen to those that are not, and the heading.

A linear regression in the person's own frame, over the person's scale, tells where hidden joints most likely are;
which ones are seen is part of its input. Limbs are hidden where remembered postures have them whose other joints are
like those seen: an arm before the trunk claps and has the other one beside it, or walks and has it behind, which no
line goes through.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...assets.names import JOINT_INDEX, JOINTS
from ...core import Array

JointMask = NDArray[np.bool_]
TRUNK = np.array(
    [JOINT_INDEX[name] for name in ("SpineBase", "SpineMid", "SpineShoulder", "Neck", "ShoulderLeft", "ShoulderRight",
                                    "HipLeft", "HipRight")]
)  # fmt: skip
"""Joints that tell where a person is."""
_PAIRS = np.array([[JOINT_INDEX[f"{name}Left"], JOINT_INDEX[f"{name}Right"]] for name in ("Shoulder", "Hip")])
_JOINTS = len(JOINTS)
FEATURE_COUNT = 4 * _JOINTS + 4
_LIMBS = np.array([j for j in range(_JOINTS) if j not in TRUNK and j != JOINT_INDEX["Head"]])
_HAND_OF = np.array(
    [2 if not name.startswith(("Wrist", "Hand", "Thumb")) else int(name.endswith("Right")) for name in JOINTS]
)  # 0 and 1 for joints of the left and the right hand
KERNEL_WIDTH_M, LEAST_SEEN = 0.08, 6
"""How unlike a remembered posture, the root of all joints' squared distances, still counts beside the most alike one,
and from how many joints on postures are compared (assumed)."""


def body_from_sensor(points: Array, yaw_rad: float) -> Array:
    """Displacements (N, 3) x, height, z as forward, up, left of somebody at a yaw [m]."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    x, up, z = points.T
    return np.stack([-sin * x - cos * z, up, -cos * x + sin * z], axis=1)


def sensor_from_body(places: Array, yaw_rad: float) -> Array:
    """The inverse of `towards_body`."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    forward, up, left = places.T
    return np.stack([-sin * forward - cos * left, up, -cos * forward + sin * left], axis=1)


@njit(cache=True)
def estimate_yaw(joints: Array, seen: JointMask) -> float:
    """Yaw relative to facing the sensor, from the lines across shoulders and hips; NaN without a pair that is seen."""
    x = z = 0.0
    for left, right in _PAIRS:
        if seen[left] and seen[right]:
            x += joints[left, 0] - joints[right, 0]
            z += joints[left, 2] - joints[right, 2]
    return math.atan2(z, -x) if x != 0.0 or z != 0.0 else math.nan


@njit(cache=True)
def regression_input(
    joints: Array, seen: JointMask, mean: Array, yaw_rad: float, scale: float, width: float, row: Array, place: Array
) -> bool:
    """Write the input of the regression.

    Args:
        joints: (25, 3) points [m]; only those seen count.
        seen: (25,) which are tracked.
        mean: (25, 3) mean posture: forward, up from the floor, left [m].
        yaw_rad: heading relative to facing the sensor.
        scale: stature over 1.75 m.
        width: of the chest, over the scale [m].
        row: (104,) output.
        place: (2,) output, the x and z that the posture stands at.

    Returns:
        whether anything of the trunk is seen; without it, nothing is known.
    """
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    place[:] = 0.0
    count = 0
    for j in TRUNK:
        if seen[j]:
            place[0] += joints[j, 0] + scale * (sin * mean[j, 0] + cos * mean[j, 2])
            place[1] += joints[j, 2] + scale * (cos * mean[j, 0] - sin * mean[j, 2])
            count += 1
    if count == 0:
        return False
    place /= count
    row[:] = 0.0
    for j in range(_JOINTS):
        if seen[j]:
            x, z = joints[j, 0] - place[0], joints[j, 2] - place[1]
            row[3 * j] = (-sin * x - cos * z) / scale - mean[j, 0]
            row[3 * j + 1] = joints[j, 1] / scale - mean[j, 1]
            row[3 * j + 2] = (-cos * x + sin * z) / scale - mean[j, 2]
            row[3 * _JOINTS + j] = 1.0
    row[4 * _JOINTS], row[4 * _JOINTS + 1], row[4 * _JOINTS + 2], row[4 * _JOINTS + 3] = cos, sin, width, 1.0
    return True


@njit(cache=True)
def infer_hidden_limbs(row: Array, seen: JointMask, memory: Array, believed: Array, body: Array) -> None:
    """Put the limbs' hidden joints where like postures have them: their mean, weighted by a normal kernel.

    Args:
        row: (104,) from `features`.
        seen: (25,) which joints are.
        memory: (N, 75) postures over the scale, less their mean.
        believed: (N, 2) how far each counts for the left and the right hand, see `free_space.posture_likelihood`.
        body: (75,) the posture, changed in place.
    """
    if seen.all() or seen.sum() < LEAST_SEEN:
        return
    unlike = np.zeros(len(memory))
    for n in range(len(memory)):
        for j in range(_JOINTS):
            if seen[j]:
                for c in range(3 * j, 3 * j + 3):
                    unlike[n] += (memory[n, c] - row[c]) ** 2
    weight = np.exp((unlike.min() - unlike) / (2.0 * KERNEL_WIDTH_M * KERNEL_WIDTH_M))
    shares = np.empty((3, len(memory)))
    for side in range(3):
        total = 0.0
        for n in range(len(memory)):
            shares[side, n] = weight[n] * believed[n, side] if side < 2 else weight[n]
            total += shares[side, n]
        for n in range(len(memory)):
            shares[side, n] /= total
    for j in _LIMBS:
        if not seen[j]:
            for c in range(3 * j, 3 * j + 3):
                body[c] = 0.0
                for n in range(len(memory)):
                    body[c] += shares[_HAND_OF[j], n] * memory[n, c]


@njit(cache=True)
def estimate_posture(
    joints: Array, seen: JointMask, weights: Array, memory: Array, mean: Array, yaw_rad: float, scale: float, width: float,
    believed: Array, out: Array,
) -> bool:  # fmt: skip
    """Write where all joints most likely are, by those that are seen.

    Args:
        joints: as in `features`, and so on.
        seen: as there.
        weights: (104, 75) of the regression.
        memory: as in `recall`.
        mean: as there.
        yaw_rad: as there.
        scale: as there.
        width: as there.
        believed: as in `recall`.
        out: (25, 3) output, points [m].

    Returns:
        whether anything is known.
    """
    row, place, body = np.empty(FEATURE_COUNT), np.empty(2), np.zeros(3 * _JOINTS)
    if not regression_input(joints, seen, mean, yaw_rad, scale, width, row, place):
        return False
    for k in range(FEATURE_COUNT):
        if row[k] != 0.0:
            for c in range(3 * _JOINTS):
                body[c] += row[k] * weights[k, c]
    infer_hidden_limbs(row, seen, memory, believed, body)
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    for j in range(_JOINTS):
        forward, up = scale * (body[3 * j] + mean[j, 0]), scale * (body[3 * j + 1] + mean[j, 1])
        left = scale * (body[3 * j + 2] + mean[j, 2])
        out[j, 0] = place[0] - sin * forward - cos * left
        out[j, 1] = up
        out[j, 2] = place[1] - cos * forward + sin * left
    return True
