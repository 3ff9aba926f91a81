"""The diagnoses of the blocks that a node sends: with them a fast run loses no block and ends with the last verdict."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from contextlib import closing

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import DIAGNOSIS, VIBRATION, Message, Topic
from dcrb_ros.nodes.engine import BundleSource
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.schema.refusal import Refusal

AHEAD = VIBRATION.depth // 2
"""Bundles that are sent as fast as possible before a diagnosis reaches the first of them; the queue of the detector holds twice as many."""
ROOM_NS, MORE_ROOM = 2_000_000_000, 10
"""Signal that a detector may need for a diagnosis [ns], and how many times as much as was in vain it may need after a silence."""
TIMEOUT, FIRST_TIMEOUT = 5.0, 30.0
"""Wall time without a diagnosis after which none is expected [s]; before the first one, a detector may still compile its kernels."""
RECORDED_TIMEOUT = 1.0
"""Wall time after the last diagnosis up to which its messages to record are waited for [s]; a user's detector may publish fewer topics."""
POLL_PERIOD = 0.1
"""Wall time between two looks at whether the node ends [s]."""


class Answers:
    """Follows the diagnoses; a node without a detector has nothing to wait for."""

    def __init__(self, detectors: Callable[[], int], log: Callable[[str], object], clock: Callable[[], float] = time.monotonic) -> None:
        """Follow the diagnoses of the ``detectors`` that are counted by this function; ``clock`` returns wall time [s]."""
        self._detectors, self._log, self._clock = detectors, log, clock
        self._changed = threading.Condition()
        self._unanswered: deque[int] = deque(maxlen=AHEAD)
        """Ends of the last bundles, as far as no diagnosis has reached them [ns]."""
        self._last_ns = self._interval_ns = 0
        """Stamp of the last diagnosis, and the shortest interval of two; 0 for none [ns]."""
        self._arrived = clock()
        self._asked: float | None = None
        """Wall time at which `complete` was called first [s]."""
        self._silent = self._extended = False
        """Whether no diagnosis is waited for until one arrives, and whether `_room_ns` has grown since the last one."""
        self._room_ns = ROOM_NS
        """Signal beyond the last diagnosis up to which more is sent, at its own pace [ns]."""
        self._since_ns: int | None = None
        """Stamp of the last diagnosis, or begin of the first bundle; None before it [ns]."""
        self._recorded: dict[Topic, int] = {}
        """Stamp of the last message on each topic of the detector that is recorded [ns]."""

    def take(self, data: bytes) -> None:
        """Take a diagnosis; a malformed one is ignored."""
        try:
            time_ns = DIAGNOSIS.stamp(data)
        except Refusal:
            return
        with self._changed:
            interval = time_ns - self._last_ns
            if self._last_ns and interval > 0:
                self._interval_ns = min(interval, self._interval_ns or interval)
            self._last_ns, self._arrived, self._silent, self._extended = time_ns, self._clock(), False, False
            self._since_ns = time_ns
            while self._unanswered and self._unanswered[0] <= time_ns:
                self._unanswered.popleft()
            self._changed.notify_all()

    def take_recorded(self, topic: Topic, time_ns: int) -> None:
        """Take the stamp [ns] of a message to record; the last diagnosis is complete with its message on each topic."""
        with self._changed:
            self._recorded[topic] = time_ns

    def start(self) -> None:
        """Expect no diagnosis of what was sent before."""
        with self._changed:
            self._unanswered.clear()
            self._since_ns = None

    def await_room(self, gate: Gate, seconds: float) -> None:
        """Wait while `AHEAD` bundles are unanswered and the gate is open, but not longer than diagnoses are expected.

        A detector may need more signal than these bundles have, because they are short, or because a box of a vehicle is silent. Therefore
        bundles are sent one every ``seconds``, their own duration, up to `ROOM_NS` beyond the last diagnosis. After a silence this limit
        grows once.
        """
        with self._changed:
            began = self._clock()
            while len(self._unanswered) == AHEAD and not self._silent and gate.open and not gate.closed and self._detectors():
                paced = self._unanswered[-1] - (self._since_ns or 0) < self._room_ns
                end = began + min(seconds, TIMEOUT) if paced else max(began, self._arrived) + self._timeout
                if (remaining := end - self._clock()) > 0.0 and (paced or not self._extended):
                    self._changed.wait(min(POLL_PERIOD, remaining))
                elif paced:
                    return
                else:
                    self._end_wait()

    def _end_wait(self) -> None:
        """Let more signal pass, at its own pace; if that was in vain, any."""
        if self._extended:
            self._silent = True
            self._log("still no diagnosis: the blocks no longer wait for the detector, which may lose some")
        else:
            self._extended = True
            self._room_ns = MORE_ROOM * (self._unanswered[-1] - (self._since_ns or 0))
            self._log(
                f"no diagnosis within {self._timeout:g} s: the next blocks are sent at their own pace, "
                f"up to {self._room_ns * 1e-9:g} s of signal beyond the last diagnosis"
            )

    def expect(self, begin_ns: int, end_ns: int) -> None:
        """Expect a diagnosis of a bundle from a time to another [ns]."""
        with self._changed:
            self._unanswered.append(end_ns)
            if self._since_ns is None:
                self._since_ns = begin_ns

    def complete(self, end_ns: int) -> bool:
        """Return whether the last diagnosis of a signal that ends at a time [ns] has arrived and is recorded, or none is expected."""
        with self._changed:
            self._asked = self._clock() if self._asked is None else self._asked
            if self._interval_ns and self._last_ns + self._interval_ns > end_ns:
                missing = any(time_ns < self._last_ns for time_ns in self._recorded.values())
                return not missing or self._clock() > self._arrived + RECORDED_TIMEOUT
            return not self._detectors() or self._clock() > max(self._asked, self._arrived) + self._timeout

    @property
    def _timeout(self) -> float:
        return TIMEOUT if self._last_ns else FIRST_TIMEOUT


class AnsweredSource:
    """A source that does not run away from the detector when its bundles are sent as fast as possible."""

    def __init__(self, source: BundleSource, answers: Answers, gate: Gate) -> None:
        self._source, self._answers, self._gate = source, answers, gate

    def start(self) -> Sequence[Message]:
        """Start the source."""
        return self._source.start()

    def bundles(self) -> Generator[Bundle, None, None]:
        """Yield the bundles of the source, each when the detector has room for it."""
        self._answers.start()
        with closing(self._source.bundles()) as bundles:
            for bundle in bundles:
                self._answers.await_room(self._gate, (bundle.end_ns - bundle.begin_ns) * 1e-9)
                yield bundle
                self._answers.expect(bundle.begin_ns, bundle.end_ns)
