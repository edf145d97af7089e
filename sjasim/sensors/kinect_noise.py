"""What a Kinect v2 makes of exact depth: noise, mixed pixels, holes, limits, whole millimetres.

Source: fankhauser2015, section IV (axial noise in depth and angle, lateral noise of 1.6 mm). Edges, grazing
surfaces and the distance error's wiggle are reported in words elsewhere; their sizes here are assumed.

Randomness is a hash of frame and pixel: no state, no tables, the same in every process. Floor that has only floor
around it is handed on without noise: nothing uses it, because it is cut away some five standard deviations above.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..core import IntArray
from .depth_camera import RenderedDepth
from .raycast.primitives import PLANE

LATERAL_M = 0.0016
"""Standard deviation of where on the surface a pixel looks. Source: fankhauser2015."""
EDGE_M = (0.06, 2.5)
"""Steps in depth between neighbours at which pixels mix; farther ones are separable in phase (assumed)."""
EDGE_DROPOUT, EDGE_MIXING = 0.30, 0.25
"""Share of pixels at such a step without depth, and with a depth between both surfaces (assumed)."""
GRAZING_RAD, GRAZING_DROPOUT = math.radians(85.0), 0.7
"""Beyond this angle of incidence so many pixels have no depth (assumed)."""
WIGGLE_M, WIGGLE_PERIOD_M = 0.003, 1.87
"""Amplitude and period of the systematic distance error of continuous-wave time of flight (assumed)."""
MAX_AXIAL_M = 0.04
"""Bound of the axial standard deviation: beyond it a sensor gives no depth at all (assumed)."""
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_LOW = np.uint64(0xFFFF)


@njit(cache=True, inline="always")
def _bits(key: np.uint64, count: int) -> np.uint64:
    """64 random bits, a hash of both arguments (splitmix64's finaliser)."""
    x = key + np.uint64(count + 1) * _GOLDEN
    x = (x ^ (x >> np.uint64(30))) * _FIRST
    x = (x ^ (x >> np.uint64(27))) * _SECOND
    return x ^ (x >> np.uint64(31))


@njit(cache=True, inline="always")
def _part(bits: np.uint64, which: int) -> float:
    """One of four uniform numbers from 0 to 1 in 64 bits."""
    return float((bits >> np.uint64(16 * which)) & _LOW) / 65536.0


@njit(cache=True, inline="always")
def _normal(bits: np.uint64) -> float:
    """A nearly normal number of variance 1: four uniform ones added; its tails end at 3.5."""
    total = _part(bits, 0) + _part(bits, 1) + _part(bits, 2) + _part(bits, 3)
    return float((total - 2.0) * 1.7320508075688772)


@njit(cache=True, inline="always")
def axial_noise_m(depth_m: float, slant: float) -> float:
    """Standard deviation of depth [m], for an angle of incidence theta with (theta / (pi/2 - theta))^2 = ``slant``.

    Source: fankhauser2015, eq. (6), without its term for sunlight; at most `MOST_AXIAL_M`.
    """
    aside = 0.1 * depth_m * math.sqrt(depth_m) * slant
    return min(0.001 * (1.5 - 0.5 * depth_m + 0.3 * depth_m * depth_m + aside), MAX_AXIAL_M)


def _slants() -> NDArray[np.float32]:
    """``slant`` of `axial_m` by the cosine of incidence, in steps of 1 / `_STEPS`; grazing beyond `GRAZING_RAD`."""
    angle = np.minimum(np.arccos(np.arange(_STEPS + 1) / _STEPS), GRAZING_RAD)
    return np.asarray((angle / (math.pi / 2 - angle)) ** 2, dtype=np.float32)


_STEPS = 2048
_SLANTS = _slants()
_GRAZING = math.cos(GRAZING_RAD)
_WIGGLES_M = (WIGGLE_M * np.sin(2.0 * np.pi * np.arange(0.0, 12.0, 0.01) / WIGGLE_PERIOD_M)).astype(np.float32)
"""The distance error by centimetres; logarithms, roots and sines would cost more than all else together."""


@njit(cache=True, inline="always")
def _edge(depth: NDArray[np.float64], v: int, u: int) -> float:
    """Depth of the neighbour beyond the largest step in depth that can mix, 0 without one."""
    height, width = depth.shape
    own, other, most = depth[v, u], 0.0, EDGE_M[0]
    for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        near = depth[min(max(v + dv, 0), height - 1), min(max(u + du, 0), width - 1)]
        step = abs(near - own)
        if most < step < EDGE_M[1]:
            other, most = near, step
    return other


@njit(cache=True, inline="always")
def _aside(
    depth: NDArray[np.float64], v: int, u: int, key: np.uint64, fx: float, luck: float
) -> tuple[int, int, float]:
    """The pixel whose surface one looks at, and the exact depth where one does [m].

    Between pixels a surface is flat; an edge between them lies anywhere, so that a look that goes a quarter of the way
    has passed it in one case of four.
    """
    height, width = depth.shape
    reach = LATERAL_M * fx / depth[v, u] * 2.4494897427831781  # two uniform numbers have a variance of 1/6
    bits = _bits(key, 3 * (v * width + u) + 2)
    down, right = reach * (_part(bits, 0) + _part(bits, 1) - 1.0), reach * (_part(bits, 2) + _part(bits, 3) - 1.0)
    row, column = min(max(v + round(down), 0), height - 1), min(max(u + round(right), 0), width - 1)
    own = seen = depth[row, column]
    for part, dv, du in ((down - round(down), 1, 0), (right - round(right), 0, 1)):
        side = 1 if part > 0.0 else -1
        near = depth[min(max(row + side * dv, 0), height - 1), min(max(column + side * du, 0), width - 1)]
        if abs(near - own) < EDGE_M[0]:
            seen += abs(part) * (near - own)
        elif luck < abs(part):
            seen = near
            break
    return row, column, seen


@njit(cache=True, error_model="numpy", inline="always")
def _spoil(depth: NDArray[np.float64], facing: NDArray[np.float32], v: int, u: int, key: np.uint64, fx: float) -> float:
    """Depth that the sensor reports for one pixel, 0 for none [m]."""
    own = depth[v, u]
    if own == np.inf:
        return 0.0
    chance = _bits(key, 3 * (v * depth.shape[1] + u))
    other, luck = _edge(depth, v, u), _part(chance, 0)
    if other > 0.0 and luck < EDGE_DROPOUT:
        return 0.0
    row, column, seen = _aside(depth, v, u, key, fx, _part(chance, 3))
    cosine = min(facing[row, column], np.float32(1.0))
    if seen == np.inf or (cosine < _GRAZING and _part(chance, 2) < GRAZING_DROPOUT):
        return 0.0
    if other > 0.0 and luck < EDGE_DROPOUT + EDGE_MIXING:
        share = _part(chance, 1)
        seen = share * own + (1.0 - share) * other
    place = cosine * np.float32(_STEPS)
    step = min(int(place), _STEPS - 1)
    slant = _SLANTS[step] + (place - step) * (_SLANTS[step + 1] - _SLANTS[step])
    wiggle = _WIGGLES_M[min(int(100.0 * seen + 0.5), len(_WIGGLES_M) - 1)]
    return float(seen + wiggle + axial_noise_m(seen, slant) * _normal(_bits(key, 3 * (v * depth.shape[1] + u) + 1)))


@njit(cache=True)
def _solid(geom: NDArray[np.int16], flat: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(H + 2, W + 2) whether pixels show something that is no floor, with a frame of nothing around them."""
    height, width = geom.shape
    out = np.zeros((height + 2, width + 2), np.bool_)
    for v in range(height):
        for u in range(width):
            g = geom[v, u]
            out[v + 1, u + 1] = g >= 0 and not flat[g]
    return out


@njit(cache=True, inline="always")
def _whole_mm(seen: float, near: float, far: float) -> np.uint16:
    """A depth in whole millimetres, 0 out of range."""
    return np.uint16(np.int32((seen if (near <= seen) & (seen <= far) else 0.0) * 1000.0 + 0.5))


@njit(cache=True, error_model="numpy")
def _sense(
    depth: NDArray[np.float64], geom: NDArray[np.int16], facing: NDArray[np.float32], flat: NDArray[np.bool_],
    key: np.uint64, fx: float, near: float, far: float, out: NDArray[np.uint16],
) -> None:  # fmt: skip
    """Row by row, at first without a branch as if nothing were to be spoiled, so that many pixels are done at once."""
    solid, spoiled = _solid(geom, flat), np.empty(depth.shape[1], np.bool_)
    for v in range(depth.shape[0]):
        above, row, below = solid[v], solid[v + 1], solid[v + 2]
        for u in range(depth.shape[1]):
            out[v, u] = _whole_mm(depth[v, u], near, far)
            spoiled[u] = above[u + 1] | below[u + 1] | row[u] | row[u + 1] | row[u + 2]
        for u in range(depth.shape[1]):
            if spoiled[u]:
                out[v, u] = _whole_mm(_spoil(depth, facing, v, u, key, fx), near, far)


def add_kinect_noise(
    picture: RenderedDepth, form: IntArray, fx: float, range_m: tuple[float, float], rng: np.random.Generator
) -> NDArray[np.uint16]:
    """The depth image that a sensor delivers.

    Args:
        picture: exact depth, geoms and incidence.
        form: (G,) codes of the geoms.
        fx: focal length over the width of a pixel.
        range_m: nearest and farthest depth that the sensor gives.
        rng: gives the frame's key.

    Returns:
        (H, W) depth in whole millimetres, 0 where there is none.
    """
    out = np.empty(picture.depth_m.shape, dtype=np.uint16)
    key = np.uint64(rng.integers(0, 2**63))
    near, far = range_m
    _sense(picture.depth_m, picture.geom, picture.incidence, form == PLANE, key, fx, near, far, out)
    return out
