"""Inverse dynamics of a plan: the hinge torques that it takes, so that muscles need not wait for an error.

A plan is exact only if the swinging leg's momentum, the load on the standing leg and the arms are carried by somebody.
Every segment counts as point masses (a rod as two, which keeps its moment of inertia), the floor pushes at the
zero-moment point that follows from them, and each foot carries its share of the weight.

Source: kajita2014, section 3.2 (zero-moment point of point masses).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ...core import Array, IntArray
from .anatomy import Chains
from .kinematics import place

GRAVITY = 9.81
SMOOTH_S = 0.02
"""Accelerations are differences over so long, whatever the rate: footsteps begin and end with a kink (assumed) [s]."""


@njit(cache=True)
def _sweep(
    q: Array, pelvis: Array, yaw: Array, parent: IntArray, offset: Array, hinge_segment: IntArray,
    hinge_column: IntArray, hinge_axis: IntArray, hinge_sign: Array, point_segment: IntArray, point_offset: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Segments' origins (T, S, 3), hinges' axes (T, 25, 3) and mass points (T, P, 3) in the world."""
    ticks, segments = len(q), len(parent)
    rotation = np.zeros((segments, 3, 3))
    origins = np.zeros((ticks, segments, 3))
    axes = np.zeros((ticks, len(hinge_segment), 3))
    points = np.zeros((ticks, len(point_segment), 3))
    for t in range(ticks):
        place(
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


@njit(cache=True)
def _accelerations(points: Array, dt_s: float, stride: int) -> Array:
    """Second differences (T, P, 3) over some ticks, smoothed over as many; the ends stand still."""
    ticks, per = len(points), 1.0 / (stride * dt_s) ** 2
    out = np.zeros_like(points)
    at, raw, smooth = points.reshape(ticks, -1), np.zeros((ticks, points[0].size)), out.reshape(ticks, -1)
    for t in range(stride, ticks - stride):
        for k in range(at.shape[1]):
            raw[t, k] = per * (at[t + stride, k] - 2.0 * at[t, k] + at[t - stride, k])
    for t in range(stride, ticks - stride):
        for k in range(at.shape[1]):
            smooth[t, k] = 0.25 * raw[t - stride, k] + 0.5 * raw[t, k] + 0.25 * raw[t + stride, k]
    return out


@njit(cache=True)
def _add(
    force: Array, moment: Array, s: int, px: float, py: float, pz: float, x: float, y: float, z: float
) -> None:  # fmt: skip
    """Add a force at a point to a segment's force and its moment about the world's origin."""
    force[s, 0] += x
    force[s, 1] += y
    force[s, 2] += z
    moment[s, 0] += py * z - pz * y
    moment[s, 1] += pz * x - px * z
    moment[s, 2] += px * y - py * x


@njit(cache=True)
def _balance_sheet(
    points: Array, accelerations: Array, mass: Array, point_segment: IntArray, parent: IntArray, feet: IntArray,
    ankles: Array, weight: float, force: Array, moment: Array,
) -> None:  # fmt: skip
    """Write the force (S, 3) and moment (S, 3) that each segment needs from its parent, for one tick."""
    force[:] = 0.0
    moment[:] = 0.0
    for p in range(len(mass)):
        m, x, y, z = mass[p], accelerations[p, 0], accelerations[p, 1], accelerations[p, 2] + GRAVITY
        _add(force, moment, point_segment[p], points[p, 0], points[p, 1], points[p, 2], m * x, m * y, m * z)
    x, y, z, turn_x, turn_y = 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(len(parent)):
        x += force[s, 0]
        y += force[s, 1]
        z += force[s, 2]
        turn_x += moment[s, 0]
        turn_y += moment[s, 1]
    off_x = -turn_y / z - weight * ankles[0, 0] - (1.0 - weight) * ankles[1, 0]
    off_y = turn_x / z - weight * ankles[0, 1] - (1.0 - weight) * ankles[1, 1]
    for side in range(2):
        share = weight if side == 0 else 1.0 - weight
        sole_x, sole_y = ankles[side, 0] + off_x, ankles[side, 1] + off_y
        _add(force, moment, feet[side], sole_x, sole_y, 0.0, -share * x, -share * y, -share * z)
    for s in range(len(parent) - 1, 0, -1):
        for k in range(3):
            force[parent[s], k] += force[s, k]
            moment[parent[s], k] += moment[s, k]


@njit(cache=True)
def _hinge_torques(
    origins: Array, axes: Array, points: Array, accelerations: Array, mass: Array, point_segment: IntArray,
    parent: IntArray, feet: IntArray, hinge_segment: IntArray, hinge_column: IntArray, ankles: Array, weight: Array,
) -> Array:  # fmt: skip
    ticks, segments = origins.shape[0], origins.shape[1]
    out = np.zeros((ticks, len(hinge_segment)))
    force, moment = np.zeros((segments, 3)), np.zeros((segments, 3))
    for t in range(ticks):
        _balance_sheet(
            points[t], accelerations[t], mass, point_segment, parent, feet, ankles[t], weight[t], force, moment
        )
        for h in range(len(hinge_segment)):
            s = hinge_segment[h]
            x, y, z = origins[t, s, 0], origins[t, s, 1], origins[t, s, 2]
            out[t, hinge_column[h]] = (
                axes[t, h, 0] * (moment[s, 0] - y * force[s, 2] + z * force[s, 1])
                + axes[t, h, 1] * (moment[s, 1] - z * force[s, 0] + x * force[s, 2])
                + axes[t, h, 2] * (moment[s, 2] - x * force[s, 1] + y * force[s, 0])
            )
    return out


def masses(chains: Chains, q: Array, pelvis: Array, yaw: Array) -> tuple[Array, Array, Array]:
    """Where a plan puts segments (T, S, 3), hinges' axes (T, 25, 3) and mass points (T, P, 3) [m]; see below."""
    c = chains
    origins, axes, points = _sweep(
        q, pelvis, yaw, c.parent, c.offset, c.hinge_segment, c.hinge_column, c.hinge_axis, c.hinge_sign,
        c.point_segment, c.point_offset,
    )  # fmt: skip
    return origins, axes, points


def hinge_torques(
    chains: Chains, placed: tuple[Array, Array, Array], ankles: Array, weight: Array, dt_s: float
) -> Array:
    """Torques that a plan takes (T, 25), columns as in its postures [Nm].

    Args:
        chains: the dancer's tables.
        placed: the plan's segments, axes and mass points, see `masses`.
        ankles: (T, 2, 3) left and right [m].
        weight: (T,) share of the weight on the left foot.
        dt_s: time between rows; the first and last few count as standing still.
    """
    c, (origins, axes, points) = chains, placed
    stride = max(1, round(SMOOTH_S / dt_s))
    return np.asarray(
        _hinge_torques(
            origins, axes, points, _accelerations(points, dt_s, stride), c.point_mass, c.point_segment, c.parent,
            c.feet, c.hinge_segment, c.hinge_column, ankles, weight,
        )
    )  # fmt: skip
