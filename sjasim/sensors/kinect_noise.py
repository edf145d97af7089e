"""Noise model of a Kinect v2: axial and lateral noise, mixed and missing pixels, range limits, whole millimetres.

Source: fankhauser2015, section IV (axial noise by depth and angle of incidence, lateral noise of 1.6 mm). Mixed pixels
at edges, missing pixels at grazing incidence and the systematic distance error are described in words elsewhere; their
sizes here are assumed.

Random numbers are a hash of a key per frame and the pixel's index: there is no state and no table, and every process
draws the same. Floor that has only floor around it gets no noise: segmentation removes it anyway, at some five standard
deviations above the floor.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..core import IntArray
from ..core.compiled import compiled_entry
from .depth_camera import RenderedDepth
from .raycast.primitives import PLANE

LATERAL_M = 0.0016
"""Standard deviation of the lateral noise: where on the surface a pixel measures. Source: fankhauser2015."""

MIXING_STEP_M = (0.06, 2.5)
"""Smallest and largest depth step between neighbours at which a pixel mixes both surfaces (assumed).

Across a larger step the sensor separates the two by phase.
"""

EDGE_DROPOUT = 0.30
"""Share of the pixels at such a step that have no depth (assumed)."""

EDGE_MIXING = 0.25
"""Share of the pixels at such a step whose depth lies between both surfaces (assumed)."""

GRAZING_RAD = math.radians(85.0)
"""Angle of incidence beyond which pixels are missing (assumed)."""

GRAZING_DROPOUT = 0.7
"""Share of the pixels beyond `GRAZING_RAD` that have no depth (assumed)."""

WIGGLE_M = 0.003
"""Amplitude of the systematic distance error of continuous-wave time of flight, the wiggling error (assumed)."""

WIGGLE_PERIOD_M = 1.87
"""Period of the wiggling error (assumed)."""

MAX_AXIAL_M = 0.04
"""Upper bound of the axial standard deviation; beyond it a sensor gives no depth at all (assumed)."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST_MULTIPLIER = np.uint64(0xBF58476D1CE4E5B9)
_SECOND_MULTIPLIER = np.uint64(0x94D049BB133111EB)
_LOW_BITS = np.uint64(0xFFFF)

# The functions of this file are inlined before type inference: that costs a second at first use, but a frame takes a
# fifth less time than with `compiled_inner`.


@njit(cache=True, inline="always")
def _random_bits(key: np.uint64, count: int) -> np.uint64:
    """Return 64 random bits, a hash of both arguments (finaliser of splitmix64)."""
    x = key + np.uint64(count + 1) * _GOLDEN
    x = (x ^ (x >> np.uint64(30))) * _FIRST_MULTIPLIER
    x = (x ^ (x >> np.uint64(27))) * _SECOND_MULTIPLIER
    return x ^ (x >> np.uint64(31))


@njit(cache=True, inline="always")
def _uniform(bits: np.uint64, which: int) -> float:
    """Return one of the four uniform numbers in [0, 1) that 64 bits contain."""
    return float((bits >> np.uint64(16 * which)) & _LOW_BITS) / 65536.0


@njit(cache=True, inline="always")
def _normal(bits: np.uint64) -> float:
    """Return a nearly normal number of variance 1: the sum of four uniform ones, at most 3.5 in size."""
    total = _uniform(bits, 0) + _uniform(bits, 1) + _uniform(bits, 2) + _uniform(bits, 3)
    return float((total - 2.0) * 1.7320508075688772)


@njit(cache=True, inline="always")
def axial_noise_m(depth_m: float, slant: float) -> float:
    """Return the standard deviation of the depth [m], at most `MAX_AXIAL_M`.

    Source: fankhauser2015, eq. (6), without its term for sunlight.

    Args:
        depth_m: true depth.
        slant: (theta / (pi/2 - theta))^2 for the angle of incidence theta.
    """
    oblique = 0.1 * depth_m * math.sqrt(depth_m) * slant
    return min(0.001 * (1.5 - 0.5 * depth_m + 0.3 * depth_m * depth_m + oblique), MAX_AXIAL_M)


def _tabulate_slants() -> NDArray[np.float32]:
    """Return ``slant`` of `axial_noise_m` by the cosine of incidence, in steps of 1 / `_STEPS`, up to `GRAZING_RAD`."""
    angle = np.minimum(np.arccos(np.arange(_STEPS + 1) / _STEPS), GRAZING_RAD)
    return np.asarray((angle / (math.pi / 2 - angle)) ** 2, dtype=np.float32)


_STEPS = 2048

# Logarithms, roots and sines at every pixel would cost more than all of the rest together, hence the tables.
_SLANTS = _tabulate_slants()
_GRAZING_COSINE = math.cos(GRAZING_RAD)
_WIGGLES_M = (WIGGLE_M * np.sin(2.0 * np.pi * np.arange(0.0, 12.0, 0.01) / WIGGLE_PERIOD_M)).astype(np.float32)
"""Wiggling error by depth in centimetres."""


@njit(cache=True, inline="always")
def _mixing_neighbour_m(depth: NDArray[np.float64], v: int, u: int) -> float:
    """Return the depth of the neighbour across the largest step at which pixels mix, 0 without one."""
    height, width = depth.shape
    own = depth[v, u]
    other = 0.0
    largest = MIXING_STEP_M[0]
    for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        neighbour = depth[min(max(v + dv, 0), height - 1), min(max(u + du, 0), width - 1)]
        step = abs(neighbour - own)
        if largest < step < MIXING_STEP_M[1]:
            other = neighbour
            largest = step
    return other


@njit(cache=True, inline="always")
def _displaced_pixel(
    depth: NDArray[np.float64], v: int, u: int, key: np.uint64, fx: float, uniform: float
) -> tuple[int, int, float]:
    """Return the pixel that lateral noise makes a pixel measure, and the exact depth there [m].

    Between two pixels of one surface depth is interpolated. An edge between them lies anywhere, so a displacement of a
    quarter of a pixel has crossed it in one case of four: ``uniform`` decides.
    """
    height, width = depth.shape
    reach = LATERAL_M * fx / depth[v, u] * 2.4494897427831781  # the sum of two uniform numbers has a variance of 1/6
    bits = _random_bits(key, 3 * (v * width + u) + 2)
    down = reach * (_uniform(bits, 0) + _uniform(bits, 1) - 1.0)
    right = reach * (_uniform(bits, 2) + _uniform(bits, 3) - 1.0)
    row = min(max(v + round(down), 0), height - 1)
    column = min(max(u + round(right), 0), width - 1)

    own = depth[row, column]
    measured = own
    for part, dv, du in ((down - round(down), 1, 0), (right - round(right), 0, 1)):
        side = 1 if part > 0.0 else -1
        neighbour = depth[min(max(row + side * dv, 0), height - 1), min(max(column + side * du, 0), width - 1)]
        if abs(neighbour - own) < MIXING_STEP_M[0]:
            measured += abs(part) * (neighbour - own)
        elif uniform < abs(part):
            measured = neighbour
            break
    return row, column, measured


@njit(cache=True, error_model="numpy", inline="always")
def _noisy_depth_m(
    depth: NDArray[np.float64], incidence: NDArray[np.float32], v: int, u: int, key: np.uint64, fx: float
) -> float:
    """Return the depth that the sensor reports for one pixel, 0 if it has none [m]."""
    own = depth[v, u]
    if own == np.inf:
        return 0.0

    # Three independent hashes per pixel: 3 n here, 3 n + 1 for the axial and 3 n + 2 for the lateral noise.
    bits = _random_bits(key, 3 * (v * depth.shape[1] + u))
    other = _mixing_neighbour_m(depth, v, u)
    edge_draw = _uniform(bits, 0)
    if other > 0.0 and edge_draw < EDGE_DROPOUT:
        return 0.0

    # Lateral noise comes first: depth, incidence and axial noise are those of the displaced pixel.
    row, column, measured = _displaced_pixel(depth, v, u, key, fx, _uniform(bits, 3))
    cosine = min(incidence[row, column], np.float32(1.0))
    if measured == np.inf or (cosine < _GRAZING_COSINE and _uniform(bits, 2) < GRAZING_DROPOUT):
        return 0.0

    if other > 0.0 and edge_draw < EDGE_DROPOUT + EDGE_MIXING:
        share = _uniform(bits, 1)
        measured = share * own + (1.0 - share) * other

    # Linear interpolation in the table of slants.
    place = cosine * np.float32(_STEPS)
    step = min(int(place), _STEPS - 1)
    slant = _SLANTS[step] + (place - step) * (_SLANTS[step + 1] - _SLANTS[step])

    wiggle = _WIGGLES_M[min(int(100.0 * measured + 0.5), len(_WIGGLES_M) - 1)]
    noise = axial_noise_m(measured, slant) * _normal(_random_bits(key, 3 * (v * depth.shape[1] + u) + 1))
    return float(measured + wiggle + noise)


@njit(cache=True, inline="always")
def _whole_mm(depth_m: float, near: float, far: float) -> np.uint16:
    """Return a depth in whole millimetres, 0 outside of the range."""
    return np.uint16(np.int32((depth_m if (near <= depth_m) & (depth_m <= far) else 0.0) * 1000.0 + 0.5))


@compiled_entry
def _measure(
    depth: NDArray[np.float64], geom: NDArray[np.int16], incidence: NDArray[np.float32], is_floor: NDArray[np.bool_],
    key: np.uint64, fx: float, near: float, far: float, out: NDArray[np.uint16],
) -> None:  # fmt: skip
    """Write the noisy image ``out``; see `add_kinect_noise`.

    Each row is first written as if it had no noise, without a branch, so that the compiler vectorises the loop; noise
    is then added where a pixel or one of its neighbours shows something other than the floor.
    """
    height, width = depth.shape

    # One row and column of nothing on every side spares the loops below the check for the image's edges.
    solid = np.zeros((height + 2, width + 2), np.bool_)
    for v in range(height):
        for u in range(width):
            g = geom[v, u]
            solid[v + 1, u + 1] = g >= 0 and not is_floor[g]

    noisy = np.zeros(width, np.bool_)
    for v in range(height):
        above = solid[v]
        row = solid[v + 1]
        below = solid[v + 2]
        for u in range(width):
            out[v, u] = _whole_mm(depth[v, u], near, far)
            noisy[u] = above[u + 1] | below[u + 1] | row[u] | row[u + 1] | row[u + 2]
        for u in range(width):
            if noisy[u]:
                out[v, u] = _whole_mm(_noisy_depth_m(depth, incidence, v, u, key, fx), near, far)


def add_kinect_noise(
    image: RenderedDepth, form: IntArray, fx: float, range_m: tuple[float, float], rng: np.random.Generator
) -> NDArray[np.uint16]:
    """Return the depth image that a Kinect v2 delivers for an exact one.

    Args:
        image: exact depth, geoms and incidence.
        form: (G,) MuJoCo's geom types.
        fx: focal length, in widths of a pixel.
        range_m: nearest and farthest depth that the sensor reports.
        rng: draws the frame's key.

    Returns:
        (H, W) depth in whole millimetres, 0 where there is none.
    """
    out = np.empty(image.depth_m.shape, dtype=np.uint16)
    key = np.uint64(rng.integers(0, 2**63))
    near, far = range_m
    _measure(image.depth_m, image.geom, image.incidence, form == PLANE, key, fx, near, far, out)
    return out
