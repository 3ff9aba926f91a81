"""How the kernels are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit

from dcrb_ros.core.kernel_cache import CheckedCacheFile

Function = TypeVar("Function", bound=Callable[..., Any])

NO: Any = np.bool_(False)
YES: Any = np.bool_(True)
ZERO: Any = np.int64(0)
"""Arguments of kernels. For a literal, numba compiles the kernel and all that it calls once more than for a variable."""

COMPILED: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "fastmath": {"contract", "arcp", "nsz"}}
"""Without numba's runtime nothing can be allocated, and no array is counted in and out of a call: a factor of six here.

``contract`` joins a product and a sum where the processor has fused multiply-add, which rounds once instead of twice. Where it could join
either of two products, or one behind a condition, its choice may depend on the processor's vectors. Kernels avoid such expressions
(`docs/explanation/numerics.md`), so only processors without fused multiply-add give other samples. A recording names its processor.
"""
INLINED: dict[str, Any] = {**COMPILED, "forceinline": True}
OPTIONS: dict[str, Any] = {**COMPILED, "cache": True}
# Numba takes these two, but does not list them among its keywords.
WITHOUT_ENTRY: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of functions that only kernels call: no entry from Python, which takes long to compile for many arguments."""


def kernel(function: Function) -> Function:
    """Compile a kernel that is inlined into its callers: its named tuples never cross a call."""
    return cast(Function, _cached(njit(**OPTIONS, forceinline=True)(function)))


def piece(function: Function) -> Function:
    """Compile a kernel that only other kernels call."""
    return cast(Function, _cached(njit(**OPTIONS, **WITHOUT_ENTRY, forceinline=True)(function)))


def loop(function: Function) -> Function:
    """Compile an entry point that Python calls; it releases the GIL."""
    return cast(Function, _cached(njit(**OPTIONS, nogil=True)(function)))


def _cached(dispatcher: Any) -> Any:
    """Return a dispatcher whose cache has checksums, and names its folder if it cannot be written, as on a full disk."""
    cache = getattr(dispatcher, "_cache", None)  # missing without the compiler
    if cache is not None:
        cache._cache_file.__class__ = CheckedCacheFile
        save = cache.save_overload

        def save_overload(signature: Any, data: Any) -> None:
            try:
                save(signature, data)
            except FileNotFoundError:  # the folder was removed meanwhile: the kernel is compiled, and is not kept
                return
            except OSError as error:
                raise OSError(error.errno, error.strerror, cache.cache_path) from None

        cache.save_overload = save_overload
    return dispatcher
