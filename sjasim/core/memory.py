"""Arrays that stay where they are, handed to a compiled function as one argument.

Handing over an array takes a fraction of a microsecond, three times that while the caches are cold; a turn of the
dancers needs twenty of them, 50 times a second, which is more than all that it computes. So whoever takes turns lists
its arrays once, and the compiled function looks them up in the list by their place in it: `vector`, `matrix`, `cube`,
`indices` and `index_rows`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import carray, njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from . import Array, IntArray

_DIMENSIONS = 3


class Memory:
    """A list of arrays, kept alive and never moved.

    Args:
        arrays: each contiguous, of 64-bit floats or integers, and of at most three dimensions.

    Attributes:
        table: (N, 4) address and shape of each, which the compiled function takes.

    Raises:
        ValueError: an array is something else.
    """

    __slots__ = ("_arrays", "table")

    def __init__(self, *arrays: Array | IntArray) -> None:
        self._arrays = arrays
        self.table: IntArray = np.zeros((len(arrays), 1 + _DIMENSIONS), dtype=np.int64)
        for row, array in zip(self.table, arrays, strict=True):
            if array.dtype not in (np.float64, np.int64) or array.ndim > _DIMENSIONS or not array.flags.c_contiguous:
                got = f"{array.dtype} {array.shape}"
                raise ValueError(f"array: got {got}, allowed are contiguous 64-bit ones of up to three dimensions")
            row[0] = array.ctypes.data
            row[1 : 1 + array.ndim] = array.shape


def _pointer_to(kind: types.Type) -> Any:
    """A compiled function that takes an address for a pointer to numbers of a kind."""

    @intrinsic
    def pointer(typing: Any, address: Any) -> Any:
        signature = types.CPointer(kind)(types.int64)

        def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

        return signature, generate

    return pointer


_reals, _integers = _pointer_to(types.float64), _pointer_to(types.int64)


@njit(cache=True)
def vector(table: IntArray, k: int) -> Array:
    """The k-th array of a `Memory`: (A,) floats."""
    out: Array = carray(_reals(table[k, 0]), table[k, 1])
    return out


@njit(cache=True)
def matrix(table: IntArray, k: int) -> Array:
    """The k-th array of a `Memory`: (A, B) floats."""
    out: Array = carray(_reals(table[k, 0]), (table[k, 1], table[k, 2]))
    return out


@njit(cache=True)
def cube(table: IntArray, k: int) -> Array:
    """The k-th array of a `Memory`: (A, B, C) floats."""
    out: Array = carray(_reals(table[k, 0]), (table[k, 1], table[k, 2], table[k, 3]))
    return out


@njit(cache=True)
def indices(table: IntArray, k: int) -> IntArray:
    """The k-th array of a `Memory`: (A,) integers."""
    out: IntArray = carray(_integers(table[k, 0]), table[k, 1])
    return out


@njit(cache=True)
def index_rows(table: IntArray, k: int) -> IntArray:
    """The k-th array of a `Memory`: (A, B) integers."""
    out: IntArray = carray(_integers(table[k, 0]), (table[k, 1], table[k, 2]))
    return out


@njit(cache=True)
def put(into: NDArray[Any], values: NDArray[Any]) -> None:
    """``into[:] = values`` for two arrays (N,) of one length.

    Numba's own assignment compiles forty functions for the message of lengths that differ: eight seconds at first use.
    """
    for k in range(len(into)):
        into[k] = values[k]
