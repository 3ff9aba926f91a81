"""The results of the mathematical functions, on which the last bits of the samples depend, have a name."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from dcrb_ros.recordings.mathematics import FUNCTIONS, function_results

SCALAR = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"}
"""Let the C library choose the variants without fused multiply-add."""
COMMAND = "from dcrb_ros.recordings.mathematics import function_results; print(function_results())"


def in_a_new_process(environment: dict[str, str]) -> str:
    return subprocess.run(
        [sys.executable, "-c", COMMAND], capture_output=True, text=True, check=True, env={**os.environ, **environment}, timeout=400.0
    ).stdout.strip()


def has_variants() -> bool:
    information = Path("/proc/cpuinfo")
    return platform.libc_ver()[0] == "glibc" and information.exists() and " fma " in information.read_text()


def test_equal_functions_have_equal_names() -> None:
    assert tuple(function_results()) == FUNCTIONS
    assert in_a_new_process({}) == str(function_results())


@pytest.mark.skipif(not has_variants(), reason="the C library has no variants for this processor")
def test_another_variant_of_the_c_library_has_another_name() -> None:
    other = in_a_new_process(SCALAR)
    assert function_results()["libm"] not in other
    # Without AVX-512, numpy has no functions of its own and calls those of the C library.
    own = any("AVX512" in name or name == "X86_V4" for name in np.show_config(mode="dicts")["SIMD Extensions"]["found"])
    assert (function_results()["numpy_functions"] in other) == own
