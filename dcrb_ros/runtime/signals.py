"""Signals that ask a process to end: at once while it starts, as `KeyboardInterrupt` while a command works, without effect once it ends.

Until a program handles signals, one ends it with a traceback. Therefore this module imports only what the interpreter has imported anyway.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType
    from typing import Any, NoReturn

TERMINATION = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Ctrl-C, a cancelled CI job, a closed terminal."""
STOPPED = 130
"""Exit status of a command stopped by the user."""
RETRY_TIME = 0.05
"""Wall time after which a signal that could not be handled is delivered again [s]."""
IMPORT = "<frozen importlib._bootstrap>"
"""File name in the frames of an import."""


def restore_ignored_signals() -> None:
    """Stop ignoring SIGINT, which a shell lets processes in the background ignore, and SIGTERM. An ignored SIGHUP stays so (``nohup``)."""
    for number in TERMINATION:
        if signal.getsignal(number) is signal.SIG_IGN and number.name != "SIGHUP":
            signal.signal(number, signal.SIG_DFL)


def handle_termination(handler: Callable[[int, FrameType | None], Any]) -> None:
    """Call ``handler`` on every termination signal that is not ignored."""
    for number in TERMINATION:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def end_at_once(status: int, sentence: str = "") -> None:
    """From now on, end the process on a termination signal with a status and a sentence: for its start, when there is nothing to finish."""

    def end(number: int, frame: FrameType | None) -> None:
        if sentence:
            _write_error(f"{sentence}\n")
        os._exit(status)

    handle_termination(end)


def accept_termination() -> None:
    """Deliver termination signals that the parent process has blocked, on systems that can block signals."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, TERMINATION)


def interrupt() -> None:
    """From now on, raise `KeyboardInterrupt` on a termination signal, but not where it would be lost: in an import or in a destructor."""
    handle_termination(_interrupt)
    sys.unraisablehook = _deliver_again


class Uninterrupted:
    """Context that the first termination signal does not interrupt, as it would leave half a message: it takes effect at the end."""

    active: Uninterrupted | None = None
    """The context that the main thread is in."""

    def __enter__(self) -> None:
        self.number = 0
        Uninterrupted.active = self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        Uninterrupted.active = None
        if self.number and kind is None:
            _interrupt(self.number, None)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if Uninterrupted.active is not None and not Uninterrupted.active.number:
        Uninterrupted.active.number = number
    elif _importing(frame):  # an exception in an import may be swallowed, or leave half a module behind
        _deliver_later(number)
    else:
        sys.unraisablehook = _deliver_again_in_silence
        raise KeyboardInterrupt


def _importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename == IMPORT:
            return True
        frame = frame.f_back
    return False


def _deliver_again(unraisable: sys.UnraisableHookArgs) -> None:
    """Deliver an interrupt again that a destructor or a callback of a C library has swallowed; report other exceptions as usual."""
    if isinstance(unraisable.exc_value, KeyboardInterrupt):
        _deliver_later(signal.SIGINT)
    else:
        sys.__unraisablehook__(unraisable)


def _deliver_again_in_silence(unraisable: sys.UnraisableHookArgs) -> None:
    """Deliver a swallowed interrupt again; report nothing else, such as the destructor of an object that an interrupt left half made."""
    if isinstance(unraisable.exc_value, KeyboardInterrupt):
        _deliver_later(signal.SIGINT)


def _deliver_later(number: int) -> None:
    """Deliver a signal after `RETRY_TIME`."""
    import threading

    retry = threading.Timer(RETRY_TIME, os.kill, (os.getpid(), number))
    retry.daemon = True
    retry.start()


def leave(status: int) -> NoReturn:
    """Exit with a status. A further signal ends the process at once with this status, and has no effect on the last steps of the exit."""
    _flush()
    end_at_once(status)
    # Python restores the default action of handlers at the end, but ignored signals stay ignored.
    atexit.register(ignore_termination)
    sys.exit(status)


def ignore_termination() -> None:
    """From now on, ignore termination signals."""
    for number in TERMINATION:
        signal.signal(number, signal.SIG_IGN)


def leave_at_once(status: int) -> NoReturn:
    """End the process with a status, but not the interpreter: that takes long after `rclpy`, and may fail during a compilation."""
    ignore_termination()
    _flush()
    os._exit(status)


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):  # nobody reads any more
            continue


def _write_error(text: str) -> None:
    try:
        os.write(2, text.encode())
    except OSError:  # nobody reads any more
        return
