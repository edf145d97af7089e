"""Where a ray meets a primitive, in the primitive's own frame: one equation per form, for everything that casts rays.

A ray starts at ``p`` and goes along ``d``, which need not be of unit length: distances are in multiples of it. What is
returned is the smallest distance that is not negative, infinity if there is none; from inside, the way out.
"""

from __future__ import annotations

from math import inf, sqrt

from numba import njit

from ...core import Array

PLANE, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX = 0, 2, 3, 4, 5, 6
"""MuJoCo's numbers of the forms that rays can meet."""

TINY = 1e-15
"""A direction's square, or part, below this is none."""


@njit(cache=True, error_model="numpy", inline="always")
def first_intersection(enter: float, leave: float) -> float:
    """The one of an interval's ends that a ray comes to."""
    return inf if leave < enter or leave < 0.0 else (enter if enter >= 0.0 else leave)


@njit(cache=True, error_model="numpy", inline="always")
def ray_plane(px: float, py: float, pz: float, dx: float, dy: float, dz: float, half_x: float, half_y: float) -> float:
    """The front of z = 0; a half width of 0 has no end."""
    if dz > -TINY or pz < 0.0:
        return inf
    t = -pz / dz
    inside = (half_x <= 0.0 or abs(px + t * dx) <= half_x) and (half_y <= 0.0 or abs(py + t * dy) <= half_y)
    return float(t) if inside else inf


@njit(cache=True, error_model="numpy", inline="always")
def ray_sphere(px: float, py: float, pz: float, dx: float, dy: float, dz: float, radius: float) -> float:
    """A sphere; an ellipsoid is one of radius 1 once ``p`` and ``d`` are divided by its semi-axes."""
    a, b = dx * dx + dy * dy + dz * dz, px * dx + py * dy + pz * dz
    root = b * b - a * (px * px + py * py + pz * pz - radius * radius)
    if root < 0.0:
        return inf
    root = sqrt(root)
    return float(first_intersection((-b - root) / a, (root - b) / a))


@njit(cache=True, error_model="numpy", inline="always")
def _cap(px: float, py: float, z: float, dx: float, dy: float, dz: float, radius: float, way: float) -> float:
    """Root of the sphere at a capsule's end, entering (``way`` -1) or leaving it (1); NaN without one."""
    a, b = dx * dx + dy * dy + dz * dz, px * dx + py * dy + z * dz
    return (way * sqrt(b * b - a * (px * px + py * py + z * z - radius * radius)) - b) / a


@njit(cache=True, error_model="numpy", inline="always")
def ray_capsule(px: float, py: float, pz: float, dx: float, dy: float, dz: float, radius: float, half: float) -> float:
    """A capsule along z: a ray that meets the endless cylinder enters by its side or by the end that it comes to."""
    a, b = dx * dx + dy * dy, px * dx + py * dy
    root = b * b - a * (px * px + py * py - radius * radius)
    if root < 0.0 or (a < TINY and px * px + py * py > radius * radius):
        return inf
    root = sqrt(root)
    for way in (-1.0, 1.0):
        t = (way * root - b) / a
        z = pz + t * dz if a >= TINY else way * dz * inf
        if abs(z) > half:
            t = _cap(px, py, pz - (half if z > 0.0 else -half), dx, dy, dz, radius, way)
        if t >= 0.0:
            return float(t)
    return inf


@njit(cache=True, error_model="numpy", inline="always")
def _slab(p: float, d: float, half: float) -> tuple[float, float]:
    """Interval of a ray between two planes."""
    if abs(d) < TINY:
        return (-inf, inf) if abs(p) <= half else (inf, -inf)
    near, far = (-half - p) / d, (half - p) / d
    return (near, far) if near <= far else (far, near)


@njit(cache=True, error_model="numpy")
def ray_cylinder(px: float, py: float, pz: float, dx: float, dy: float, dz: float, radius: float, half: float) -> float:
    """A cylinder along z: where the ray is in the endless one and between the ends."""
    a, b = dx * dx + dy * dy, px * dx + py * dy
    c = px * px + py * py - radius * radius
    root = b * b - a * c
    if root < 0.0 or (a < TINY and c > 0.0):
        return inf
    enter, leave = _slab(pz, dz, half)
    if a >= TINY:
        root = sqrt(root)
        enter, leave = max(enter, (-b - root) / a), min(leave, (root - b) / a)
    return float(first_intersection(enter, leave))


@njit(cache=True, error_model="numpy")
def ray_box(
    px: float, py: float, pz: float, dx: float, dy: float, dz: float, half_x: float, half_y: float, half_z: float
) -> float:
    """A box: where the ray is between all three pairs of planes."""
    ax, bx = _slab(px, dx, half_x)
    ay, by = _slab(py, dy, half_y)
    az, bz = _slab(pz, dz, half_z)
    return float(first_intersection(max(ax, ay, az), min(bx, by, bz)))


@njit(cache=True, error_model="numpy")
def ray_distance(form: int, size: Array, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to a primitive of any form; ``size`` (3,) as MuJoCo means it."""
    if form == CAPSULE:
        return float(ray_capsule(px, py, pz, dx, dy, dz, size[0], size[1]))
    if form == SPHERE:
        return float(ray_sphere(px, py, pz, dx, dy, dz, size[0]))
    if form == ELLIPSOID:
        x, y, z = 1.0 / size[0], 1.0 / size[1], 1.0 / size[2]
        return float(ray_sphere(px * x, py * y, pz * z, dx * x, dy * y, dz * z, 1.0))
    if form == CYLINDER:
        return float(ray_cylinder(px, py, pz, dx, dy, dz, size[0], size[1]))
    if form == BOX:
        return float(ray_box(px, py, pz, dx, dy, dz, size[0], size[1], size[2]))
    if form == PLANE:
        return float(ray_plane(px, py, pz, dx, dy, dz, size[0], size[1]))
    return inf


@njit(cache=True, error_model="numpy")
def surface_normal(form: int, size: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector across the surface at one of its points; of any length."""
    if form == CAPSULE:
        return x, y, z - min(max(z, -size[1]), size[1])
    if form == CYLINDER:
        end = abs(z) > size[1] * (1.0 - 1e-9) and x * x + y * y < size[0] * size[0] * (1.0 - 1e-9)
        return (0.0, 0.0, 1.0) if end else (x, y, 0.0)
    if form == BOX:
        a, b, c = abs(abs(x) - size[0]), abs(abs(y) - size[1]), abs(abs(z) - size[2])
        if a <= b and a <= c:
            return 1.0, 0.0, 0.0
        return (0.0, 1.0, 0.0) if b <= c else (0.0, 0.0, 1.0)
    if form == ELLIPSOID:
        return x / (size[0] * size[0]), y / (size[1] * size[1]), z / (size[2] * size[2])
    return (0.0, 0.0, 1.0) if form == PLANE else (x, y, z)
