"""Pacing of simulated time to wall time: absolute deadlines, bounded catch-up."""

from __future__ import annotations

import threading
from collections.abc import Callable

MAX_LAG = 0.1
"""Lag above which the status of a node is a warning [s]."""
MAX_CATCH_UP = 1.0
"""Lag that is caught up [s of wall time]; beyond it the deadlines are postponed."""


class Pacer:
    """Deadlines of bundles: simulated time passes ``scale`` times as fast as wall time.

    With a scale of zero there are no deadlines. The deadlines are relative to a reference, which moves when the scale changes or when the
    source is late by more than `MAX_CATCH_UP`, so that no rush follows a long stall.
    """

    def __init__(self, scale: float, clock: Callable[[], float]) -> None:
        """Set deadlines on ``clock``, which returns wall time [s]."""
        self._clock = clock
        self._scale = scale
        self._reference: tuple[float, float] | None = None
        """Wall and simulated time that correspond to each other [s]; none if they are set at the next bundle."""
        self._first = True
        self.lag = 0.0
        """How late the last bundle was [s of wall time]."""
        self.late = 0
        """Bundles that were late by more than their own duration."""

    @property
    def scale(self) -> float:
        """Requested ratio of simulated to wall time [-]."""
        return self._scale

    @scale.setter
    def scale(self, scale: float) -> None:
        self._scale = scale
        self.restart()

    def restart(self) -> None:
        """Set the reference at the next bundle: earlier lag is not caught up."""
        self._reference = None
        self.lag = 0.0

    def start_over(self) -> None:
        """Send the next bundle at once and set the reference at the one after it."""
        self._first, self._reference = True, None

    def until(self, begin: float, end: float) -> float:
        """Return the wall time [s] to wait before a bundle of simulated time ``begin`` to ``end`` [s] is sent; 0 if it is due."""
        if self._scale == 0.0:
            self.lag = 0.0
            return 0.0
        if self._first:
            # The first bundle is sent at once: preparations made while it is sent would delay the following ones.
            self._first = False
            return 0.0
        now = self._clock()
        if self._reference is None:
            self._reference = now, begin
        wall, simulated = self._reference
        remaining = wall + (end - simulated) / self._scale - now
        self.lag = max(0.0, -remaining)
        if self.lag > (end - begin) / self._scale:
            self.late += 1
        if self.lag > MAX_CATCH_UP:
            self._reference = now, end
        return min(max(0.0, remaining), threading.TIMEOUT_MAX)  # the longest wait of a lock, for scales near zero
