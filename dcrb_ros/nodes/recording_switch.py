"""What a running node records: one recording after the other, or none."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from dcrb_ros.messages.topics import Message

if TYPE_CHECKING:
    from dcrb_ros.recordings.recorder_thread import QueuedRecorder

FOLDER = Path("recordings")
"""Where recordings go that nobody has named."""


def free_path(wanted: Path) -> Path:
    """Return a path that does not exist yet: as wanted, or with -2, -3 and so on behind it."""
    number, path = 1, wanted
    while path.exists():
        number += 1
        path = wanted.with_name(f"{wanted.name}-{number}")
    return path


def wanted_path(configured: str, namespace: str) -> Path:
    """Return where a recording should go: as configured, or by namespace and time in `FOLDER`."""
    name = namespace.strip("/").replace("/", "-") or "bench"
    return Path(configured) if configured else FOLDER / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"


class Tape:
    """A sink of messages that can be switched on and off from any thread; a failure ends the recording, not the bench."""

    def __init__(self, log: Callable[[str], object]) -> None:
        self._log = log
        self._lock = threading.Lock()
        self._recorder: QueuedRecorder | None = None
        self._ending: list[QueuedRecorder] = []
        """Recorders that get no more and may still be writing."""
        self._failure = ""

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
        """Folder of the recording that runs, if one does."""
        return self._recorder.path if self._recorder else None

    def start(self, make: Callable[[], QueuedRecorder]) -> Path:
        """Begin a recording where none runs; return the folder of the one that runs.

        Raises:
            Refusal: it cannot be created.
        """
        with self._lock:
            if self._recorder is None:
                self._recorder, self._failure = make(), ""
            return self._recorder.path

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages, if a recording runs."""
        from dcrb_ros.recordings.recorder import RecordingFailed

        with self._lock:
            if self._recorder is None:
                return
            try:
                self._recorder.write_messages(messages)
            except RecordingFailed as error:
                self._retire()
                self.fail(str(error))

    def stop(self) -> Path | None:
        """Finish the recording that runs, and what is still written of earlier ones; return its folder.

        Who calls waits for the disk, who writes meanwhile does not.
        """
        with self._lock:
            recorder = self._retire()
            ending = tuple(self._ending)
        self._finish(ending)
        return recorder.path if recorder else None

    def _retire(self) -> QueuedRecorder | None:
        """Give the recorder no more, with the lock held; what waits in it is still written."""
        recorder, self._recorder = self._recorder, None
        self._ending = [earlier for earlier in self._ending if earlier.writing]
        if recorder is not None:
            self._ending.append(recorder)
        return recorder

    def _finish(self, ending: Iterable[QueuedRecorder]) -> None:
        """Wait for recorders to end, for all of them together as long as for one."""
        from dcrb_ros.recordings.recorder import RecordingFailed
        from dcrb_ros.recordings.recorder_thread import LAST_WRITE

        latest = time.monotonic() + LAST_WRITE
        for recorder in ending:
            try:
                recorder.close(max(0.0, latest - time.monotonic()))
            except RecordingFailed as error:
                self.fail(str(error))

    def fail(self, why: str) -> None:
        """Say why nothing is recorded that should be."""
        if self._recorder is None:
            self._failure = why
        self._log(why)
