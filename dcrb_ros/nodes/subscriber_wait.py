"""Waiting for subscribers to the waveform before the first block, so that they miss no sample."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from dcrb_ros.messages.topics import SENSOR, VIBRATION, Topic

SETTLING_TIME = 0.5
"""Wall time without a new subscriber after which no more are expected [s]."""


class Publishing(Protocol):
    """The part of `dcrb_ros.nodes.publisher.Publisher` that is used here."""

    def subscribers(self, topic: Topic) -> int:
        """Return the number of subscribers to a topic."""

    def delivered(self, topic: Topic) -> bool:
        """Return whether every subscriber has acknowledged the messages of a topic."""


class SubscriberWait:
    """Tells when the first block may be sent: once enough subscribers to the waveform have joined, or the longest wait is over.

    A publisher discovers a subscriber before the subscriber discovers it. A subscriber has discovered the publisher of the waveform when it
    has acknowledged the sensor description, whose publisher is created later.
    """

    def __init__(self, publisher: Publishing, listeners: int, timeout: float, clock: Callable[[], float] = time.monotonic) -> None:
        """Wait for ``listeners`` subscribers, at most ``timeout`` [s] on ``clock``."""
        self._publisher, self._listeners, self._timeout, self._clock = publisher, listeners, timeout, clock
        self._subscribers = 0
        self._since = self._changed_at = clock()

    def over(self) -> bool:
        """Return whether the wait is over; it must be called repeatedly."""
        now, count = self._clock(), self._publisher.subscribers(VIBRATION)
        if count != self._subscribers:
            self._subscribers, self._changed_at = count, now
        settled = now - self._changed_at >= SETTLING_TIME and self._publisher.delivered(SENSOR)
        return (count >= self._listeners and settled) or now >= self._since + self._timeout

    @property
    def missing(self) -> str:
        """Sentence about subscribers that have not joined; empty if none is missing."""
        if self._subscribers >= self._listeners:
            return ""
        return (
            f"{self._subscribers} of {self._listeners} subscribers to {VIBRATION.name} have joined within {self._timeout:g} s; "
            "the others miss the first blocks: lower the number of listeners or raise the wait"
        )
