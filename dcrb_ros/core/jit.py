"""How the kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Compile a kernel that is inlined into its callers: its named tuples never cross a call."""
    return cast(Function, njit(cache=True, error_model="numpy", forceinline=True)(function))


def loop(function: Function) -> Function:
    """Compile an entry point that Python calls; it lets go of the interpreter's lock."""
    return cast(Function, njit(cache=True, error_model="numpy", nogil=True)(function))
