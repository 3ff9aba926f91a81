"""The cache of filter designs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from attacked_files import ATTACKS

from dcrb_ros.measurement import filter_cache
from dcrb_ros.schema.arrays import Floats


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[float]:
    monkeypatch.setattr(filter_cache, "folder", lambda: tmp_path / "filters")
    return []


def design(made: list[float]) -> Callable[..., Floats]:
    @filter_cache.cached_on_disk
    def thirds(factor: float, bank: tuple[Floats, ...] = ()) -> Floats:
        made.append(factor)
        return np.array([[factor / 3.0, *(float(part[0]) for part in bank)]])

    return thirds


def test_a_cached_design_has_the_same_bits(made: list[float]) -> None:
    thirds = design(made)
    first, second = thirds(0.1), thirds(0.1)
    assert made == [0.1]
    assert first.tobytes() == second.tobytes()
    assert first.shape == second.shape
    second[0, 0] = 7.0  # a change by one caller does not affect another
    assert thirds(0.1)[0, 0] == first[0, 0]


def test_designs_differ_in_the_last_bit_of_an_argument(made: list[float]) -> None:
    thirds = design(made)
    for factor in (0.1, np.nextafter(0.1, 1.0)):
        for last in (1.0, np.nextafter(1.0, 2.0)):
            bank = (np.append(np.zeros(5000), last)[::-1],)
            assert thirds(factor, bank).tolist() == [[factor / 3.0, last]]
    assert len(made) == 4


def test_another_version_is_designed_again(made: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    thirds = design(made)
    thirds(0.1)
    monkeypatch.setattr(filter_cache, "_versions", lambda sources: b"another")
    thirds(0.1)
    assert len(made) == 2


def test_the_file_of_another_design_is_not_taken(made: list[float], tmp_path: Path) -> None:
    thirds = design(made)
    expected = [thirds(0.1)[0, 0], thirds(0.2)[0, 0]]
    one, other = (tmp_path / "filters").iterdir()
    contents = one.read_bytes(), other.read_bytes()
    one.write_bytes(contents[1])
    other.write_bytes(contents[0])
    assert [thirds(0.1)[0, 0], thirds(0.2)[0, 0]] == expected
    assert made == [0.1, 0.2, 0.1, 0.2]


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.timeout(60)  # a pipe would be waited for
def test_a_damaged_file_is_designed_again(made: list[float], attack: str) -> None:
    thirds = design(made)
    whole = thirds(0.1)
    (path,) = filter_cache.folder().iterdir()
    ATTACKS[attack](path)
    assert thirds(0.1).tobytes() == whole.tobytes()
    assert len(made) == 2
    thirds(0.1)
    assert len(made) == 2


def test_a_read_only_cache_is_ignored(made: list[float]) -> None:
    filter_cache.folder().parent.joinpath("filters").write_text("a file where the folder should be")
    thirds = design(made)
    assert thirds(0.3).tolist() == thirds(0.3).tolist()
    assert made == [0.3, 0.3]
    assert [path.name for path in filter_cache.folder().parent.iterdir()] == ["filters"]


def test_only_the_first_results_of_a_process_are_cached(made: list[float]) -> None:
    @filter_cache.cached_at_start(2)
    def thirds(factor: float) -> Floats:
        made.append(factor)
        return np.array([factor / 3.0])

    for factor in (0.1, 0.2, 0.3):
        assert thirds(factor).tolist() == [factor / 3.0]

    assert made == [0.1, 0.2, 0.3]
    assert len(list(filter_cache.folder().iterdir())) == 2


@pytest.mark.parametrize(("limit", "value"), [("MOST_RESULTS", 2), ("MOST_BYTES", 400)])  # a file has 176 bytes
def test_the_oldest_results_are_removed(limit: str, value: int, made: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(filter_cache, limit, value)
    thirds = design(made)
    for factor in (0.1, 0.2, 0.3):
        thirds(factor)

    assert len(list(filter_cache.folder().iterdir())) == 2
