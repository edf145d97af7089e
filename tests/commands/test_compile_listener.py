"""Functions are reported as they are compiled, and only then."""

from numba import njit

from sjasim.commands import compile_listener


@njit
def doubled(value):
    return 2 * value


def test_every_function_that_is_compiled_is_counted():
    counts = []
    with compile_listener.on_compile(counts.append):
        doubled(1)
        assert counts == [1]
        doubled(2)
        assert counts == [1]
        doubled(0.5)
    doubled(1j)
    assert counts == [1, 2]
