"""A source of bundles, made without the model, for tests of the engine and what controls it."""

from __future__ import annotations

from collections.abc import Generator

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import SENSOR, VIBRATION, Message

BLOCK_NS = 20_000_000


class Blocks:
    """A source of bundles of 20 ms."""

    def __init__(self, count: int, failure: Exception | None = None) -> None:
        self.count, self.failure = count, failure
        self.starts = 0
        self.open_iterators = 0

    def start(self) -> list[Message]:
        self.starts += 1
        return [Message(SENSOR, 0, b"sensor")]

    def bundles(self) -> Generator[Bundle, None, None]:
        self.open_iterators += 1
        try:
            for number in range(self.count):
                message = Message(VIBRATION, number * BLOCK_NS, b"")
                yield Bundle(number * BLOCK_NS, (number + 1) * BLOCK_NS, (message,))
            if self.failure is not None:
                raise self.failure
        finally:
            self.open_iterators -= 1
