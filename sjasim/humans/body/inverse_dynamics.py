"""Inverse dynamics of a planned motion: the hinge torques that it needs, as feed-forward of the actuators.

Without feed-forward an actuator produces torque only after an error has grown. All segments count as mass points (a
capsule as two, which keep its moment of inertia), the floor acts at the zero-moment point that follows from their
motion, and each foot carries its share of the weight.

Source: kajita2014, section 3.2 (zero-moment point of mass points).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core import Array, IntArray
from ...core.compiled import compiled_entry, compiled_inner
from .anatomy import Chains
from .kinematics import place_segments

GRAVITY = 9.81
"""Acceleration of gravity [m/s^2]."""

DIFFERENCE_S = 0.02
"""Step of the differences that give accelerations, whatever the control rate is [s]; it smooths the kinks with which
footsteps begin and end (assumed)."""


class PlacedChains(NamedTuple):
    """A motion of T ticks in the world.

    Attributes:
        origins: (T, S, 3) origins of the segments [m].
        axes: (T, 25, 3) axes of the hinges.
        points: (T, P, 3) mass points [m].
    """

    origins: Array
    axes: Array
    points: Array


@compiled_entry
def _place(
    q: Array, pelvis: Array, yaw: Array, parent: IntArray, offset: Array, hinge_segment: IntArray,
    hinge_column: IntArray, hinge_axis: IntArray, hinge_sign: Array, point_segment: IntArray, point_offset: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """See `place_chains`; the tables are those of `Chains`."""
    ticks = len(q)
    segments = len(parent)
    rotation = np.zeros((segments, 3, 3))
    origins = np.zeros((ticks, segments, 3))
    axes = np.zeros((ticks, len(hinge_segment), 3))
    points = np.zeros((ticks, len(point_segment), 3))

    for t in range(ticks):
        place_segments(
            q[t], yaw[t], parent, offset, hinge_segment, hinge_column, hinge_axis, hinge_sign, rotation, origins[t],
            axes[t],
        )  # fmt: skip

        for k in range(3):
            for s in range(segments):
                origins[t, s, k] += pelvis[t, k]

            for p in range(len(point_segment)):
                s = point_segment[p]
                points[t, p, k] = (
                    origins[t, s, k]
                    + rotation[s, k, 0] * point_offset[p, 0]
                    + rotation[s, k, 1] * point_offset[p, 1]
                    + rotation[s, k, 2] * point_offset[p, 2]
                )

    return origins, axes, points


@compiled_entry
def _accelerations(points: Array, dt_s: float, stride: int) -> Array:
    """(T, P, 3) smoothed second differences over ``stride`` ticks; near both ends the points count as resting."""
    ticks = len(points)
    # Multiplying by the reciprocal is cheaper than a division for every coordinate.
    per = 1.0 / (stride * dt_s) ** 2
    out = np.zeros_like(points)

    # Flat views: one loop over all coordinates of a tick.
    at = points.reshape(ticks, -1)
    raw = np.zeros((ticks, points[0].size))
    smooth = out.reshape(ticks, -1)

    for t in range(stride, ticks - stride):
        for k in range(at.shape[1]):
            raw[t, k] = per * (at[t + stride, k] - 2.0 * at[t, k] + at[t - stride, k])

    for t in range(stride, ticks - stride):
        for k in range(at.shape[1]):
            smooth[t, k] = 0.25 * raw[t - stride, k] + 0.5 * raw[t, k] + 0.25 * raw[t + stride, k]

    return out


@compiled_inner
def _add_force(
    force: Array, moment: Array, s: int, px: float, py: float, pz: float, x: float, y: float, z: float
) -> None:
    """Add a force (x, y, z) at a point (px, py, pz) to a segment's force, and its moment about the world's origin."""
    force[s, 0] += x
    force[s, 1] += y
    force[s, 2] += z
    moment[s, 0] += py * z - pz * y
    moment[s, 1] += pz * x - px * z
    moment[s, 2] += px * y - py * x


@compiled_inner
def _parent_wrenches(
    points: Array, accelerations: Array, mass: Array, point_segment: IntArray, parent: IntArray, feet: IntArray,
    ankles: Array, weight: float, force: Array, moment: Array,
) -> None:  # fmt: skip
    """Write the force (S, 3) and moment (S, 3) with which each segment is moved by its parent, for one tick."""
    force[:] = 0.0
    moment[:] = 0.0

    # What moves the mass points and carries their weight.
    for p in range(len(mass)):
        m = mass[p]
        x = accelerations[p, 0]
        y = accelerations[p, 1]
        z = accelerations[p, 2] + GRAVITY
        _add_force(force, moment, point_segment[p], points[p, 0], points[p, 1], points[p, 2], m * x, m * y, m * z)

    x = 0.0
    y = 0.0
    z = 0.0
    moment_x = 0.0
    moment_y = 0.0
    for s in range(len(parent)):
        x += force[s, 0]
        y += force[s, 1]
        z += force[s, 2]
        moment_x += moment[s, 0]
        moment_y += moment[s, 1]

    # The floor gives all of it, at the zero-moment point. The offset from the weighted ankles to that point is the
    # same for both feet.
    off_x = -moment_y / z - weight * ankles[0, 0] - (1.0 - weight) * ankles[1, 0]
    off_y = moment_x / z - weight * ankles[0, 1] - (1.0 - weight) * ankles[1, 1]
    for side in range(2):
        share = weight if side == 0 else 1.0 - weight
        sole_x = ankles[side, 0] + off_x
        sole_y = ankles[side, 1] + off_y
        _add_force(force, moment, feet[side], sole_x, sole_y, 0.0, -share * x, -share * y, -share * z)

    # Children come after their parents, so a backward pass adds up each branch.
    for s in range(len(parent) - 1, 0, -1):
        for k in range(3):
            force[parent[s], k] += force[s, k]
            moment[parent[s], k] += moment[s, k]


@compiled_entry
def _hinge_torques(
    origins: Array, axes: Array, points: Array, accelerations: Array, mass: Array, point_segment: IntArray,
    parent: IntArray, feet: IntArray, hinge_segment: IntArray, hinge_column: IntArray, ankles: Array, weight: Array,
) -> Array:  # fmt: skip
    """See `hinge_torques`; the tables are those of `Chains`."""
    ticks = origins.shape[0]
    segments = origins.shape[1]
    out = np.zeros((ticks, len(hinge_segment)))
    force = np.zeros((segments, 3))
    moment = np.zeros((segments, 3))

    for t in range(ticks):
        _parent_wrenches(
            points[t], accelerations[t], mass, point_segment, parent, feet, ankles[t], weight[t], force, moment
        )

        # The torque is the moment about the segment's origin, along the hinge's axis.
        for h in range(len(hinge_segment)):
            s = hinge_segment[h]
            x = origins[t, s, 0]
            y = origins[t, s, 1]
            z = origins[t, s, 2]
            out[t, hinge_column[h]] = (
                axes[t, h, 0] * (moment[s, 0] - y * force[s, 2] + z * force[s, 1])
                + axes[t, h, 1] * (moment[s, 1] - z * force[s, 0] + x * force[s, 2])
                + axes[t, h, 2] * (moment[s, 2] - x * force[s, 1] + y * force[s, 0])
            )

    return out


def place_chains(chains: Chains, q: Array, pelvis: Array, yaw: Array) -> PlacedChains:
    """Segments, hinge axes and mass points of a planned motion in the world.

    Args:
        chains: the dancer's tables.
        q: (T, 25) hinge angles [rad].
        pelvis: (T, 3) place of the upright pelvis [m].
        yaw: (T,) its heading [rad].
    """
    c = chains
    placed = _place(
        q, pelvis, yaw, c.parent, c.offset, c.hinge_segment, c.hinge_column, c.hinge_axis, c.hinge_sign,
        c.point_segment, c.point_offset,
    )  # fmt: skip
    return PlacedChains(*placed)


def hinge_torques(chains: Chains, placed: PlacedChains, ankles: Array, weight: Array, dt_s: float) -> Array:
    """(T, 25) torques that a planned motion needs, with the columns of its postures [Nm].

    Args:
        chains: the dancer's tables.
        placed: the motion, see `place_chains`.
        ankles: (T, 2, 3) left and right [m].
        weight: (T,) share of the weight on the left foot.
        dt_s: time between rows; in the first and last rows the body counts as resting.
    """
    c = chains
    stride = max(1, round(DIFFERENCE_S / dt_s))
    accelerations = _accelerations(placed.points, dt_s, stride)
    return np.asarray(
        _hinge_torques(
            placed.origins, placed.axes, placed.points, accelerations, c.point_mass, c.point_segment, c.parent, c.feet,
            c.hinge_segment, c.hinge_column, ankles, weight,
        )
    )  # fmt: skip
