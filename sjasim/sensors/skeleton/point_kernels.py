"""Compiled operations on points and on rows of arrays.

They replace expressions that Numba compiles slowly. Its slice assignment ``target[:] = values`` compiles some forty
functions, for the message about lengths that differ: eight seconds at first use.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from ...core import Array
from ...core.compiled import compiled_inner


@compiled_inner
def copy_into(target: NDArray[Any], values: NDArray[Any]) -> None:
    """Set ``target[:] = values`` for two arrays (N,) of equal length."""
    for k in range(len(target)):
        target[k] = values[k]


@compiled_inner
def closer_than(point: Array, other: Array, limit_m: float) -> bool:
    """Return whether two points (3,) are closer than a limit; False where one of them is NaN."""
    x = point[0] - other[0]
    y = point[1] - other[1]
    z = point[2] - other[2]
    return bool(x * x + y * y + z * z < limit_m * limit_m)
