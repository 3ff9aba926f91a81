"""The standard output with a file name, which appears in errors of writing it."""

from __future__ import annotations

import io
import os
import sys
from typing import Any, TextIO

NAME = "the standard output"


class _StandardOutput(io.FileIO):
    """The file of the standard output; the operating system's errors in writing it have no file name."""

    def write(self, data: Any, /) -> int:
        """Write bytes and return how many were written."""
        try:
            return super().write(data)
        except OSError as error:
            error.filename = NAME
            raise


def prepare_standard_output() -> None:
    """Name the standard output in the errors of writing it, and escape the characters that its encoding does not have.

    Those of ``LC_ALL=C`` are all but ASCII. An output that is not a file of this process, as in a notebook or a test, keeps its errors.
    What is printed to a closed one is discarded.
    """
    _open_closed_streams()
    output = sys.stdout
    raw = getattr(output.buffer, "raw", output.buffer) if isinstance(output, io.TextIOWrapper) else None
    if isinstance(output, io.TextIOWrapper) and isinstance(raw, io.FileIO) and raw.fileno() == 1:
        output.flush()
        file = _StandardOutput(1, "w", closefd=False)
        sys.stdout = io.TextIOWrapper(
            io.BufferedWriter(file), output.encoding, line_buffering=output.line_buffering, write_through=output.write_through
        )
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _open_closed_streams() -> None:
    """Open the null device for each standard stream that is closed, as by ``>&-``.

    Python has None for such a stream, and the next file that is opened would take its number.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode, encoding="utf-8", closefd=False))


def discard(stream: TextIO) -> None:
    """Discard the later output of a stream and the rest of its buffer, which would fail again at the exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
