"""Intersection of a ray with a geometric primitive, in the primitive's own frame.

A ray starts at ``p`` and has the direction ``d``, which need not be of unit length: distances are multiples of ``d``.
Every function returns the smallest non-negative distance, or infinity if the ray misses. For a ray that starts inside
the primitive this is where it leaves.
"""

from __future__ import annotations

from math import inf, sqrt

from ...core import Array
from ...core.compiled import compiled_entry, compiled_inner

PLANE = 0
"""MuJoCo's code of a plane (`mjGEOM_PLANE`)."""

SPHERE = 2
"""MuJoCo's code of a sphere."""

CAPSULE = 3
"""MuJoCo's code of a capsule."""

ELLIPSOID = 4
"""MuJoCo's code of an ellipsoid."""

CYLINDER = 5
"""MuJoCo's code of a cylinder."""

BOX = 6
"""MuJoCo's code of a box."""

TINY = 1e-15
"""A squared length, or a component of a direction, below this counts as zero."""


@compiled_inner
def first_intersection(enter: float, leave: float) -> float:
    """Return the first end of the interval ``enter`` to ``leave`` that a ray reaches, infinity if it reaches none."""
    return inf if leave < enter or leave < 0.0 else (enter if enter >= 0.0 else leave)


@compiled_inner
def ray_plane(px: float, py: float, pz: float, dx: float, dy: float, dz: float, half_x: float, half_y: float) -> float:
    """Return the distance to the front of the plane z = 0; a half width of 0 means that it is unbounded."""
    if dz > -TINY or pz < 0.0:
        return inf

    t = -pz / dz
    inside = (half_x <= 0.0 or abs(px + t * dx) <= half_x) and (half_y <= 0.0 or abs(py + t * dy) <= half_y)
    return float(t) if inside else inf


@compiled_inner
def ray_sphere(px: float, py: float, pz: float, dx: float, dy: float, dz: float, radius: float) -> float:
    """Return the distance to a sphere, or to an ellipsoid.

    For an ellipsoid, divide ``p`` and ``d`` by its semi-axes and pass a radius of 1.
    """
    a = dx * dx + dy * dy + dz * dz
    b = px * dx + py * dy + pz * dz
    root = b * b - a * (px * px + py * py + pz * pz - radius * radius)
    if root < 0.0:
        return inf

    root = sqrt(root)
    return float(first_intersection((-b - root) / a, (root - b) / a))


@compiled_inner
def _ray_cap(px: float, py: float, z: float, dx: float, dy: float, dz: float, radius: float, sign: float) -> float:
    """Return where a ray enters (``sign`` -1) or leaves (1) the sphere at a capsule's end; NaN if it misses."""
    a = dx * dx + dy * dy + dz * dz
    b = px * dx + py * dy + z * dz
    return (sign * sqrt(b * b - a * (px * px + py * py + z * z - radius * radius)) - b) / a


@compiled_inner
def ray_capsule(px: float, py: float, pz: float, dx: float, dy: float, dz: float, radius: float, half: float) -> float:
    """Return the distance to a capsule along z.

    The ray is intersected with the infinite cylinder first. Where that intersection lies beyond an end of the axis,
    the sphere at this end replaces it.
    """
    a = dx * dx + dy * dy
    b = px * dx + py * dy
    root = b * b - a * (px * px + py * py - radius * radius)
    if root < 0.0 or (a < TINY and px * px + py * py > radius * radius):
        return inf

    root = sqrt(root)
    for sign in (-1.0, 1.0):
        t = (sign * root - b) / a
        # A ray parallel to the axis stays inside the cylinder and meets the ends only.
        z = pz + t * dz if a >= TINY else sign * dz * inf
        if abs(z) > half:
            t = _ray_cap(px, py, pz - (half if z > 0.0 else -half), dx, dy, dz, radius, sign)
        if t >= 0.0:
            return float(t)
    return inf


@compiled_inner
def _slab_interval(p: float, d: float, half: float) -> tuple[float, float]:
    """Return the interval in which one coordinate of a ray lies between -``half`` and ``half``."""
    if abs(d) < TINY:
        return (-inf, inf) if abs(p) <= half else (inf, -inf)

    near = (-half - p) / d
    far = (half - p) / d
    return (near, far) if near <= far else (far, near)


@compiled_inner
def ray_cylinder(px: float, py: float, pz: float, dx: float, dy: float, dz: float, radius: float, half: float) -> float:
    """Return the distance to a cylinder along z: the infinite cylinder's interval cut by that of the two ends."""
    a = dx * dx + dy * dy
    b = px * dx + py * dy
    c = px * px + py * py - radius * radius
    root = b * b - a * c
    if root < 0.0 or (a < TINY and c > 0.0):
        return inf

    enter, leave = _slab_interval(pz, dz, half)
    if a >= TINY:
        root = sqrt(root)
        enter = max(enter, (-b - root) / a)
        leave = min(leave, (root - b) / a)
    return float(first_intersection(enter, leave))


@compiled_inner
def ray_box(
    px: float, py: float, pz: float, dx: float, dy: float, dz: float, half_x: float, half_y: float, half_z: float
) -> float:
    """Return the distance to a box: the intersection of the intervals between its three pairs of faces."""
    enter_x, leave_x = _slab_interval(px, dx, half_x)
    enter_y, leave_y = _slab_interval(py, dy, half_y)
    enter_z, leave_z = _slab_interval(pz, dz, half_z)
    return float(first_intersection(max(enter_x, enter_y, enter_z), min(leave_x, leave_y, leave_z)))


@compiled_entry
def ray_distance(form: int, size: Array, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Return the distance to a primitive of any form.

    Args:
        form: MuJoCo's geom type, see the constants above; for another type the ray misses.
        size: (3,) or more, MuJoCo's geom size [m].
        px: start of the ray [m].
        py: the same.
        pz: the same.
        dx: direction of the ray.
        dy: the same.
        dz: the same.
    """
    if form == CAPSULE:
        return float(ray_capsule(px, py, pz, dx, dy, dz, size[0], size[1]))
    if form == SPHERE:
        return float(ray_sphere(px, py, pz, dx, dy, dz, size[0]))
    if form == ELLIPSOID:
        x = 1.0 / size[0]
        y = 1.0 / size[1]
        z = 1.0 / size[2]
        return float(ray_sphere(px * x, py * y, pz * z, dx * x, dy * y, dz * z, 1.0))
    if form == CYLINDER:
        return float(ray_cylinder(px, py, pz, dx, dy, dz, size[0], size[1]))
    if form == BOX:
        return float(ray_box(px, py, pz, dx, dy, dz, size[0], size[1], size[2]))
    if form == PLANE:
        return float(ray_plane(px, py, pz, dx, dy, dz, size[0], size[1]))
    return inf


@compiled_inner
def surface_normal(form: int, size: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vector normal to the surface at one of its points; it is not normalised and its sign is arbitrary."""
    if form == CAPSULE:
        return x, y, z - min(max(z, -size[1]), size[1])
    if form == CYLINDER:
        # The margins keep rounding from taking a point of the side for one of an end.
        on_end = abs(z) > size[1] * (1.0 - 1e-9) and x * x + y * y < size[0] * size[0] * (1.0 - 1e-9)
        return (0.0, 0.0, 1.0) if on_end else (x, y, 0.0)
    if form == BOX:
        gap_x = abs(abs(x) - size[0])
        gap_y = abs(abs(y) - size[1])
        gap_z = abs(abs(z) - size[2])
        if gap_x <= gap_y and gap_x <= gap_z:
            return 1.0, 0.0, 0.0
        return (0.0, 1.0, 0.0) if gap_y <= gap_z else (0.0, 0.0, 1.0)
    if form == ELLIPSOID:
        return x / (size[0] * size[0]), y / (size[1] * size[1]), z / (size[2] * size[2])
    return (0.0, 0.0, 1.0) if form == PLANE else (x, y, z)
