"""Exit status and error message of the command line and the nodes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any

import typer

from dcrb_ros.runtime.signals import STOPPED
from dcrb_ros.runtime.standard_output import NAME, discard, prepare_standard_output
from dcrb_ros.schema.printable import printable_lines
from dcrb_ros.schema.refusal import Refusal


def print_error(program: str, sentence: str) -> None:
    """Print a sentence to the standard error output; control characters are escaped."""
    print(printable_lines(f"{program}: {sentence}"), file=sys.stderr)


def exit_status(program: str, command: Callable[[], Any]) -> int:
    """Run a command and return its exit status: 0 success, 1 failure, 2 wrong usage or input, 130 stopped.

    Any error is printed as one sentence. With the environment variable DCRB_DEBUG=1 it is raised instead.
    """
    prepare_standard_output()
    if os.environ.get("DCRB_DEBUG") == "1":
        return _status(command())
    try:
        status = _status(command())
        sys.stdout.flush()
        return status
    except Refusal as refusal:
        _report(program, str(refusal))
        return 2
    except typer.Exit as end:
        return int(end.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        _report(program, "stopped")
        return STOPPED
    except Exception as error:
        # Typer's usage errors: their class depends on the release, their method does not.
        explain = getattr(error, "format_message", None)
        if explain is not None:
            _report(program, f"{explain() or 'a command is missing'} (try --help)")
            return 2
        where = "" if isinstance(error, RuntimeError) else " (DCRB_DEBUG=1 shows where)"
        if isinstance(error, OSError) and error.filename == NAME:
            discard(sys.stdout)
        _report(program, f"{_explained(error)}{where}")
        return 1


def _report(program: str, sentence: str) -> None:
    """Print the sentence with which a command ends; where it cannot be printed, the exit status remains."""
    try:
        print_error(program, sentence)
    except OSError:
        discard(sys.stderr)


def _explained(error: Exception) -> str:
    """Return an error as a sentence; one of the operating system with the file that it concerns."""
    if isinstance(error, OSError) and error.filename is not None:
        return f"{os.fsdecode(error.filename)} cannot be used: {error.strerror}; make room for it, or give another path"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return str(error) or type(error).__name__


def _status(returned: Any) -> int:
    return returned if isinstance(returned, int) else 0
