"""The gate through which bundles are sent: paced to wall time, held while paused, discarded by a reset."""

from __future__ import annotations

import threading
from collections.abc import Callable

from dcrb_ros.nodes.pacing import Pacer


class Gate:
    """Synchronizes the engine's thread, which sends bundles, with the threads that control it.

    Once `pause` has returned, no further bundle is sent; once `step` has returned true, one more has been sent.
    """

    def __init__(self, pacer: Pacer, clock: Callable[[], float]) -> None:
        """Send bundles at the deadlines of ``pacer`` on ``clock``, which returns wall time [s]."""
        self.pacer, self._clock = pacer, clock
        self._changed = threading.Condition()
        self._paused = self._closed = self._resetting = False
        self._steps = 0
        """Bundles to send while paused."""
        self._stepped = 0
        self._deadline: float | None = None
        """Wall time at which the present bundle is due [s]; none if it is to be determined."""

    @property
    def paused(self) -> bool:
        """Whether bundles are held."""
        return self._paused

    @property
    def closed(self) -> bool:
        """Whether no bundle is sent any more."""
        return self._closed

    @property
    def resetting(self) -> bool:
        """Whether a reset was requested that the engine's thread has not finished."""
        return self._resetting

    @property
    def stepping(self) -> bool:
        """Whether bundles remain to be sent while paused."""
        return self._steps > 0 and not self._closed

    @property
    def stepped(self) -> int:
        """Number of bundles sent while paused, since the beginning."""
        return self._stepped

    @property
    def open(self) -> bool:
        """Whether bundles are sent as soon as they are ready."""
        return self.pacer.scale == 0.0 and not self._paused

    def send(self, begin: float, end: float, write: Callable[[], None]) -> bool:
        """Call ``write`` when the bundle of simulated time ``begin`` to ``end`` [s] is due; return false if it is to be discarded."""
        with self._changed:
            if not self._until_due(begin, end):
                return False
            write()
            if self._paused:
                self._steps -= 1
                self._stepped += 1
                self._changed.notify_all()
            return True

    def _until_due(self, begin: float, end: float) -> bool:
        self._deadline = None
        while not (self._closed or self._resetting):
            if self._paused:
                if self._steps:
                    return True
                self._changed.wait()
                continue
            if self._deadline is None:
                self._deadline = self._clock() + self.pacer.until(begin, end)
            remaining = self._deadline - self._clock()
            if remaining <= 0.0:
                return True
            self._changed.wait(remaining)
        return False

    def pause(self, paused: bool) -> None:
        """Hold bundles, or send them again from now on without catching up."""
        with self._changed:
            if self._paused and not paused:
                self.pacer.restart()
            self._paused, self._steps, self._deadline = paused, 0, None
            self._changed.notify_all()

    def step(self, timeout: float) -> bool:
        """Send one bundle while paused; return whether it was sent within ``timeout`` of wall time [s]."""
        with self._changed:
            self.request_steps(1)
            last = self._stepped + self._steps
            self._changed.wait_for(lambda: self._stepped >= last or self._steps == 0 or self._closed, timeout)
            return self._stepped >= last

    def request_steps(self, count: int) -> None:
        """Send ``count`` more bundles while paused, without waiting for them; `pause` and a later reset discard what remains."""
        with self._changed:
            self._steps += count
            self._changed.notify_all()

    def rescale(self, scale: float) -> None:
        """Continue at another time scale, at once."""
        with self._changed:
            self.pacer.scale = scale
            self._deadline = None
            self._changed.notify_all()

    def reset(self, timeout: float) -> bool:
        """Request a reset; return whether the engine's thread finished it within ``timeout`` of wall time [s].

        Steps that are requested while it is pending are sent from the start.
        """
        with self._changed:
            self._resetting, self._steps = True, 0
            self._changed.notify_all()
            return self._changed.wait_for(lambda: not self._resetting or self._closed, timeout) and not self._closed

    def finish_reset(self) -> None:
        """Send bundles again, from the start of the source; called by the engine's thread."""
        with self._changed:
            self.pacer.restart()
            self._resetting = False
            self._changed.notify_all()

    def start_over(self) -> None:
        """Send the next bundle at once, and the following ones at new deadlines; called by the engine's thread."""
        with self._changed:
            self.pacer.start_over()

    def close(self) -> None:
        """Send nothing any more."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
