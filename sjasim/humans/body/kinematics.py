"""Forward kinematics, centre of mass and inverse kinematics of the legs, as compiled functions.

Independent of MuJoCo; a test compares both.

Source: kajita2014, section 2.5 (closed-form inverse kinematics of a leg).
"""

from __future__ import annotations

from math import acos, asin, atan2, cos, sin, sqrt

import numpy as np

from ...core import Array, IntArray
from ...core.compiled import compiled_entry, compiled_inner
from .anatomy import Chains

KNEE_MARGIN_M = 0.002
"""A leg is never stretched nearer than this to its full length, where its inverse kinematics is singular [m]."""


@compiled_inner
def _rotate(R: Array, axis: int, angle: float) -> None:
    """Right-multiply a rotation matrix (3, 3), in place, by a rotation about one of its own axes."""
    c = cos(angle)
    s = sin(angle)
    a = axis + 1 if axis < 2 else 0
    b = axis - 1 if axis > 0 else 2

    for k in range(3):
        u = R[k, a]
        v = R[k, b]
        R[k, a] = c * u + s * v
        R[k, b] = c * v - s * u


@compiled_entry
def place_segments(
    q: Array, yaw: float, parent: IntArray, offset: Array, hinge_segment: IntArray, hinge_column: IntArray,
    hinge_axis: IntArray, hinge_sign: Array, rotation: Array, origin: Array, axes: Array,
) -> None:  # fmt: skip
    """Write the rotation of every segment, and its origin relative to the pelvis.

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
        axes: (25, 3) output: axes of the hinges in the world, in their order in the tables.
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
            _rotate(rotation[s], 2, yaw)

        # Hinges are sorted by segment, so one pass over both is enough.
        while j < len(hinge_segment) and hinge_segment[j] == s:
            axis = hinge_axis[j]
            for k in range(3):
                axes[j, k] = hinge_sign[j] * rotation[s, k, axis]

            angle = q[hinge_column[j]]
            if angle != 0.0:
                _rotate(rotation[s], axis, hinge_sign[j] * angle)
            j += 1


@compiled_entry
def _com_offsets(
    q: Array, yaw: Array, parent: IntArray, offset: Array, mass: Array, centre: Array, hinge_segment: IntArray,
    hinge_column: IntArray, hinge_axis: IntArray, hinge_sign: Array,
) -> Array:  # fmt: skip
    """See `com_offsets`; the tables are those of `Chains`."""
    out = np.zeros((len(q), 3))
    rotation = np.zeros((len(parent), 3, 3))
    origin = np.zeros((len(parent), 3))
    axes = np.zeros((len(hinge_segment), 3))
    total = mass.sum()

    for t in range(len(q)):
        place_segments(
            q[t], yaw[t], parent, offset, hinge_segment, hinge_column, hinge_axis, hinge_sign, rotation, origin, axes
        )

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
    """(T, 3) centre of mass relative to the pelvis, in world axes [m].

    Args:
        chains: the dancer's tables.
        q: (T, 25) postures [rad].
        yaw: (T,) heading of the upright pelvis [rad].
    """
    c = chains
    return np.asarray(
        _com_offsets(
            q, yaw, c.parent, c.offset, c.mass, c.centre, c.hinge_segment, c.hinge_column, c.hinge_axis, c.hinge_sign
        )
    )


@compiled_inner
def _leg_angles(
    hip: Array, yaw: float, ankle: Array, foot_yaw: float, thigh: float, shank: float, R: Array, out: Array
) -> None:
    """Write the six angles of one leg, from the hip down, that put its ankle at a place with the sole flat.

    Args:
        hip: (3,) the hip [m].
        yaw: heading of the pelvis [rad].
        ankle: (3,) the place [m].
        foot_yaw: heading of the foot [rad].
        thigh: length [m].
        shank: length [m].
        R: (3, 3) scratch.
        out: (6,) output, in the order of `LEG_JOINTS` [rad].
    """
    # The hip as the foot sees it: forward, left, up.
    c = cos(foot_yaw)
    s = sin(foot_yaw)
    dx = hip[0] - ankle[0]
    dy = hip[1] - ankle[1]
    z = hip[2] - ankle[2]
    x = c * dx + s * dy
    y = c * dy - s * dx

    # Thigh, shank and the line from ankle to hip form a triangle; the knee follows from the law of cosines.
    reach = min(sqrt(x * x + y * y + z * z), thigh + shank - KNEE_MARGIN_M)
    knee = acos(max(-1.0, min(1.0, (reach**2 - thigh**2 - shank**2) / (2 * thigh * shank))))
    lean = asin(max(-1.0, min(1.0, thigh / reach * sin(knee))))
    ankle_x = atan2(y, z)
    ankle_y = -atan2(x, sqrt(y * y + z * z)) - lean

    # Going up from the foot gives the thigh's rotation seen from the pelvis, which the hip has to make.
    for k in range(3):
        for i in range(3):
            R[k, i] = 1.0 if k == i else 0.0
    _rotate(R, 2, foot_yaw - yaw)
    _rotate(R, 0, -ankle_x)
    _rotate(R, 1, -ankle_y - knee)

    hip_z = atan2(-R[0, 1], R[1, 1])
    out[0] = hip_z
    out[1] = atan2(R[2, 1], -R[0, 1] * sin(hip_z) + R[1, 1] * cos(hip_z))
    out[2] = atan2(-R[2, 0], R[2, 2])
    out[3] = knee
    out[4] = ankle_y
    out[5] = ankle_x


@compiled_entry
def leg_angles(
    pelvis: Array, yaw: Array, ankles: Array, foot_yaw: Array, leg: Array, q: Array, columns: IntArray
) -> None:
    """Write the leg angles that put both ankles at their places, with flat soles.

    A place out of reach gives the stretched leg that points at it.

    Args:
        pelvis: (T, 3) [m].
        yaw: (T,) heading of the upright pelvis [rad].
        ankles: (T, 2, 3) left and right [m].
        foot_yaw: (T, 2) [rad].
        leg: thigh, shank, half hip distance, ankle height [m].
        q: (T, 25) output, leg columns only [rad].
        columns: (2, 6) columns of the left and right leg in ``q``.
    """
    hip = np.zeros(3)
    angles = np.zeros(6)
    R = np.zeros((3, 3))

    for t in range(len(pelvis)):
        for side in range(2):
            half = leg[2] if side == 0 else -leg[2]
            hip[0] = pelvis[t, 0] - half * sin(yaw[t])
            hip[1] = pelvis[t, 1] + half * cos(yaw[t])
            hip[2] = pelvis[t, 2]

            _leg_angles(hip, yaw[t], ankles[t, side], foot_yaw[t, side], leg[0], leg[1], R, angles)
            for k in range(6):
                q[t, columns[side, k]] = angles[k]


def _posture(chains: Chains, q: Array, yaw: float) -> tuple[Array, Array]:
    """Rotations (S, 3, 3) and origins (S, 3) of all segments in one posture, relative to the pelvis."""
    rotation = np.zeros((len(chains.parent), 3, 3))
    origin = np.zeros((len(chains.parent), 3))
    axes = np.zeros((len(q), 3))
    place_segments(
        q, yaw, chains.parent, chains.offset, chains.hinge_segment, chains.hinge_column, chains.hinge_axis,
        chains.hinge_sign, rotation, origin, axes,
    )  # fmt: skip
    return rotation, origin


def joint_positions(chains: Chains, q: Array, pelvis: Array, yaw: float) -> Array:
    """(25, 3) Kinect joints of one posture (25,) of an upright pelvis at a place (3,) [m]."""
    rotation, origin = _posture(chains, q, yaw)
    offset = np.einsum("jab,jb->ja", rotation[chains.joint_segment], chains.joint_offset)
    return np.asarray(pelvis + origin[chains.joint_segment] + offset)


def segment_rotation(chains: Chains, q: Array, segment: int) -> Array:
    """(3, 3) rotation of a segment in the frame of the upright pelvis, for one posture (25,)."""
    rotation, _ = _posture(chains, q, 0.0)
    return np.asarray(rotation[segment])
