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
        self.paused = False
        """Whether bundles are held."""
        self.stopped = False
        """Whether they are held by a request to stop, and there was no `pause` since."""
        self.closed = False
        """Whether no bundle is sent any more."""
        self.resetting = False
        """Whether a reset was requested that the engine's thread has not finished."""
        self._steps = 0
        """Bundles to send while paused."""
        self.stepped = 0
        """Number of bundles sent while paused, since the beginning."""
        self._deadline: float | None = None
        """Wall time at which the present bundle is due [s]; none if it is to be determined."""

    @property
    def stepping(self) -> bool:
        """Whether bundles remain to be sent while paused."""
        return self._steps > 0 and not self.closed

    @property
    def open(self) -> bool:
        """Whether bundles are sent as soon as they are ready."""
        return self.pacer.scale == 0.0 and not self.paused

    def send(self, begin: float, end: float, write: Callable[[], None]) -> bool:
        """Call ``write`` when the bundle of simulated time ``begin`` to ``end`` [s] is due; return false if it is to be discarded."""
        with self._changed:
            if not self._until_due(begin, end):
                return False
            write()
            if self.paused:
                self._steps -= 1
                self.stepped += 1
                self._changed.notify_all()
            return True

    def _until_due(self, begin: float, end: float) -> bool:
        self._deadline = None
        while not (self.closed or self.resetting):
            if self.paused:
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

    def pause(self, paused: bool, *, stopped: bool = False) -> None:
        """Hold bundles, or send them again from now on without catching up; ``stopped`` notes a request to stop."""
        with self._changed:
            if self.paused and not paused:
                self.pacer.restart()
            self.paused, self.stopped, self._steps, self._deadline = paused, stopped, 0, None
            self._changed.notify_all()

    def step(self, timeout: float) -> bool:
        """Send one bundle while paused; return whether it was sent within ``timeout`` of wall time [s]."""
        with self._changed:
            last = self.request_steps(1)
            self._changed.wait_for(lambda: self.stepped >= last or self._steps == 0 or self.closed, timeout)
            return self.stepped >= last

    def request_steps(self, count: int) -> int:
        """Send ``count`` more bundles while paused, without waiting for them; `pause` and a later reset discard what remains.

        Return the value that `stepped` has after the last of them.
        """
        with self._changed:
            self._steps += count
            self._changed.notify_all()
            return self.stepped + self._steps

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
            self.resetting, self._steps = True, 0
            self._changed.notify_all()
            return self._changed.wait_for(lambda: not self.resetting or self.closed, timeout) and not self.closed

    def finish_reset(self) -> None:
        """Send bundles again, from the start of the source; called by the engine's thread."""
        with self._changed:
            self.pacer.restart()
            self.resetting = False
            self._changed.notify_all()

    def start_over(self) -> None:
        """Send the next bundle at once, and the following ones at new deadlines; called by the engine's thread."""
        with self._changed:
            self.pacer.start_over()

    def close(self) -> None:
        """Send nothing any more."""
        with self._changed:
            self.closed = True
            self._changed.notify_all()
