"""Compiled kernels are loaded from the cache without numba's compiler."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from dcrb_ros.runtime.kernel_loading import KNOWN

pytestmark = [
    pytest.mark.skipif(numba.config.DISABLE_JIT, reason="needs the compiler"),  # type: ignore[attr-defined]
    pytest.mark.skipif(numba.__version__ not in KNOWN, reason=f"numba {numba.__version__} loads kernels in its own way"),
]

LOADED = """
import sys
import numpy as np
from dcrb_ros.measurement.kernels import filtered
from numba import njit

sections, samples = np.array([[1.0, 0.0, 0.0, 1.0, -0.5, 0.0]]), np.ones((4, 1))
direct = filtered(sections, np.zeros((1, 2, 1)), samples)
print(sum(filtered.stats.cache_hits.values()), "numba.typed.typeddict" in sys.modules)


@njit
def twice(sections, memory, samples):
    return 2.0 * filtered(sections, memory, samples)


assert (twice(sections, np.zeros((1, 2, 1)), samples) == 2.0 * direct).all()
(compiled,) = twice.overloads.values()
print(sum(function.is_declaration and "filtered" in function.name for function in compiled.library._final_module.functions))
"""
OTHER = """
import sys
import dcrb_ros.core
from numba import njit


@njit(cache=True)
def half(x):
    return 0.5 * x


print(half(3.0), sum(half.stats.cache_hits.values()), "numba.typed.typeddict" in sys.modules)
"""


FINDERS = """
import sys


class Asked:
    names = []

    def find_spec(self, name, path=None, target=None):
        self.names.append(name)


import dcrb_ros

sys.meta_path.insert(1, Asked())
import dcrb_ros.core

print("dcrb_ros.core" in Asked.names)
"""


def output_of(program: Path, cache: Path) -> str:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    return subprocess.run([sys.executable, str(program)], env=environment, capture_output=True, text=True, timeout=600.0, check=True).stdout


@pytest.mark.slow
def test_a_loaded_kernel_starts_no_compiler_and_can_still_be_inlined(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(LOADED)

    first, second = (output_of(tmp_path / "program.py", tmp_path / "cache").split() for _ in range(2))

    assert first[0] == "0"
    assert second == ["1", "False", "0"]


def test_functions_of_other_packages_are_loaded_by_numba_itself(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(OTHER)

    assert [output_of(tmp_path / "program.py", tmp_path / "cache").split() for _ in range(2)] == [
        ["1.5", "0", "True"],
        ["1.5", "1", "True"],
    ]


def test_the_finders_behind_ours_are_asked_for_the_kernels(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(FINDERS)

    assert output_of(tmp_path / "program.py", tmp_path / "cache").split() == ["True"]
