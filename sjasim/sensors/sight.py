"""What one sensor makes of true joints, compiled: where they are in its view, and the error and state of each."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX
from ..types import INFERRED, NOT_TRACKED, TRACKED, Array, BoolArray, IntArray

BIAS, DRIFT, FACTOR, HIDDEN, BLEND, ERRORS = 0, 3, 6, 7, 8, 9
"""Columns of a joint's errors: constant error [m], slow error [m], how much larger both are now, the factor that they
tend to while the joint is hidden (1 while it is visible), and the share of the way there at this frame."""

KEPT, FRESH = 16, 17
"""Where the pace of the errors stands in the eye's numbers."""

SETTLED_FACTOR = 1.5
"""A joint that is seen again is tracked once its error is at most this much larger than a visible joint's (assumed)."""

_TORSO_NAMES = ("SpineBase", "SpineMid", "SpineShoulder", "ShoulderLeft", "ShoulderRight", "HipLeft", "HipRight")
TORSO = np.array([JOINT_INDEX[name] for name in _TORSO_NAMES])
"""While any of these is visible, the person's hidden joints are inferred."""


@njit(cache=True)
def _locate(point: Array, eye: Array, local: Array) -> bool:
    """Write where a world point is for a sensor; returns whether it is in the field of view and range."""
    x, y, z = point[0] - eye[9], point[1] - eye[10], point[2] - eye[11]
    for k in range(3):
        local[k] = eye[3 * k] * x + eye[3 * k + 1] * y + eye[3 * k + 2] * z
    depth = local[2]
    wide, high = abs(local[0]) <= eye[12] * depth, abs(local[1]) <= eye[13] * depth
    return bool(wide and high and depth >= eye[14] and depth <= eye[15])


@njit(cache=True)
def _age(errors: Array, visible: bool, kept: float, fresh: float, noise: Array) -> None:
    """Move a joint's errors on, in place."""
    errors[FACTOR] += errors[BLEND] * ((1.0 if visible else errors[HIDDEN]) - errors[FACTOR])
    for k in range(3):
        errors[DRIFT + k] = kept * errors[DRIFT + k] + fresh * noise[k]


@njit(cache=True)
def observe(
    truth: Array, dancers: IntArray, hidden: BoolArray, eye: Array, noise: Array, errors: Array, visible: BoolArray,
    joints: Array, state: NDArray[np.int8],
) -> None:  # fmt: skip
    """Write every person's joints with their errors, and their states; NaN where a joint is not tracked.

    Args:
        truth: (D, J, 3) world points [m].
        dancers: (P,) who is behind each person.
        hidden: (D J,) which points something stands before.
        eye: rotation into the sensor's frame (9, row-major), its position [m], the slopes of the field of view,
            nearest and farthest depth [m]; share of the drift that is kept since the last frame, and standard
            deviation of what comes anew [m].
        noise: (P J, 3) unit white noise; empty at the first frame, at which errors are as the present sight leaves
            them.
        errors: (P, J, `ERRORS`) moved on.
        visible: (P, J) output, in view and not hidden.
        joints: (P, J, 3) output, in the sensor's frame [m].
        state: (P, J) output.
    """
    each = joints.shape[1]
    in_view = np.empty(each, np.bool_)
    for p in range(len(dancers)):
        for j in range(each):
            error = errors[p, j]
            in_view[j] = _locate(truth[dancers[p], j], eye, joints[p, j])
            visible[p, j] = in_view[j] and not hidden[dancers[p] * each + j]
            if len(noise):
                _age(error, visible[p, j], eye[KEPT], eye[FRESH], noise[p * each + j])
            else:
                error[FACTOR] = 1.0 if visible[p, j] else error[HIDDEN]
        known = False
        for j in TORSO:
            known = known or visible[p, j]
        for j in range(each):
            error = errors[p, j]
            if not (known and in_view[j]):
                state[p, j] = NOT_TRACKED
                joints[p, j, :] = np.nan
                continue
            state[p, j] = TRACKED if visible[p, j] and error[FACTOR] <= SETTLED_FACTOR else INFERRED
            for k in range(3):
                joints[p, j, k] += error[FACTOR] * (error[BIAS + k] + error[DRIFT + k])
