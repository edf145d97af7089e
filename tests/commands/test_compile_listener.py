"""Compiling is on_compile of as it happens, and only then."""

from numba import njit

from sjasim.commands import compile_listener


@njit
def doubled(value):
    return 2 * value


def test_every_function_that_is_compiled_is_counted():
    heard = []
    with compile_listener.on_compile(heard.append):
        doubled(1)
        assert heard == [1]
        doubled(2)
        assert heard == [1]
        doubled(0.5)
    doubled(1j)
    assert heard == [1, 2]
