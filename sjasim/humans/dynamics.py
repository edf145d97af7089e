"""Inverse dynamics of a plan: the hinge torques that it takes, so that muscles need not wait for an error.

A plan is exact only if the swinging leg's momentum, the load on the standing leg and the arms are carried by somebody.
Every segment counts as point masses (a rod as two, which keeps its moment of inertia), the floor pushes at the
zero-moment point that follows from them, and each foot carries its share of the weight.

Source: kajita2014, section 3.2 (zero-moment point of point masses).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..types import Array, IntArray
from .anatomy import Chains
from .kinematics import place

GRAVITY = 9.81


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
def _accelerations(points: Array, dt_s: float) -> Array:
    """Second differences (T, P, 3), smoothed over three ticks; the ends take their neighbours' values."""
    n = len(points)
    raw = np.zeros_like(points)
    if n < 3:
        return raw
    for t in range(1, n - 1):
        raw[t] = (points[t + 1] - 2.0 * points[t] + points[t - 1]) / dt_s**2
    raw[0], raw[n - 1] = raw[1], raw[n - 2]
    out = raw.copy()
    for t in range(1, n - 1):
        out[t] = 0.25 * raw[t - 1] + 0.5 * raw[t] + 0.25 * raw[t + 1]
    return out


@njit(cache=True)
def _add(force: Array, moment: Array, point: Array, push: Array) -> None:
    """Add a force at a point to a force and its moment about the world's origin."""
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        force[k] += push[k]
        moment[k] += point[a] * push[b] - point[b] * push[a]


@njit(cache=True)
def _balance_sheet(
    points: Array, accelerations: Array, mass: Array, point_segment: IntArray, parent: IntArray, feet: IntArray,
    ankles: Array, weight: float, force: Array, moment: Array,
) -> None:  # fmt: skip
    """Write the force (S, 3) and moment (S, 3) that each segment needs from its parent, for one tick."""
    force[:] = 0.0
    moment[:] = 0.0
    push, total, turn = np.zeros(3), np.zeros(3), np.zeros(3)
    for p in range(len(mass)):
        push[:] = mass[p] * accelerations[p]
        push[2] += mass[p] * GRAVITY
        _add(force[point_segment[p]], moment[point_segment[p]], points[p], push)
        _add(total, turn, points[p], push)
    zmp_x, zmp_y = -turn[1] / total[2], turn[0] / total[2]
    for side in range(2):
        share = weight if side == 0 else 1.0 - weight
        foot = feet[side]
        sole = np.zeros(3)
        sole[0] = ankles[side, 0] + zmp_x - weight * ankles[0, 0] - (1.0 - weight) * ankles[1, 0]
        sole[1] = ankles[side, 1] + zmp_y - weight * ankles[0, 1] - (1.0 - weight) * ankles[1, 1]
        _add(force[foot], moment[foot], sole, -share * total)
    for s in range(len(parent) - 1, 0, -1):
        force[parent[s]] += force[s]
        moment[parent[s]] += moment[s]


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
            torque = 0.0
            for k in range(3):
                a, b = (k + 1) % 3, (k + 2) % 3
                arm = origins[t, s, a] * force[s, b] - origins[t, s, b] * force[s, a]
                torque += axes[t, h, k] * (moment[s, k] - arm)
            out[t, hinge_column[h]] = torque
    return out


def hinge_torques(
    chains: Chains, q: Array, pelvis: Array, yaw: Array, ankles: Array, weight: Array, dt_s: float
) -> Array:
    """Torques that a plan takes (T, 25), columns as in ``q`` [Nm].

    Args:
        chains: the dancer's tables.
        q: (T, 25) hinge angles [rad].
        pelvis: (T, 3) of the upright pelvis [m].
        yaw: (T,) its heading [rad].
        ankles: (T, 2, 3) left and right [m].
        weight: (T,) share of the weight on the left foot.
        dt_s: time between rows; fewer than three rows count as standing still.
    """
    c = chains
    origins, axes, points = _sweep(
        q, pelvis, yaw, c.parent, c.offset, c.hinge_segment, c.hinge_column, c.hinge_axis, c.hinge_sign,
        c.point_segment, c.point_offset,
    )  # fmt: skip
    return np.asarray(
        _hinge_torques(
            origins, axes, points, _accelerations(points, dt_s), c.point_mass, c.point_segment, c.parent, c.feet,
            c.hinge_segment, c.hinge_column, ankles, weight,
        )
    )  # fmt: skip
