"""Items produced before they are used."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from dcrb_ros.runtime.prefetch import prefetch


def test_all_items_come_in_order() -> None:
    assert list(prefetch(iter(range(100)))) == list(range(100))
    assert list(prefetch(iter([]))) == []


def test_the_next_item_is_produced_by_a_thread_while_the_last_one_is_used() -> None:
    made: list[str] = []
    ready = threading.Event()

    def items() -> Iterator[int]:
        for number in range(3):
            made.append(threading.current_thread().name)
            if number == 1:
                ready.set()
            yield number

    source = prefetch(items())
    assert next(source) == 0
    assert ready.wait(200.0)
    assert list(source) == [1, 2]
    assert made[0] == threading.current_thread().name
    assert made[1] != made[0]


def test_a_failure_is_raised_in_place_of_its_item() -> None:
    def items() -> Iterator[int]:
        yield 0
        raise OSError("no room")

    source = prefetch(items())
    assert next(source) == 0
    with pytest.raises(OSError, match="no room"):
        next(source)


def test_only_wanted_items_are_prefetched() -> None:
    made: list[int] = []

    def items() -> Iterator[int]:
        for number in range(6):
            made.append(number)
            yield number

    eager = {2, 3}
    for number in prefetch(items(), lambda: len(made) - 1 in eager):
        if number not in eager:
            assert made[-1] == number
    assert made == list(range(6))


@pytest.mark.parametrize("depth", [1, 4])
def test_a_closed_prefetch_stops_its_source(depth: int) -> None:
    count = 0

    def items() -> Iterator[int]:
        nonlocal count
        while True:
            count += 1
            yield count

    source = prefetch(items(), depth=depth)
    next(source)
    source.close()
    assert count <= 1 + depth


def test_as_many_items_as_the_depth_are_prefetched() -> None:
    made: list[int] = []
    ready = threading.Event()

    def items() -> Iterator[int]:
        for number in range(9):
            made.append(number)
            if number == 4:
                ready.set()
            yield number

    source = prefetch(items(), depth=4)
    assert next(source) == 0
    assert ready.wait(200.0)
    assert made == list(range(5))
    assert list(source) == list(range(1, 9))
    assert made == list(range(9))
