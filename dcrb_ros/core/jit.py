"""How the kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])

COMPILED: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "fastmath": {"contract", "arcp", "nsz"}}
"""Without numba's runtime nothing can be allocated, and no array is counted in and out of a call: a factor of six here."""
INLINED: dict[str, Any] = {**COMPILED, "forceinline": True}
OPTIONS: dict[str, Any] = {**COMPILED, "cache": True}


def kernel(function: Function) -> Function:
    """Compile a kernel that is inlined into its callers: its named tuples never cross a call."""
    return cast(Function, njit(**OPTIONS, forceinline=True)(function))


def piece(function: Function) -> Function:
    """Compile a kernel that only other kernels call: the way in from Python, most of the work for so many arguments, is left out."""
    # Numba takes these two, but does not list them among its keywords.
    without: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return cast(Function, njit(**OPTIONS, **without, forceinline=True)(function))


def loop(function: Function) -> Function:
    """Compile an entry point that Python calls; it lets go of the interpreter's lock."""
    return cast(Function, njit(**OPTIONS, nogil=True)(function))
