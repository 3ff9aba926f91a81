"""A recorder in a thread of its own, so that neither the model nor ROS ever waits for a disk."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Iterable
from pathlib import Path

from dcrb_ros.messages.topics import Message
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.rosbag2 import RecordingFailed
from dcrb_ros.runtime.threads import NamedThread

LAST_WRITE = 3.0
"""Wall time that the disk gets to take what waits, once the recording is closed [s]; `dcrb bench` gives a node 10 s for all of its end."""
GATHER_NS = 100_000_000
"""Simulated time that is gathered before it is written [ns]: waking for every block costs half as much again."""
PATIENCE = 0.25
"""Wall time after which what waits is written all the same [s]."""


class QueuedRecorder:
    """A sink of messages that hands them to a recorder through a bounded queue; any thread may write.

    A failure ends the recording and is raised once, by the next call; later calls do nothing.
    """

    def __init__(self, recorder: Recorder, blocks: int) -> None:
        """Record by ``recorder``; at most ``blocks`` lists of messages wait."""
        self._recorder, self._blocks = recorder, blocks
        self._waiting: deque[list[Message]] = deque()
        self._gathered_ns = 0
        self._closing = threading.Event()
        self._called = threading.Event()
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
        if len(self._waiting) >= self._blocks:
            reached = max((message.time_ns for message in taken), default=0) * 1e-9
            self._fail(
                f"the recording {self._recorder.path} ended at {reached:.1f} s: the disk is slower than the bench, "
                f"{self._blocks} blocks were waiting; record to a faster one, fewer topics, or raise recording.queue"
            )
            self._end()  # what waits is still written, and the file finished
            self._raise_failure()
            return
        self._waiting.append(taken)
        self._call(max((message.time_ns for message in taken), default=0))

    def _call(self, time_ns: int) -> None:
        """Call the thread where enough waits at a simulated time [ns]: now, right after a block, it is in nobody's way."""
        if time_ns >= self._gathered_ns + GATHER_NS or len(self._waiting) > self._blocks // 4:
            self._gathered_ns = time_ns
            self._called.set()

    @property
    def writing(self) -> bool:
        """Whether something may still be written."""
        return self._thread.is_alive()

    def close(self, patience: float = LAST_WRITE) -> None:
        """Write what waits and finish the recording, within ``patience`` [s] of wall time; a second call waits once more.

        Raises:
            RecordingFailed: it could not be finished.
        """
        self._end()
        self._thread.join(patience)
        if self.writing:
            self._fail(
                f"the recording {self._recorder.path} could not be finished in time: the disk takes more than {LAST_WRITE:g} s; "
                "it is written on for as long as the node runs"
            )
        self._raise_failure()
        self._over = True

    def _end(self) -> None:
        self._closing.set()
        self._called.set()

    def _run(self) -> None:
        try:
            while not (self._closing.is_set() and not self._waiting):
                self._called.wait(PATIENCE)
                if not self._closing.is_set():
                    self._called.clear()
                while self._waiting:
                    self._recorder.write_messages(self._waiting.popleft())
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
