"""Simulated time on /clock, throttled: each message costs every node that uses it."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from typing import Protocol

from dcrb_ros.messages.plain import encode_clock
from dcrb_ros.messages.topics import CLOCK, Message

CLOCK_PERIOD = 0.01
"""Least wall time between two messages [s]."""


class Sink(Protocol):
    """Where messages go."""

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Take messages."""


class ClockHand:
    """What tells the time on /clock, if it was asked for."""

    def __init__(self, sink: Sink, *, asked: bool) -> None:
        self._sink, self._asked, self._due = sink, asked, 0.0
        self._lock = threading.Lock()

    def tick(self, time_ns: int, period: float = CLOCK_PERIOD) -> None:
        """Publish a simulated time [ns], not before the period [s of wall time] since the last one is over."""
        if not self._asked:
            return
        with self._lock:
            now = time.monotonic()
            if now >= self._due:
                self._due = now + period
                self._sink.write_messages([Message(CLOCK, time_ns, encode_clock(time_ns))])
