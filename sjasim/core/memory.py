"""Copy of one array into another inside compiled functions."""

from __future__ import annotations

from typing import Any

from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def put(into: NDArray[Any], values: NDArray[Any]) -> None:
    """Copy: ``into[:] = values`` for two arrays (N,) of one length.

    Numba's own slice assignment compiles forty functions for the message of lengths that differ.
    """
    for k in range(len(into)):
        into[k] = values[k]
