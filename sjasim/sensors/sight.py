"""What one sensor makes of true joints, compiled: aiming at them, and the error and state of each."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..types import INFERRED, NOT_TRACKED, TRACKED, Array, IntArray

BoolArray = NDArray[np.bool_]


@njit(cache=True)
def aim(
    joints: Array, position: Array, sensor_from_world: Array, dancers: IntArray, directions: Array, distances: Array,
    local: Array,
) -> None:  # fmt: skip
    """Write the way from the sensor to every joint.

    Args:
        joints: (D, J, 3) world positions of the dancers' joints [m].
        position: (3,) the sensor's [m].
        sensor_from_world: (3, 3) rotation.
        dancers: (P,) the dancer behind each person.
        directions: (P J, 3) output, unit vectors in world axes.
        distances: (P J,) output [m].
        local: (P J, 3) output, positions in the sensor's frame [m].
    """
    n = 0
    for dancer in dancers:
        for j in range(joints.shape[1]):
            x, y, z = (
                joints[dancer, j, 0] - position[0],
                joints[dancer, j, 1] - position[1],
                joints[dancer, j, 2] - position[2],
            )
            far = sqrt(x * x + y * y + z * z)
            distances[n] = far
            directions[n, 0], directions[n, 1], directions[n, 2] = x / far, y / far, z / far
            for k in range(3):
                local[n, k] = sensor_from_world[k, 0] * x + sensor_from_world[k, 1] * y + sensor_from_world[k, 2] * z
            n += 1


@njit(cache=True)
def judge(
    local: Array, distances: Array, hits: Array, owners: IntArray, dancers: IntArray, limits: Array, flesh_m: float,
    in_view: BoolArray, visible: BoolArray,
) -> None:  # fmt: skip
    """Write which joints are in view and which of those a ray reaches.

    Args:
        local: (N, 3) joints in the sensor's frame [m].
        distances: (N,) to each joint [m].
        hits: (N,) to the first surface on the way, negative for none [m].
        owners: (N,) whose surface that is.
        dancers: (P,) whose joints these are, N / P each.
        limits: slopes of the field of view, nearest and farthest depth [m].
        flesh_m: how deep in its own dancer's flesh a joint may lie.
        in_view: (N,) output.
        visible: (N,) output.
    """
    each = len(local) // len(dancers)
    for n in range(len(local)):
        x, y, z = local[n, 0], local[n, 1], local[n, 2]
        in_view[n] = abs(x) <= limits[0] * z and abs(y) <= limits[1] * z and z >= limits[2] and z <= limits[3]
        before = distances[n] - (flesh_m if owners[n] == dancers[n // each] else 0.0)
        visible[n] = in_view[n] and (hits[n] < 0.0 or hits[n] >= before)


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
