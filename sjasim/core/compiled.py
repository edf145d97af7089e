"""Decorators of functions that Numba compiles to machine code.

Compilation delays the first run of a program, mainly in proportion to the number of functions that Python can call.
Decorate functions that are called from Python with `compiled_entry`, and the functions that they call with
`compiled_inner`.

Both decorators select NumPy's error model: a division by zero gives infinity or NaN instead of `ZeroDivisionError`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit
from numba.extending import register_jitable

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled_entry(function: Function) -> Function:
    """Compile a function that is called from Python, and keep its machine code in Numba's cache.

    Numba compiles the function once for each combination of argument types. To avoid repeated compilation, pass arrays
    of a single memory layout, and do not pass literals from compiled code.
    """
    return cast(Function, njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)(function))


def compiled_inner(function: Function) -> Function:
    """Compile a function only as part of the compiled functions that call it.

    Called from Python, the function is interpreted: it returns the same result, but slowly.
    """
    return cast(Function, register_jitable(error_model="numpy", no_cfunc_wrapper=True)(function))
