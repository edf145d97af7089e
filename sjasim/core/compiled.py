"""The two decorators of functions that numba compiles to machine code.

Compiling takes a noticeable time when a program runs for the first time, and most of it depends on the number of
functions that can be called from Python. Decorate these few with `compiled_entry` and everything that they call with
`compiled_inner`.

Both use numpy's error model: a division by zero gives infinity or NaN instead of a `ZeroDivisionError`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit
from numba.extending import register_jitable

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled_entry(function: Function) -> Function:
    """Compile a function that Python calls, and keep its machine code in numba's cache.

    Each combination of argument types is compiled anew. Pass arrays of one layout, and no literals if the caller is
    compiled too.
    """
    return cast(Function, njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)(function))


def compiled_inner(function: Function) -> Function:
    """Compile a function as a part of the compiled functions that call it.

    Python sees a plain function: a call from Python is interpreted and therefore slow, though its result is the same.
    """
    return cast(Function, register_jitable(error_model="numpy", no_cfunc_wrapper=True)(function))
