"""numba's question whether matrices can be multiplied."""

from __future__ import annotations

import subprocess
import sys

CALLS = """
import sys
import numba
import numpy as np
import dcrb_ros.core

@numba.njit
def doubled(x):
    return 2.0 * x

@numba.njit
def squared(a):
    return a @ a

print(doubled(2.0), "scipy.linalg" in sys.modules)
print(squared(2.0 * np.eye(2))[0, 0], "scipy.linalg" in sys.modules)
"""


def test_scipy_linalg_is_imported_for_products_of_matrices_alone() -> None:
    done = subprocess.run([sys.executable, "-c", CALLS], capture_output=True, text=True, check=True)

    assert done.stdout.split() == ["4.0", "False", "4.0", "True"]
