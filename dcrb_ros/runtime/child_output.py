"""The output of a child process, of which the end is kept."""

from __future__ import annotations

import os
from collections.abc import Callable

from dcrb_ros.runtime.threads import NamedThread
from dcrb_ros.schema.printable import printable, shortened

KEPT = 20_000
"""Bytes at the end of the output that are kept."""
SHOWN_LINES, SHOWN_LENGTH = 6, 200
"""Lines of it that are shown, and characters of each at most."""
PATIENCE = 1.0
"""Time in which the rest of the output is read after the process has ended [s]."""


class ChildOutput:
    """Reads a pipe in a thread; it takes no more memory than it shows."""

    def __init__(self, most: int, on_excess: Callable[[], None]) -> None:
        """Make the pipe; after ``most`` bytes since the last `restart`, ``on_excess`` is called once."""
        self._reading, self.writing = os.pipe()
        """Ends of the pipe; ``writing`` is for the child, and closed here by `begin`."""
        self._most, self._on_excess = most, on_excess
        self._end, self._size = b"", 0
        self.excessive = False
        """Whether there was more than the limit."""
        self._thread = NamedThread("output", self._read)

    def begin(self) -> None:
        """Start reading, after the child has started."""
        os.close(self.writing)
        self._thread.start()

    def restart(self) -> None:
        """Count from here."""
        self._end, self._size = b"", 0

    def last_lines(self) -> str:
        """Return the end of the output as the end of a sentence; the empty string if there was none."""
        lines = self._lines()
        return "; its last output:\n" + "\n".join(f"    {line}" for line in lines) if lines else ""

    def last_line(self) -> str:
        """Return the last line of the output as the end of a sentence in one line; the empty string if there was none."""
        lines = self._lines()
        return f"; its last output is '{lines[-1].strip()}'" if lines else ""

    def _lines(self) -> list[str]:
        self._thread.join(PATIENCE)
        lines = [printable(line) for line in self._end.decode(errors="replace").splitlines() if line.strip()]
        return [shortened(line, SHOWN_LENGTH) for line in lines[-SHOWN_LINES:]]

    def _read(self) -> None:
        with os.fdopen(self._reading, "rb", buffering=0) as stream:
            while chunk := stream.read(1 << 16):
                self._end = (self._end + chunk)[-KEPT:]
                self._size += len(chunk)
                if self._size > self._most and not self.excessive:
                    self.excessive = True
                    self._on_excess()
