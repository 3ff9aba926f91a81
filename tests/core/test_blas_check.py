"""numba's question whether matrices can be multiplied."""

from __future__ import annotations

import subprocess
import sys

CALLS = """
import sys
import numba.np.linalg
import dcrb_ros.core

@numba.njit
def doubled(x):
    return 2.0 * x

print(doubled(2.0), "scipy.linalg" in sys.modules)
numba.np.linalg.ensure_blas()  # as a function with a product of matrices does when it is compiled
print("scipy.linalg" in sys.modules)
"""


def test_scipy_linalg_is_imported_for_products_of_matrices_alone() -> None:
    done = subprocess.run([sys.executable, "-c", CALLS], capture_output=True, text=True, check=True)

    assert done.stdout.split() == ["4.0", "False", "True"]
