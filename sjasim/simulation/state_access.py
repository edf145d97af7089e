"""Where dancers and the robot are in the physics' arrays, and what copies their numbers out of these and into them.

Compiled, and of arrays alone: whoever owns the physics lists its arrays, whoever takes turns calls what copies.
"""

from __future__ import annotations

from numba import njit

from ..core import Array, IntArray
from ..core.memory import index_rows, indices, matrix, vector

PELVIS, TRUNK, BEHIND, POSITIONS, RATES, SITES, ACTUATORS, WIRES = 0, 1, 2, 3, 9, 15, 19, 44
"""Where a dancer's addresses begin in `Physics.where`: its pelvis, the body at its root, the one behind its last; the
root's coordinates (6) and rates (6); ankles and hands (4); actuators of the planned hinges (25, -1 for a body that has
others) and of the tether (5, -1 without one)."""
LEFT_ANGLE, RIGHT_ANGLE, GYRO, BASE, LEFT_MOTOR, RIGHT_MOTOR = range(6)
"""The robot's addresses, last in `Physics.robot`: wheel angles, yaw rate, body and actuators."""


@njit(cache=True)
def gather(
    com: Array, velocity: Array, centre: Array, qpos: Array, qvel: Array, sites: Array, forces: Array, load: Array,
    mass: Array, parent: IntArray, momentum: Array, where: IntArray, out: Array,
) -> None:  # fmt: skip
    """Copy every dancer's rows out of the physics; the output is that of `types.DancerStates`.

    The arrays are those of `Physics.felt`. The velocity of the centre of mass is what MuJoCo's ``mj_subtreeVel`` gives,
    to the last bit, without its sums for all the other bodies.
    """
    for d in range(len(where)):
        pelvis, root = where[d, PELVIS], where[d, TRUNK]
        for b in range(pelvis, where[d, BEHIND]):
            x, y, z = centre[b, 0] - com[root, 0], centre[b, 1] - com[root, 1], centre[b, 2] - com[root, 2]
            turn_x, turn_y, turn_z = velocity[b, 0], velocity[b, 1], velocity[b, 2]
            momentum[b, 0] = (velocity[b, 3] - (y * turn_z - z * turn_y)) * mass[b]
            momentum[b, 1] = (velocity[b, 4] - (z * turn_x - x * turn_z)) * mass[b]
            momentum[b, 2] = (velocity[b, 5] - (x * turn_y - y * turn_x)) * mass[b]
        for b in range(where[d, BEHIND] - 1, pelvis, -1):
            for k in range(3):
                momentum[parent[b], k] += momentum[b, k]
        per = 1.0 / mass[len(parent) + d]
        for k in range(3):
            out[d, k], out[d, 3 + k] = com[pelvis, k], momentum[pelvis, k] * per
            for site in range(4):
                out[d, 18 + 3 * site + k] = sites[where[d, SITES + site], k]
        for k in range(6):
            out[d, 6 + k], out[d, 12 + k] = qpos[where[d, POSITIONS + k]], qvel[where[d, RATES + k]]
        for k in range(5):
            wire = where[d, WIRES + k]
            out[d, 30 + k] = forces[wire] if wire >= 0 else 0.0
        out[d, 35] = load[d]


@njit(cache=True)
def command(targets: Array, where: IntArray, ctrl: Array) -> None:
    """Set the dancers' actuators: (D, 30) targets of the planned hinges, then of the tether; see `Physics.where`."""
    for d in range(len(where)):
        for k in range(targets.shape[1]):
            actuator = where[d, ACTUATORS + k]
            if actuator >= 0:
                ctrl[actuator] = targets[d, k]


@njit(cache=True)
def feel(joints: Array, at: IntArray) -> None:
    """Copy what a frame is about: where joints are, (D, 25, 3), and what the floor carries; ``at`` lists the arrays."""
    sites, where, lifts, lift, load = matrix(at, 0), index_rows(at, 1), vector(at, 2), indices(at, 3), vector(at, 4)
    for d in range(len(where)):
        load[d] = lifts[lift[d]]
        for j in range(where.shape[1]):
            for k in range(3):
                joints[d, j, k] = sites[where[d, j], k]
