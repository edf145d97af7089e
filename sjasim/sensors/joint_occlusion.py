"""What one sensor makes of true joints, compiled: which it can see, and the error and state of each."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..core import INFERRED, NOT_TRACKED, TRACKED, Array, BoolArray, IntArray
from ..core.memory import cube, index_rows, indices, matrix, vector
from .raycast.occlusion import PROJECTED_COLUMNS, mark_occluded, project_geoms

BIAS, DRIFT, FACTOR, HIDDEN, BLEND, KEPT, FRESH, HELD, ERRORS = 0, 3, 6, 7, 8, 9, 10, 11, 12
"""Columns of a joint's errors: constant error [m], slow error [m], how much larger both are now, the factor that they
tend to while the joint is hidden (1 while it is visible), and the share of the way there at this frame; share of the
slow error that is kept since the last frame, and standard deviation of what comes anew [m]; whether the rest of the
body holds the joint in its place, so that it is tracked while it is hidden (1 or 0)."""

PLACE, SLOPES, RANGE, EYE = 9, 12, 14, 16
"""Columns of an eye after its rotation: place [m], slopes of the field of view, nearest and farthest depth [m]."""

SETTLED_FACTOR = 1.5
"""A joint that is seen again is tracked once its error is at most this much larger than a visible joint's (assumed)."""

LIMBS = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb", "Knee", "Ankle", "Foot")) for name in JOINTS])
"""(25,) Which joints are of arms and legs."""

FLESH_M = np.where(LIMBS, 0.13, 0.20)
"""(25,) A ray that first meets the joint's own dancer so close before the joint counts as reaching it: a trunk is that
thick, also seen from the side; a limb is not, and farther behind other flesh it is hidden by it (assumed)."""

_TORSO_NAMES = ("SpineBase", "SpineMid", "SpineShoulder", "ShoulderLeft", "ShoulderRight", "HipLeft", "HipRight")
TORSO = np.array([JOINT_INDEX[name] for name in _TORSO_NAMES])
"""While any of these is visible, the person's hidden joints are known."""


@njit(cache=True, error_model="numpy")
def observe(
    truth: Array, around: IntArray, own: IntArray, visible: BoolArray, joints: Array, state: NDArray[np.int8],
    frame: int,
) -> None:  # fmt: skip
    """Write every person's joints with their errors, and their states; NaN where a joint is not tracked.

    Args:
        truth: (D, J, 3) world points [m].
        around: a `Memory` of the four arrays of `types.Solids`.
        own: a `Memory` of the sensor's: (P,) who is behind each person; the eye's numbers, (`EYE`,); everybody's
            errors, (P, J, `ERRORS`), moved on; unit white noise, (F, P J, 3).
        visible: (F, P, J) output, in view and not hidden.
        joints: (F, P, J, 3) output, in the sensor's frame [m].
        state: (F, P, J) output.
        frame: which of the F frames to write.
    """
    rows, shape, position, rotation = index_rows(around, 0), matrix(around, 1), matrix(around, 2), matrix(around, 3)
    dancers, eye, errors, noise = indices(own, 0), vector(own, 1), cube(own, 2), cube(own, 3)
    seen = np.empty((len(rows), PROJECTED_COLUMNS))
    project_geoms(eye, rows, shape, position, rotation, seen)
    each = truth.shape[1]
    for p in range(len(dancers)):
        dancer, body, mark = dancers[p], joints[frame, p], visible[frame, p]
        in_view = _locate(truth[dancer], eye, body, mark)
        mark_occluded(body, dancer, FLESH_M, rows, shape, seen, mark)
        _age(errors[p], mark, noise[frame, p * each : (p + 1) * each])
        _tell(errors[p], in_view, mark, body, state[frame, p])


@njit(cache=True, error_model="numpy")
def _locate(points: Array, eye: Array, local: Array, mark: BoolArray) -> BoolArray:
    """Write where world points are for a sensor, and mark which are in its field of view and range; a copy of marks."""
    for j in range(len(points)):
        x, y, z = points[j, 0] - eye[PLACE], points[j, 1] - eye[PLACE + 1], points[j, 2] - eye[PLACE + 2]
        for k in range(3):
            local[j, k] = eye[3 * k] * x + eye[3 * k + 1] * y + eye[3 * k + 2] * z
        depth = local[j, 2]
        wide, high = abs(local[j, 0]) <= eye[SLOPES] * depth, abs(local[j, 1]) <= eye[SLOPES + 1] * depth
        mark[j] = wide and high and depth >= eye[RANGE] and depth <= eye[RANGE + 1]
    return mark.copy()


@njit(cache=True, error_model="numpy")
def _age(errors: Array, visible: BoolArray, noise: Array) -> None:
    """Move one person's errors on, in place."""
    for j in range(len(errors)):
        aim = 1.0 if visible[j] else errors[j, HIDDEN]
        errors[j, FACTOR] += errors[j, BLEND] * (aim - errors[j, FACTOR])
        for k in range(3):
            errors[j, DRIFT + k] = errors[j, KEPT] * errors[j, DRIFT + k] + errors[j, FRESH] * noise[j, k]


@njit(cache=True, error_model="numpy")
def _tell(errors: Array, in_view: BoolArray, visible: BoolArray, joints: Array, state: NDArray[np.int8]) -> None:
    """Write one person's states, and add the errors to the joints that are known."""
    known = False
    for j in TORSO:
        known = known or visible[j]
    for j in range(len(joints)):
        if not (known and in_view[j]):
            state[j] = NOT_TRACKED
            joints[j, :] = np.nan
            continue
        factor = errors[j, FACTOR]
        settled = visible[j] and factor <= SETTLED_FACTOR
        state[j] = TRACKED if settled or errors[j, HELD] > 0.0 else INFERRED
        for k in range(3):
            joints[j, k] += factor * (errors[j, BIAS + k] + errors[j, DRIFT + k])
