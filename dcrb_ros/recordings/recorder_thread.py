"""A recorder in a thread of its own, so that neither the simulation nor ROS waits for the disk."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from dcrb_ros.messages.topics import Message
from dcrb_ros.recordings.recorder import RunRecorder
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.runtime.threads import NamedThread

CLOSE_TIMEOUT = 3.0
"""Wall time in which queued messages must be written after `close` [s]; `dcrb bench` gives a node 10 s to end."""
BATCH_NS = 100_000_000
"""Simulated time that is collected before it is written [ns]: waking the thread for every block costs half as much again."""
WAKE_PERIOD = 0.25
"""Wall time after which queued messages are written even if less than `BATCH_NS` is queued [s]."""


class RecorderThread:
    """Passes messages to a recorder through a bounded queue; any thread may write.

    A failure ends the recording and is raised once, by the next call; later calls write nothing, and raise a failure since then.
    """

    def __init__(self, recorder: RunRecorder[Any], capacity: int) -> None:
        """Write with ``recorder``; the queue holds at most ``capacity`` lists of messages."""
        self._recorder, self._capacity = recorder, capacity
        self._queue: deque[list[Message]] = deque()
        self._woken_ns = 0
        """Simulated time at which the thread was last woken [ns]."""
        self._closing = threading.Event()
        self._wake = threading.Event()
        self._lock = threading.Lock()
        self._failures: list[str] = []
        """Failures that were not raised yet."""
        self._ended = False
        self._thread = NamedThread("recorder", self._run)
        self._thread.start()

    @property
    def path(self) -> Path:
        """Folder of the recording."""
        return self._recorder.path

    @property
    def writing(self) -> bool:
        """Whether the thread may still be writing."""
        return self._thread.is_alive()

    @property
    def settled(self) -> bool:
        """Whether the thread has ended, and all of its failures were raised."""
        return not self.writing and not self._failures

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Queue messages.

        Raises:
            RecordingFailed: the recording has ended, because the disk is full or too slow.
        """
        self._raise_failure()
        if self._ended:
            return
        batch = list(messages)
        time_ns = max((message.time_ns for message in batch), default=0)
        if len(self._queue) >= self._capacity:
            self._fail(
                f"the recording {self._recorder.path} ended at {time_ns * 1e-9:.1f} s: the disk is slower than the bench, "
                f"{self._capacity} blocks were waiting; record to a faster one, fewer topics, or raise recording.queue"
            )
            self._finish()  # queued messages are still written, and the file is finished
            self._raise_failure()
            return
        self._queue.append(batch)
        # Now, right after a block, the thread delays nobody.
        if time_ns >= self._woken_ns + BATCH_NS or len(self._queue) > self._capacity // 4:
            self._woken_ns = time_ns
            self._wake.set()

    def close(self, timeout: float = CLOSE_TIMEOUT) -> None:
        """Write queued messages and finish the recording within ``timeout`` of wall time [s]; a second call waits again.

        Raises:
            RecordingFailed: it could not be finished, or what was queued could not be written.
        """
        self._finish()
        self._thread.join(timeout)
        if self.writing:
            self._fail(
                f"the recording {self._recorder.path} could not be finished in time: the disk takes more than {CLOSE_TIMEOUT:g} s; "
                "writing continues as long as the node runs"
            )
        self._raise_failure()
        self._ended = True

    def _finish(self) -> None:
        self._closing.set()
        self._wake.set()

    def _run(self) -> None:
        try:
            while not (self._closing.is_set() and not self._queue):
                self._wake.wait(WAKE_PERIOD)
                if not self._closing.is_set():
                    self._wake.clear()
                while self._queue:
                    self._recorder.write_messages(self._queue.popleft())
            self._recorder.close()
        except Exception as error:  # any failure must reach the writers
            self._fail(str(error) or type(error).__name__)
            with contextlib.suppress(RecordingFailed):
                self._recorder.close()

    def _fail(self, reason: str) -> None:
        with self._lock:
            self._failures.append(reason)
            self._ended = True

    def _raise_failure(self) -> None:
        with self._lock:
            failures, self._failures = self._failures, []
        if failures:
            raise RecordingFailed("; ".join(failures))
