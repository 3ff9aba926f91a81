"""Items made ahead of their use."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from dcrb_ros.runtime.prefetch import ahead


def test_all_items_come_in_their_order() -> None:
    assert list(ahead(iter(range(100)))) == list(range(100))
    assert list(ahead(iter([]))) == []


def test_the_next_item_is_made_while_the_last_is_used() -> None:
    made: list[str] = []
    ready = threading.Event()

    def items() -> Iterator[int]:
        for number in range(3):
            made.append(threading.current_thread().name)
            if number == 1:
                ready.set()
            yield number

    source = ahead(items())
    assert next(source) == 0
    assert ready.wait(10.0)
    assert list(source) == [1, 2]
    assert made[0] == threading.current_thread().name
    assert made[1] != made[0]


def test_a_failure_comes_at_its_place() -> None:
    def items() -> Iterator[int]:
        yield 0
        raise OSError("no room")

    source = ahead(items())
    assert next(source) == 0
    with pytest.raises(OSError, match="no room"):
        next(source)


def test_only_what_is_wanted_is_made_ahead() -> None:
    made: list[int] = []

    def items() -> Iterator[int]:
        for number in range(6):
            made.append(number)
            yield number

    eager = {2, 3}
    for number in ahead(items(), lambda: len(made) - 1 in eager):
        if number not in eager:
            assert made[-1] == number
    assert made == list(range(6))


@pytest.mark.parametrize("most", [1, 4])
def test_a_source_left_alone_stops(most: int) -> None:
    count = 0

    def items() -> Iterator[int]:
        nonlocal count
        while True:
            count += 1
            yield count

    source = ahead(items(), most=most)
    next(source)
    source.close()
    assert count <= 1 + most


def test_as_many_as_asked_for_are_made_while_one_is_used() -> None:
    made: list[int] = []
    ready = threading.Event()

    def items() -> Iterator[int]:
        for number in range(9):
            made.append(number)
            if number == 4:
                ready.set()
            yield number

    source = ahead(items(), most=4)
    assert next(source) == 0
    assert ready.wait(10.0)
    assert made == list(range(5))
    assert list(source) == list(range(1, 9))
    assert made == list(range(9))
