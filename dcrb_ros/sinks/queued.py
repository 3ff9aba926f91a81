"""A recorder in a thread of its own, so that neither the model nor ROS ever waits for a disk."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterable
from pathlib import Path

from dcrb_ros.sinks.bag import RecordingFailed
from dcrb_ros.sinks.recorder import Recorder
from dcrb_ros.threads import NamedThread
from dcrb_ros.topics import Message

LAST_WRITE = 10.0
"""Wall time that the disk gets to take what waits, once the recording is closed [s]."""
POLL = 0.1
"""Wall time between two looks at whether the recording was closed [s]."""


class QueuedRecorder:
    """A sink of messages that hands them to a recorder through a bounded queue; any thread may write.

    A failure ends the recording and is raised once, by the next call; later calls do nothing.
    """

    def __init__(self, recorder: Recorder, blocks: int) -> None:
        """Record by ``recorder``; at most ``blocks`` lists of messages wait."""
        self._recorder, self._blocks = recorder, blocks
        self._queue: queue.Queue[list[Message]] = queue.Queue(blocks)
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self._failure: RecordingFailed | None = None
        self._over = False
        self._thread = NamedThread("recorder", self._run)
        self._thread.start()

    @property
    def path(self) -> Path:
        """Folder of the recording."""
        return self._recorder.path

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Queue messages.

        Raises:
            RecordingFailed: the recording has ended for want of room or speed.
        """
        self._raise_failure()
        if self._over:
            return
        taken = list(messages)
        try:
            self._queue.put_nowait(taken)
        except queue.Full:
            reached = max((message.time_ns for message in taken), default=0) * 1e-9
            self._fail(
                f"the recording {self._recorder.path} ended at {reached:.1f} s: the disk is slower than the bench, "
                f"{self._blocks} blocks were waiting; record to a faster one, fewer topics, or raise recording.queue"
            )
            self._closing.set()  # what waits is still written, and the file finished
            self._raise_failure()

    def close(self) -> None:
        """Write what waits and finish the recording; a second call does nothing.

        Raises:
            RecordingFailed: it could not be finished.
        """
        self._closing.set()
        self._thread.join(LAST_WRITE)
        if self._thread.is_alive():
            self._fail(f"the recording {self._recorder.path} could not be finished: the disk did not answer for {LAST_WRITE:g} s")
        self._raise_failure()
        self._over = True

    def _run(self) -> None:
        try:
            while not (self._closing.is_set() and self._queue.empty()):
                try:
                    self._recorder.write_messages(self._queue.get(timeout=POLL))
                except queue.Empty:
                    continue
            self._recorder.close()
        except Exception as error:  # the thread's end must be heard of, whatever it is
            self._fail(str(error) or type(error).__name__)
            with contextlib.suppress(RecordingFailed):
                self._recorder.close()

    def _fail(self, words: str) -> None:
        with self._lock:
            if not self._over:
                self._failure, self._over = RecordingFailed(words), True

    def _raise_failure(self) -> None:
        with self._lock:
            failure, self._failure = self._failure, None
        if failure is not None:
            raise failure
