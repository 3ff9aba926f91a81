"""The gate through which blocks go out: paced to wall time, held back while paused, dropped at a reset."""

from __future__ import annotations

import threading
from collections.abc import Callable

from dcrb_ros.nodes.pacing import Pacer


class Gate:
    """What the model's thread asks before it sends a block, and what other threads tell it.

    Once `pause` has returned, no further block goes out; once `step` has returned true, one more has.
    """

    def __init__(self, pacer: Pacer, clock: Callable[[], float]) -> None:
        self._pacer, self._clock = pacer, clock
        self._told = threading.Condition()
        self._paused = self._closed = self._resetting = self._deadline_stands = False
        self._steps = 0

    @property
    def paused(self) -> bool:
        """Whether blocks are held back."""
        return self._paused

    @property
    def closed(self) -> bool:
        """Whether no block goes out any more."""
        return self._closed

    def send(self, begin: float, end: float, out: Callable[[], None]) -> bool:
        """Call ``out`` when the block of simulated time ``begin`` to ``end`` [s] is due; return false if it is to be dropped."""
        with self._told:
            if not self._until_due(begin, end):
                return False
            out()
            if self._paused:
                self._steps -= 1
                self._told.notify_all()
            return True

    def _until_due(self, begin: float, end: float) -> bool:
        deadline, self._deadline_stands = 0.0, False
        while not (self._closed or self._resetting):
            if self._paused:
                if self._steps:
                    return True
                self._told.wait()
                continue
            if not self._deadline_stands:
                deadline, self._deadline_stands = self._clock() + self._pacer.until(begin, end), True
            left = deadline - self._clock()
            if left <= 0.0:
                return True
            self._told.wait(left)
        return False

    def pause(self, asked: bool) -> None:
        """Hold blocks back, or let them go on from now without catching up."""
        with self._told:
            if self._paused and not asked:
                self._pacer.restart()
            self._paused, self._steps, self._deadline_stands = asked, 0, False
            self._told.notify_all()

    def step(self, patience: float) -> bool:
        """Let one block out while paused; return whether it went within ``patience`` [s]."""
        with self._told:
            self._steps += 1
            self._told.notify_all()
            return self._told.wait_for(lambda: self._steps == 0 or self._closed, patience) and self._steps == 0

    def rescale(self, scale: float) -> None:
        """Go on at another time scale, at once."""
        with self._told:
            self._pacer.scale = scale
            self._deadline_stands = False
            self._told.notify_all()

    def reset(self, patience: float) -> bool:
        """Ask the model's thread to begin anew; return whether it has within ``patience`` [s]."""
        with self._told:
            self._resetting = True
            self._told.notify_all()
            return self._told.wait_for(lambda: not self._resetting or self._closed, patience) and not self._closed

    def begun_anew(self) -> None:
        """Say that the model stands at its start again."""
        with self._told:
            self._pacer.restart()
            self._resetting, self._steps = False, 0
            self._told.notify_all()

    def close(self) -> None:
        """Let nothing out any more."""
        with self._told:
            self._closed = True
            self._told.notify_all()
