"""Arrays in a list that compiled functions look them up in."""

import numpy as np
import pytest
from numba import njit

from sjasim.core.memory import Memory, cube, index_rows, indices, matrix, vector


@njit
def sums(at, out):
    out[0], out[1], out[2] = vector(at, 0).sum(), matrix(at, 1)[1, 2], cube(at, 2)[0, 1, 1]
    out[3], out[4] = indices(at, 3)[1], index_rows(at, 4)[1, 0]
    vector(at, 0)[0] = -1.0


def test_a_compiled_function_finds_the_arrays_themselves():
    line, table = np.arange(4.0), np.arange(6.0).reshape(2, 3)
    memory = Memory(line, table, np.arange(8.0).reshape(2, 2, 2), np.array([5, 7]), np.array([[1, 2], [3, 4]]))
    out = np.zeros(5)
    sums(memory.table, out)
    assert out.tolist() == [6.0, 5.0, 3.0, 7.0, 3.0]
    assert line[0] == -1.0


@pytest.mark.parametrize(
    "array", [np.zeros((2, 4))[:, ::2], np.zeros(3, dtype=np.float32), np.zeros(3, dtype=np.int32), np.zeros((1,) * 4)]
)
def test_an_array_of_another_kind_is_refused(array):
    with pytest.raises(ValueError, match="contiguous 64-bit"):
        Memory(array)
