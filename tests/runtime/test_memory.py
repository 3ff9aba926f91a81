"""Freed memory is kept, so that arrays that come and go cost no page faults."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

PROGRAM = """
import resource, sys
import numpy as np
from dcrb_ros.runtime.memory import keep_freed_memory
if "keep" in sys.argv:
    keep_freed_memory()
def use():
    large = [np.ones(1 << 20, np.float32) for _ in range(3)]
use()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(20):
    use()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(*arguments: str) -> int:
    done = subprocess.run([sys.executable, "-c", PROGRAM, *arguments], capture_output=True, text=True, check=True, timeout=400)
    return int(done.stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc has mallopt")
def test_arrays_that_come_and_go_use_the_same_pages() -> None:
    """Twelve megabytes have 3072 pages of 4 KB, or 6 of 2 MB."""
    kept, returned = faults("keep"), faults()
    assert kept < 0.1 * returned


def test_objects_that_stay_are_searched_rarely() -> None:
    code = "import gc, sys\nfrom dcrb_ros.runtime.memory import collect_rarely\nif 'rarely' in sys.argv:\n    collect_rarely()\n"
    code += (
        "before = gc.get_stats()[0]['collections']\nkept = [[] for _ in range(200_000)]\nprint(gc.get_stats()[0]['collections'] - before)"
    )

    def searches(*arguments: str) -> int:
        done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True, timeout=400)
        return int(done.stdout)

    assert searches("rarely") < 0.1 * searches()
