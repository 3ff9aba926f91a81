"""Waiting for subscribers to the waveform, or to another topic, before the first block, so that they miss no sample."""

from __future__ import annotations

import time
from collections.abc import Callable

from dcrb_ros.messages.topics import SENSOR, VIBRATION, Topic
from dcrb_ros.nodes.publisher import Publisher

SETTLING_TIME = 0.5
"""Wall time without a new subscriber after which no more are expected [s]."""


class SubscriberWait:
    """Tells when the first block may be sent: once enough subscribers to a topic have joined, or the longest wait is over.

    A publisher discovers a subscriber before the subscriber discovers it. A subscriber has discovered the publisher of the topic when it
    has acknowledged the sensor description, whose publisher is created later.
    """

    def __init__(
        self,
        publisher: Publisher,
        listeners: int,
        timeout: float,
        clock: Callable[[], float] = time.monotonic,
        *,
        topics: tuple[Topic, Topic] = (VIBRATION, SENSOR),
    ) -> None:
        """Wait for ``listeners`` subscribers, at most ``timeout`` [s] on ``clock``; ``topics`` are their topic and the description."""
        self._publisher, self.listeners, self.timeout, self._clock = publisher, listeners, timeout, clock
        self.topic, self._description = topics
        self._subscribers = 0
        self._since = self._changed_at = clock()

    def over(self) -> bool:
        """Return whether the wait is over; it must be called repeatedly."""
        now, count = self._clock(), self._publisher.subscribers(self.topic)
        if count != self._subscribers:
            self._subscribers, self._changed_at = count, now
        settled = now - self._changed_at >= SETTLING_TIME and self._publisher.delivered(self._description)
        return (count >= self.listeners and settled) or now >= self._since + self.timeout

    @property
    def missing(self) -> str:
        """Sentence about subscribers that have not joined; empty if none is missing."""
        if self._subscribers >= self.listeners:
            return ""
        return (
            f"{self._subscribers} of {self.listeners} subscribers to {self.topic.name} have joined within {self.timeout:g} s; "
            "the others miss the first blocks: lower the number of listeners or raise the wait"
        )
