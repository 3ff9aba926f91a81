"""Numba without scipy's linear algebra until a function needs it.

Before numba loads the first compiled function, it calls ``ensure_blas``, which imports `scipy.linalg` to find out whether matrices can be
multiplied: a fifth of the processor time of a start, for kernels that multiply none. scipy is a requirement of this package, so the
answer is known. Functions with products of matrices call ``ensure_blas`` again when they are compiled and find the original.
"""

from __future__ import annotations

import numba.np.linalg as linalg


def assume_blas() -> None:
    """Skip the first call of ``ensure_blas``, which asks only whether scipy is installed."""
    original = getattr(linalg, "ensure_blas", None)
    if original is None:  # another release of numba
        return

    def skipped() -> None:
        setattr(linalg, "ensure_blas", original)  # noqa: B010 - numba is untyped

    setattr(linalg, "ensure_blas", skipped)  # noqa: B010
