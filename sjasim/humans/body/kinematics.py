"""Forward and inverse kinematics of a dancer, compiled: where joints and mass go, and how legs and arms reach.

Source: kajita2014, section 2.5 (closed-form leg). Independent of MuJoCo; a test compares both.
"""

from __future__ import annotations

from math import acos, asin, atan2, cos, sin, sqrt

import numpy as np
from numba import njit

from ...core import Array, IntArray
from .anatomy import Chains


@njit(cache=True)
def _turn(R: Array, axis: int, angle: float) -> None:
    """Right-multiply a rotation in place by a turn about one of its own axes."""
    c, s = cos(angle), sin(angle)
    a = axis + 1 if axis < 2 else 0
    b = axis - 1 if axis > 0 else 2
    for k in range(3):
        u, v = R[k, a], R[k, b]
        R[k, a] = c * u + s * v
        R[k, b] = c * v - s * u


@njit(cache=True)
def place(
    q: Array, yaw: float, parent: IntArray, offset: Array, hinge_segment: IntArray, hinge_column: IntArray,
    hinge_axis: IntArray, hinge_sign: Array, rotation: Array, origin: Array, axes: Array,
) -> None:  # fmt: skip
    """Write every segment's rotation (S, 3, 3) and origin (S, 3) relative to the pelvis' position.

    Args:
        q: (25,) hinge angles [rad].
        yaw: heading of the upright pelvis [rad].
        parent: see `Chains`, as the next five.
        offset: as above.
        hinge_segment: as above.
        hinge_column: as above.
        hinge_axis: as above.
        hinge_sign: as above.
        rotation: (S, 3, 3) output.
        origin: (S, 3) output [m].
        axes: (25, 3) output: the hinges' axes, in their order in the tables.
    """
    j = 0
    for s in range(len(parent)):
        p = parent[s]
        for k in range(3):
            for i in range(3):
                rotation[s, k, i] = rotation[p, k, i] if p >= 0 else (1.0 if k == i else 0.0)
            origin[s, k] = 0.0
            if p >= 0:
                origin[s, k] = origin[p, k] + (
                    rotation[p, k, 0] * offset[s, 0]
                    + rotation[p, k, 1] * offset[s, 1]
                    + rotation[p, k, 2] * offset[s, 2]
                )
        if p < 0:
            _turn(rotation[s], 2, yaw)
        while j < len(hinge_segment) and hinge_segment[j] == s:
            axis = hinge_axis[j]
            for k in range(3):
                axes[j, k] = hinge_sign[j] * rotation[s, k, axis]
            angle = q[hinge_column[j]]
            if angle != 0.0:
                _turn(rotation[s], axis, hinge_sign[j] * angle)
            j += 1


@njit(cache=True)
def _com_offsets(
    q: Array,
    yaw: Array,
    parent: IntArray,
    offset: Array,
    mass: Array,
    centre: Array,
    hinge_segment: IntArray,
    hinge_column: IntArray,
    hinge_axis: IntArray,
    hinge_sign: Array,
) -> Array:
    out = np.zeros((len(q), 3))
    rotation = np.zeros((len(parent), 3, 3))
    origin = np.zeros((len(parent), 3))
    axes = np.zeros((len(hinge_segment), 3))
    total = mass.sum()
    for t in range(len(q)):
        place(q[t], yaw[t], parent, offset, hinge_segment, hinge_column, hinge_axis, hinge_sign, rotation, origin, axes)
        for s in range(len(parent)):
            for k in range(3):
                out[t, k] += mass[s] * (
                    origin[s, k]
                    + rotation[s, k, 0] * centre[s, 0]
                    + rotation[s, k, 1] * centre[s, 1]
                    + rotation[s, k, 2] * centre[s, 2]
                )
        for k in range(3):
            out[t, k] /= total
    return out


def com_offsets(chains: Chains, q: Array, yaw: Array) -> Array:
    """(T, 3) centre of mass relative to the pelvis, in world axes, for (T, 25) postures of an upright pelvis [m]."""
    c = chains
    return np.asarray(
        _com_offsets(
            q, yaw, c.parent, c.offset, c.mass, c.centre, c.hinge_segment, c.hinge_column, c.hinge_axis, c.hinge_sign
        )
    )


@njit(cache=True)
def _leg(
    hip: Array, yaw: float, ankle: Array, foot_yaw: float, thigh: float, shank: float, R: Array, out: Array
) -> None:
    c, s = cos(foot_yaw), sin(foot_yaw)
    dx, dy, z = hip[0] - ankle[0], hip[1] - ankle[1], hip[2] - ankle[2]
    x, y = c * dx + s * dy, c * dy - s * dx
    reach = min(sqrt(x * x + y * y + z * z), thigh + shank - 0.002)
    knee = acos(max(-1.0, min(1.0, (reach**2 - thigh**2 - shank**2) / (2 * thigh * shank))))
    lean = asin(max(-1.0, min(1.0, thigh / reach * sin(knee))))
    ankle_x = atan2(y, z)
    ankle_y = -atan2(x, sqrt(y * y + z * z)) - lean
    for k in range(3):
        for i in range(3):
            R[k, i] = 1.0 if k == i else 0.0
    _turn(R, 2, foot_yaw - yaw)
    _turn(R, 0, -ankle_x)
    _turn(R, 1, -ankle_y - knee)
    hip_z = atan2(-R[0, 1], R[1, 1])
    out[0] = hip_z
    out[1] = atan2(R[2, 1], -R[0, 1] * sin(hip_z) + R[1, 1] * cos(hip_z))
    out[2] = atan2(-R[2, 0], R[2, 2])
    out[3] = knee
    out[4] = ankle_y
    out[5] = ankle_x


@njit(cache=True)
def legs(pelvis: Array, yaw: Array, ankles: Array, foot_yaw: Array, leg: Array, q: Array, columns: IntArray) -> None:
    """Write the leg angles that put both ankles where they should be, soles flat.

    A target out of reach gets the straight leg that points at it.

    Args:
        pelvis: (T, 3) [m].
        yaw: (T,) heading of the upright pelvis [rad].
        ankles: (T, 2, 3) left and right [m].
        foot_yaw: (T, 2) [rad].
        leg: thigh, shank, half hip distance, ankle height [m].
        q: (T, 25) output, leg columns only [rad].
        columns: (2, 6) columns of the left and right leg in ``q``.
    """
    hip, angles, R = np.zeros(3), np.zeros(6), np.zeros((3, 3))
    for t in range(len(pelvis)):
        for side in range(2):
            half = leg[2] if side == 0 else -leg[2]
            hip[0] = pelvis[t, 0] - half * sin(yaw[t])
            hip[1] = pelvis[t, 1] + half * cos(yaw[t])
            hip[2] = pelvis[t, 2]
            _leg(hip, yaw[t], ankles[t, side], foot_yaw[t, side], leg[0], leg[1], R, angles)
            for k in range(6):
                q[t, columns[side, k]] = angles[k]


def joint_positions(chains: Chains, q: Array, pelvis: Array, yaw: float) -> Array:
    """(25, 3) Kinect joints of one posture (25,) of an upright pelvis at a place (3,) [m]."""
    rotation = np.zeros((len(chains.parent), 3, 3))
    origin = np.zeros((len(chains.parent), 3))
    place(
        q, yaw, chains.parent, chains.offset, chains.hinge_segment, chains.hinge_column, chains.hinge_axis,
        chains.hinge_sign, rotation, origin, np.zeros((len(q), 3)),
    )  # fmt: skip
    reach = np.einsum("jab,jb->ja", rotation[chains.joint_segment], chains.joint_offset)
    return np.asarray(pelvis + origin[chains.joint_segment] + reach)


def hand_rotation(chains: Chains, q: Array, segment: int) -> Array:
    """(3, 3) rotation of a segment in the frame of the upright pelvis, for one posture (25,)."""
    rotation = np.zeros((len(chains.parent), 3, 3))
    origin = np.zeros((len(chains.parent), 3))
    place(
        q, 0.0, chains.parent, chains.offset, chains.hinge_segment, chains.hinge_column, chains.hinge_axis,
        chains.hinge_sign, rotation, origin, np.zeros((len(q), 3)),
    )  # fmt: skip
    return np.asarray(rotation[segment])
