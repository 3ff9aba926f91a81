"""The announcement of a compilation."""

from __future__ import annotations

import numba
import pytest

from dcrb_ros.core.announcement import SENTENCE, announce_compilation

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
