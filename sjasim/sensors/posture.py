"""A person's posture as a whole: from the joints that are seen to those that are not, and the heading.

A linear regression in the person's own frame, over the person's scale, tells where hidden joints most likely are;
which ones are seen is part of its input.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..types import Array

TRUNK = np.array(
    [JOINT_INDEX[name] for name in ("SpineBase", "SpineMid", "SpineShoulder", "Neck", "ShoulderLeft", "ShoulderRight",
                                    "HipLeft", "HipRight")]
)  # fmt: skip
"""Joints that tell where a person is."""
_PAIRS = np.array([[JOINT_INDEX[f"{name}Left"], JOINT_INDEX[f"{name}Right"]] for name in ("Shoulder", "Hip")])
FEATURES = 4 * len(JOINTS) + 4


def towards_body(points: Array, yaw_rad: float) -> Array:
    """Displacements (N, 3) x, height, z as forward, up, left of somebody at a yaw [m]."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    x, up, z = points.T
    return np.stack([-sin * x - cos * z, up, -cos * x + sin * z], axis=1)


def from_body(places: Array, yaw_rad: float) -> Array:
    """The inverse of `towards_body`."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    forward, up, left = places.T
    return np.stack([-sin * forward - cos * left, up, -cos * forward + sin * left], axis=1)


def heading(joints: Array, seen: NDArray[np.bool_]) -> float:
    """Yaw relative to facing the sensor, from the lines across shoulders and hips; NaN without a pair that is seen."""
    pairs = _PAIRS[seen[_PAIRS].all(axis=1)]
    if len(pairs) == 0:
        return math.nan
    across = (joints[pairs[:, 0]] - joints[pairs[:, 1]]).sum(axis=0)
    return math.atan2(across[2], -across[0])


def features(
    joints: Array, seen: NDArray[np.bool_], mean: Array, yaw_rad: float, scale: float, width: float
) -> tuple[Array, Array] | None:
    """Input of the regression.

    Args:
        joints: (25, 3) points [m]; only those seen count.
        seen: (25,) which are tracked.
        mean: (25, 3) mean posture: forward, up from the floor, left [m].
        yaw_rad: heading relative to facing the sensor.
        scale: stature over 1.75 m.
        width: of the chest, over the scale [m].

    Returns:
        (104,) features and (2,) the x and z that the posture stands at, or None with nothing of the trunk seen.
    """
    trunk = TRUNK[seen[TRUNK]]
    if len(trunk) == 0:
        return None
    standing = from_body(mean[trunk] * scale, yaw_rad)
    place = (joints[trunk] - standing)[:, [0, 2]].mean(axis=0)
    body = towards_body(joints - [place[0], 0.0, place[1]], yaw_rad) / scale - mean
    body[~seen] = 0.0
    rest = [math.cos(yaw_rad), math.sin(yaw_rad), width, 1.0]
    return np.concatenate([body.ravel(), seen.astype(float), rest]), place


def predicted(row: Array, place: Array, weights: Array, mean: Array, yaw_rad: float, scale: float) -> Array:
    """(25, 3) joints as points [m] that go with a row of features.

    Args:
        row: (104,) features.
        place: (2,) x and z they stand at [m].
        weights: (104, 75) of the regression.
        mean: (25, 3) as in `features`.
        yaw_rad: as in `features`.
        scale: as in `features`.
    """
    body = (row @ weights).reshape(-1, 3) + mean
    return np.asarray(from_body(body * scale, yaw_rad) + np.array([place[0], 0.0, place[1]]))
