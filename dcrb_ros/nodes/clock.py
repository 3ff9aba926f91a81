"""Simulated time on /clock, throttled because each message costs every node that uses it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Sequence

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.plain import encode_clock
from dcrb_ros.messages.topics import CLOCK, Message

PERIOD = 0.01
"""Shortest wall time between two messages [s]."""


class ClockPublisher:
    """A sink that publishes the end of each bundle on /clock."""

    def __init__(self, publish: Callable[[Iterable[Message]], None]) -> None:
        self._publish, self._next = publish, 0.0
        self._lock = threading.Lock()

    def start(self, messages: Sequence[Message]) -> None:
        """Publish nothing: the first bundle has the first time."""

    def write(self, bundle: Bundle) -> None:
        """Publish the end of a bundle, unless a message was published less than `PERIOD` ago."""
        self._tick(bundle.end_ns, PERIOD)

    def repeat(self, time_ns: int) -> None:
        """Publish the time [ns] of a paused simulation again, unless `write` has published it less than `PERIOD` ago."""
        self._tick(time_ns, 0.0)

    def _tick(self, time_ns: int, period: float) -> None:
        with self._lock:
            now = time.monotonic()
            if now >= self._next:
                self._next = now + period
                self._publish([Message(CLOCK, time_ns, encode_clock(time_ns))])
