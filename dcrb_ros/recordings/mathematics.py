"""The mathematical functions of the C library and of numpy: their last bits differ between processors, and with them the samples.

Both libraries have several variants of a function and choose one when the program starts: with fused multiply-add, with wide vectors, or
without. The compiled kernels call ``sin``, ``cos``, ``sincos``, ``asin`` and ``atan2`` of the C library. Their constants, the sensor chain
and the random numbers are computed with ``exp``, ``log``, ``log10``, ``log1p``, ``pow`` and ``tan``, too. numpy calls the C library for
sine and cosine, and has variants of its own for the functions in `_of_numpy`.
"""

from __future__ import annotations

import functools
import hashlib
import math
import platform
import struct

import numpy as np

FUNCTIONS = ("libm", "numpy_functions")
"""Entries of `function_results`; recordings of older versions lack them."""
ARGUMENTS = np.linspace(0.01, 20.0, 2000)
"""Arguments; at one of some fifty the variants of a function differ."""


@functools.cache
def function_results() -> dict[str, str]:
    """Return name and version of the C library with a short hash of the results of its functions, and a hash of numpy's."""
    library = " ".join(platform.libc_ver()).strip() or platform.system()
    return {"libm": f"{library} (results {_of_libm()})", "numpy_functions": f"(results {_of_numpy()})"}


def _of_libm() -> str:
    results = [
        value
        for x in ARGUMENTS.tolist()
        for value in (
            math.sin(x),
            math.cos(x),
            math.tan(x),
            math.asin(x / 20.5),
            math.atan2(x, 1.3),
            math.exp(-x),
            math.log(x),
            math.log10(x),
            math.log1p(x),
            math.pow(x, 10.0 / 9.0),
        )
    ]
    return _short(struct.pack(f"<{len(results)}d", *results))


def _of_numpy() -> str:
    x = ARGUMENTS
    results = np.stack([np.exp(-x), np.log(x), np.log10(x), np.arctan2(x, 1.3), np.power(x, 10.0 / 9.0)])
    return _short(results.astype("<f8").tobytes())


def _short(results: bytes) -> str:
    return hashlib.sha256(results).hexdigest()[:8]
