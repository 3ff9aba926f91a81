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
        self._publish, self._next, self._time_ns = publish, 0.0, 0
        self._lock = threading.Lock()

    def start(self, messages: Sequence[Message]) -> None:
        """Publish nothing: the first bundle has the first time. `repeat` publishes zero until then."""
        with self._lock:
            self._time_ns = 0

    def write(self, bundle: Bundle) -> None:
        """Publish the end of a bundle, unless a message was published less than `PERIOD` ago."""
        with self._lock:
            self._time_ns = bundle.end_ns
            if time.monotonic() >= self._next:
                self._publish_time()

    def repeat(self) -> None:
        """Publish the end of the last bundle once more, while none follows; `write` may have left it out."""
        with self._lock:
            self._publish_time()

    def _publish_time(self) -> None:
        """Publish the time, with the lock held: a time read before would run back behind that of `write`."""
        self._next = time.monotonic() + PERIOD
        self._publish([Message(CLOCK, self._time_ns, encode_clock(self._time_ns))])
