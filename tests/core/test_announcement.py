"""The announcement of a compilation."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from dcrb_ros.core.announcement import OF_LAWS, SENTENCE, WORKERS, announce_compilation, announce_laws

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")


def test_a_compilation_is_announced_once_when_it_happens() -> None:
    said: list[str] = []
    double = numba.njit(lambda number: 2 * number)
    announce_compilation(said.append)
    assert said == []
    assert double(2) == 4
    assert said == [SENTENCE]
    assert double(2.0) == 4.0  # compiled for another type
    assert said == [SENTENCE]


def test_other_types_are_announced_although_the_kernel_has_been_compiled() -> None:
    said: list[str] = []
    double = numba.njit(lambda number: 2 * number)
    double(2)
    announce_compilation(said.append)
    double(3)
    assert said == []
    double(2.0)
    assert said == [SENTENCE]


def test_the_latest_listener_is_told() -> None:
    said: list[str] = []
    announce_compilation(lambda sentence: said.append("earlier"))
    announce_compilation(said.append)
    numba.njit(lambda number: number + 1)(1)
    assert said == [SENTENCE]


def test_each_set_of_kernels_is_announced_with_its_laws() -> None:
    said: list[str] = []
    announce_compilation(said.append)
    for laws in ("johnson, lugre", "johnson, lugre", "power, film"):
        announce_laws(laws)
        numba.njit(lambda number: number + 1)(1)
    assert said == [OF_LAWS.format(laws=laws) for laws in ("johnson, lugre", "power, film")]


@pytest.mark.slow
def test_the_first_worker_announces_what_it_compiles(tmp_path: Path) -> None:
    code = "import numba, sys\nfrom dcrb_ros.core.announcement import announce_laws\n"
    code += "for laws in sys.argv[1:]:\n    announce_laws(laws)\n    numba.njit(lambda number: number + 1)(1)"

    def worker(laws: str, **environment: str) -> str:
        inherited = {name: value for name, value in os.environ.items() if name != WORKERS}
        command = [sys.executable, "-c", code, laws]
        environment = {**inherited, "NUMBA_CACHE_DIR": str(tmp_path), **environment}
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=400.0, check=True).stderr

    assert worker("film") == ""
    assert worker("film", **{WORKERS: "1"}) == f"{OF_LAWS.format(laws='film')}\n"
    assert worker("film", **{WORKERS: "1"}) == ""
    assert worker("dry", **{WORKERS: "1"}) == f"{OF_LAWS.format(laws='dry')}\n"
