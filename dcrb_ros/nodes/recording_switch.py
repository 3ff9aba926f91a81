"""Recordings of a running node: one after the other, or none."""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import Message, Topic
from dcrb_ros.recordings.recorder_thread import CLOSE_TIMEOUT, RecorderThread
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import expanded_path

FOLDER = Path("recordings")
"""Folder of the recordings for which the user gave no path."""
CreateRecorder = Callable[..., RecorderThread]
"""Creates the recorder of a recording in a folder, with the ``commands`` that took effect before its start at ``start_ns`` [ns]."""


def free_path(wanted: Path) -> Path:
    """Return a path that does not exist: the one wanted, or with -2, -3 and so on appended."""
    number, path = 1, wanted
    while path.exists():
        number += 1
        path = wanted.with_name(f"{wanted.name}-{number}")
    return path


def wanted_path(configured: str, namespace: str) -> Path:
    """Return the absolute path of a new recording: as configured, or by namespace and time in `FOLDER`."""
    name = namespace.strip("/").replace("/", "-") or "bench"
    return (expanded_path(configured) if configured else FOLDER / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}").absolute()


class RecordingSwitch:
    """A sink that records while it is switched on; any thread may switch it. A failure ends the recording, not the simulation."""

    def __init__(self, create: CreateRecorder, log: Any, path: Path | None = None) -> None:
        """Record to ``path`` from the start, if it is given; ``log`` is the logger of a node."""
        self._create, self._log, self._wanted = create, log, path
        self._lock = threading.Lock()
        self._recorder: RecorderThread | None = None
        self._closing: list[RecorderThread] = []
        """Recorders that receive nothing more and may still be writing."""
        self._empty = True
        """Whether the present recording has no block yet."""
        self._failure = ""
        self.first_failure = ""
        """Why the first recording that failed did, also if later ones were finished; empty if none failed."""
        self._started = self._closed = False
        self._commands: list[Any] = []
        self._latched: dict[Topic, Message] = {}
        """The last message on each latched topic since the start."""
        self._time_ns = 0

    @property
    def state(self) -> str:
        """``off``, ``recording``, or why the last recording failed."""
        return "recording" if self._recorder else self._failure or "off"

    @property
    def failed(self) -> bool:
        """Whether the last recording ended by a failure."""
        return bool(self._failure)

    @property
    def path(self) -> Path | None:
        """Folder of the present recording; none if there is none."""
        recorder = self._recorder  # read once: another thread may end the recording at any time
        return recorder.path if recorder else None

    def start(self, messages: Sequence[Message]) -> None:
        """Begin the configured recording; after a reset finish the present recording and begin the next one.

        Where the path is taken, as when the node is started again, the recording takes the next free name.

        Raises:
            Refusal: the configured recording cannot be created.
        """
        finished = self.stop() if self._started else None
        with self._lock:
            self._commands, self._time_ns = [], 0
            self._latched = {}
            if not self._started and self._wanted is not None:
                path = self._begin(free_path(self._wanted))
                if path != self._wanted:
                    self._log.info(f"{self._wanted} exists and is kept: recording to {path}")
        self._started = True
        if finished is not None and self._wanted is not None:
            kept = f"{finished} is finished, " if finished.exists() else ""
            try:
                self._log.info(f"reset: {kept}{self.record(self._wanted)} records from the start")
            except Refusal as refusal:
                if not self._closed:
                    self._fail(f"no recording since the reset: {refusal}")

    def record(self, wanted: Path) -> Path:
        """Begin a recording at ``wanted`` or the next free name, unless one is running; return the folder of the running one.

        Raises:
            Refusal: it cannot be created, or `close` was called.
        """
        with self._lock:
            if self._closed:
                raise Refusal("no recording begins any more: start the node again")
            if self._recorder is None:
                self._wanted = wanted
                return self._begin(free_path(wanted))
            return self._recorder.path

    def _begin(self, path: Path) -> Path:
        """Begin a recording, with the lock held."""
        self._recorder, self._failure = self._create(path, commands=self._commands, start_ns=self._time_ns), ""
        self._empty = True
        if self._latched:  # the recorder describes the bench as it started
            self._write([replace(message, time_ns=self._time_ns) for message in self._latched.values()])
        return path

    def write(self, bundle: Bundle) -> None:
        """Record a bundle, if a recording is running."""
        with self._lock:
            self._write(bundle.messages)
            self._empty = False
            self._latched |= {message.topic: message for message in bundle.messages if message.topic.latched}
            self._time_ns = bundle.end_ns
            self._commands += bundle.commands

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages, if a recording is running."""
        with self._lock:
            self._write(messages)

    def _write(self, messages: Iterable[Message]) -> None:
        if self._recorder is None:
            return
        try:
            self._recorder.write_messages(messages)
        except RecordingFailed as error:
            self._retire()
            self._fail(str(error))

    def stop(self) -> Path | None:
        """Finish the running recording and wait for earlier ones that are still being written; return its folder.

        A recording without a block is removed. Only the caller waits for the disk; `write` does not.
        """
        with self._lock:
            recorder, empty = self._retire(), self._empty
            closing = tuple(self._closing)
        self._close(closing)
        if recorder and empty and not recorder.writing:
            shutil.rmtree(recorder.path, ignore_errors=True)
        return recorder.path if recorder else None

    def close(self) -> None:
        """Do the same as `stop`, and begin no other recording, also not that of a reset that is under way."""
        with self._lock:
            self._closed = True
        self.stop()

    def _retire(self) -> RecorderThread | None:
        """Pass nothing more to the recorder, with the lock held; what is queued is still written."""
        recorder, self._recorder = self._recorder, None
        self._closing = [earlier for earlier in self._closing if not earlier.settled]
        if recorder is not None:
            self._closing.append(recorder)
        return recorder

    def _close(self, recorders: Iterable[RecorderThread]) -> None:
        """Wait for all recorders together, no longer than `CLOSE_TIMEOUT`."""
        deadline = time.monotonic() + CLOSE_TIMEOUT
        for recorder in recorders:
            try:
                recorder.close(max(0.0, deadline - time.monotonic()))
            except RecordingFailed as error:
                self._fail(str(error))

    def _fail(self, reason: str) -> None:
        """Log why a recording failed, and keep the reason unless another recording is running."""
        if self._recorder is None:
            self._failure = reason
        self.first_failure = self.first_failure or reason
        self._log.error(reason)
