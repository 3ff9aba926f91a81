"""The standard outputs: errors of writing them name them, and what nobody reads is discarded."""

from __future__ import annotations

import io
import os
import sys
from typing import IO, Any

NAME = "the standard output"
NAMES = {1: NAME, 2: "the standard error output"}
"""Names of the standard outputs by their file descriptors."""


class _StandardOutput(io.FileIO):
    """The file of a standard output; the operating system's errors in writing it have no file name."""

    def write(self, data: Any, /) -> int:
        """Write bytes and return how many were written; without a reader they are discarded, since the command may have more to do."""
        try:
            return super().write(data)
        except BrokenPipeError:
            discard(self)
            return len(data)
        except OSError as error:
            error.filename = NAMES[self.fileno()]
            raise


def prepare_standard_output() -> None:
    """Name the standard outputs in the errors of writing them, and escape the characters that their encodings do not have.

    Those of ``LC_ALL=C`` are all but ASCII. An output that is not a file of this process, as in a notebook or a test, keeps its errors.
    What is printed to a closed one, or to a pipe whose reader has left, is discarded.
    """
    _open_closed_streams()
    for number, name in ((1, "stdout"), (2, "stderr")):
        stream = getattr(sys, name)
        if not isinstance(stream, io.TextIOWrapper):
            continue
        raw = getattr(stream.buffer, "raw", stream.buffer)
        if isinstance(raw, io.FileIO) and raw.fileno() == number:
            stream.flush()
            file = _StandardOutput(number, "w", closefd=False)
            buffer: Any = file if raw is stream.buffer else io.BufferedWriter(file)  # PYTHONUNBUFFERED
            stream = io.TextIOWrapper(buffer, stream.encoding, line_buffering=stream.line_buffering, write_through=stream.write_through)
            setattr(sys, name, stream)
        stream.reconfigure(errors="backslashreplace")


def _open_closed_streams() -> None:
    """Open the null device for each standard stream that is closed, as by ``>&-``.

    Python has None for such a stream, and the next file that is opened would take its number.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode, encoding="utf-8", closefd=False))


def discard(stream: IO[Any]) -> None:
    """Discard the later output of a stream and the rest of its buffer, which would fail again at the exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
