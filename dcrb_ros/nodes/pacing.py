"""Simulated against wall time: absolute deadlines, bounded catch-up."""

from __future__ import annotations

import threading
from collections.abc import Callable

LARGEST_LAG = 1.0
"""Lag that is caught up [s of wall time]; beyond it the deadlines move."""


class Pacer:
    """Deadlines of blocks on a wall clock that runs ``scale`` times slower than simulated time.

    A scale of zero has no deadlines. The reference moves when the scale changes or when the source has fallen behind by more
    than `LARGEST_LAG`, so that a stall is not followed by a rush.
    """

    def __init__(self, scale: float, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._scale = scale
        self._wall = self._simulated = 0.0
        self._first = True
        self._started = False
        self.lag = 0.0
        """How long after its deadline the last block came [s]."""
        self.late = 0
        """Blocks that came later than their own length after the deadline."""

    @property
    def scale(self) -> float:
        """Simulated over wall time asked for [-]."""
        return self._scale

    @scale.setter
    def scale(self, scale: float) -> None:
        self._scale = scale
        self.restart()

    def restart(self) -> None:
        """Count the deadlines from the next block on: what was before is not caught up."""
        self._started = False
        self.lag = 0.0

    def start_over(self) -> None:
        """Begin with new deadlines: what comes next goes out at once."""
        self._first, self._started = True, False

    def until(self, begin: float, end: float) -> float:
        """Return the wall time [s] to wait before a block of simulated time ``begin`` to ``end`` [s] goes out; 0 if due."""
        if self._scale == 0.0:
            self.lag = 0.0
            return 0.0
        if self._first:
            # The first block goes out at once: what is prepared on its way would make the next ones late.
            self._first = False
            return 0.0
        now = self._clock()
        if not self._started:
            self._started, self._wall, self._simulated = True, now, begin
        ahead = self._wall + (end - self._simulated) / self._scale - now
        self.lag = max(0.0, -ahead)
        if self.lag > (end - begin) / self._scale:
            self.late += 1
        if self.lag > LARGEST_LAG:
            self._wall, self._simulated = now, end
        return min(max(0.0, ahead), threading.TIMEOUT_MAX)  # longer no lock can wait: a scale may be next to nothing
