"""What a start imports."""

from __future__ import annotations

import subprocess
import sys

import numba
import pytest

from dcrb_ros.runtime.kernel_loading import KNOWN

FIRST_BLOCK = """
import sys
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

block = next(Simulation(load_configuration({bench!r})).blocks())
unused = "linalg", "optimize", "signal", "special", "fft", "ndimage"
unused = *("scipy." + name for name in unused), "pandas", "matplotlib", "rosbags", "typer", "rich", "coverage", "numba.typed.typeddict"
print(block.acceleration.tobytes().hex()[:4096], *(name for name in unused if name in sys.modules))
"""


@pytest.mark.slow
@pytest.mark.parametrize("bench", ["healthy", "outer_ring_defect"])
def test_a_second_start_imports_neither_scipy_nor_the_compiler_and_yields_the_same_samples(bench: str) -> None:
    starts = [
        subprocess.run([sys.executable, "-c", FIRST_BLOCK.format(bench=bench)], capture_output=True, text=True, check=True).stdout.split()
        for _ in range(2)
    ]

    of_compiler = {"numba.typed.typeddict"} if numba.__version__ not in KNOWN else set()
    assert set(starts[1][1:]) <= of_compiler
    assert starts[1][0] == starts[0][0]
