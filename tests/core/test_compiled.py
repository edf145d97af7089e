"""Decorators of compiled functions."""

from __future__ import annotations

import math

from sjasim.core.compiled import compiled_entry, compiled_inner


@compiled_inner
def _reciprocal(x: float) -> float:
    return 1.0 / x


@compiled_entry
def _sum_of_reciprocals(x: float, y: float) -> float:
    return _reciprocal(x) + _reciprocal(y)


def test_a_compiled_function_calls_inner_functions_with_numpys_error_model():
    assert _sum_of_reciprocals(2.0, 4.0) == 0.75
    assert _sum_of_reciprocals(0.0, 4.0) == math.inf


def test_an_inner_function_is_a_plain_function_in_python():
    assert _reciprocal(4.0) == 0.25
    assert not hasattr(_reciprocal, "py_func")
