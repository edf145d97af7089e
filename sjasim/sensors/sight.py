"""What one sensor makes of true joints, compiled: where they are in its view, and the error and state of each."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..types import INFERRED, NOT_TRACKED, TRACKED, Array, BoolArray, IntArray


@njit(cache=True)
def locate(
    points: Array, position: Array, sensor_from_world: Array, limits: Array, hidden: BoolArray, local: Array,
    in_view: BoolArray, visible: BoolArray,
) -> None:  # fmt: skip
    """Write where points are for a sensor, and whether they are in view and not hidden.

    Args:
        points: (N, 3) world points [m].
        position: (3,) the sensor's [m].
        sensor_from_world: (3, 3) rotation.
        limits: slopes of the field of view, nearest and farthest depth [m].
        hidden: (N,) which points something stands before.
        local: (N, 3) output, positions in the sensor's frame [m].
        in_view: (N,) output, in the field of view and range.
        visible: (N,) output, in view and not hidden.
    """
    for n in range(len(points)):
        x, y, z = points[n, 0] - position[0], points[n, 1] - position[1], points[n, 2] - position[2]
        for k in range(3):
            local[n, k] = sensor_from_world[k, 0] * x + sensor_from_world[k, 1] * y + sensor_from_world[k, 2] * z
        depth = local[n, 2]
        in_view[n] = (
            abs(local[n, 0]) <= limits[0] * depth
            and abs(local[n, 1]) <= limits[1] * depth
            and depth >= limits[2]
            and depth <= limits[3]
        )
        visible[n] = in_view[n] and not hidden[n]


@njit(cache=True)
def observe(
    local: Array, in_view: BoolArray, visible: BoolArray, torso: IntArray, bias: Array, drift: Array, factor: Array,
    settled: float, joints: Array, state: NDArray[np.int8],
) -> None:  # fmt: skip
    """Write every person's joints with their errors, and their states; NaN where a joint is not tracked.

    Args:
        local: (P J, 3) true joints in the sensor's frame [m].
        in_view: (P J,) which lie in the field of view and range.
        visible: (P J,) which a ray reaches.
        torso: (K,) joints of the torso.
        bias: (P J, 3) constant errors [m].
        drift: (P J, 3) slow errors [m].
        factor: (P J,) how much larger both are now.
        settled: largest factor of a tracked joint.
        joints: (P, J, 3) output [m].
        state: (P, J) output.
    """
    each = joints.shape[1]
    for p in range(joints.shape[0]):
        known = False
        for j in torso:
            known = known or visible[p * each + j]
        for j in range(each):
            n = p * each + j
            if not (known and in_view[n]):
                state[p, j] = NOT_TRACKED
                joints[p, j, :] = np.nan
                continue
            state[p, j] = TRACKED if visible[n] and factor[n] <= settled else INFERRED
            for k in range(3):
                joints[p, j, k] = local[n, k] + factor[n] * (bias[n, k] + drift[n, k])


@njit(cache=True)
def age(
    visible: BoolArray, hidden: Array, blend: Array, kept: float, fresh: float, noise: Array, drift: Array,
    factor: Array,
) -> None:  # fmt: skip
    """Move the errors on, in place.

    Args:
        visible: (N,) which joints are seen now.
        hidden: (N,) factor that a hidden joint's error tends to; a visible one's tends to 1.
        blend: (N,) share of the way there.
        kept: share of the drift that is kept.
        fresh: standard deviation of what comes anew [m].
        noise: (N, 3) unit white noise.
        drift: (N, 3) [m].
        factor: (N,).
    """
    for n in range(len(visible)):
        factor[n] += blend[n] * ((1.0 if visible[n] else hidden[n]) - factor[n])
        for k in range(3):
            drift[n, k] = kept * drift[n, k] + fresh * noise[n, k]
