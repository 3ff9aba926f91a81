"""The announcement of a compilation: made when a kernel is really compiled, not guessed from the files of the cache.

A kernel is compiled again for another path of the sources, another processor, touched sources, or laws with arguments of other types.
Bearings with other laws have kernels of their own, so each set is announced with its laws.
"""

from __future__ import annotations

import hashlib
import os
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from numba.core import event

from dcrb_ros.core import CACHE

SENTENCE = "compiling the kernels for this machine (once, 15 s to over a minute) ..."
"""What a program says before the laws are known; 14 to 66 s were measured on two cores, 150 s while these were busy."""
OF_LAWS = "compiling the kernels for the laws {laws} (once on this machine, 15 s to some minutes) ..."
WORKERS = "DCRB_ROS_ANNOUNCE_COMPILATION"
"""Variable of the environment with which processes started from here announce their compilations on their standard error."""
REPEATED = 600.0
"""Time after which another worker announces the same kernels again [s]."""


class _Announcement(event.Listener):
    """Says a sentence at the first compilation after it was armed."""

    def __init__(self) -> None:
        self.say: Callable[[str], object] | None = None
        self.armed = False
        self.laws = ""
        self._lock = threading.Lock()

    def on_start(self, event: Any) -> None:
        with self._lock:
            armed, self.armed = self.armed, False
        if armed and self.say is not None:
            self.say(OF_LAWS.format(laws=self.laws) if self.laws else SENTENCE)

    def on_end(self, event: Any) -> None:
        """Do nothing."""


_announcement = _Announcement()
event.register("numba:compile", _announcement)  # type: ignore[no-untyped-call]


def announce_compilation(say: Callable[[str], object]) -> None:
    """Call ``say`` with a sentence when a set of kernels is compiled in this process from now on; it replaces an earlier ``say``.

    Workers that are started later write the sentence to their standard error.
    """
    _announcement.say, _announcement.armed, _announcement.laws = say, True, ""
    os.environ[WORKERS] = "1"


def no_announcement() -> None:
    """Announce nothing, also in workers that are started later."""
    _announcement.say = None
    os.environ.pop(WORKERS, None)


def announce_laws(laws: str) -> None:
    """Announce the next compilation as that of the kernels for some laws, unless it was the last to be announced."""
    if _announcement.say is None and WORKERS in os.environ:
        _announcement.say = _say_first
    if laws != _announcement.laws:
        _announcement.laws, _announcement.armed = laws, True


def announce_progress(sentence: str) -> None:
    """Say how far the compilation is that has been announced; workers, of which many compile at once, say nothing."""
    if _announcement.say is not None and _announcement.say is not _say_first and not _announcement.armed:
        _announcement.say(sentence)


def announce_damage(path: str) -> None:
    """Say that a file of the cache is damaged, where compilations are announced."""
    if _announcement.say is not None:
        _announcement.say(f"{path} is damaged: its kernel is compiled again")


def _say_first(sentence: str) -> None:
    """Write a sentence to the standard error, unless another worker has just written it."""
    mark = CACHE / f"announced-{hashlib.sha256(sentence.encode()).hexdigest()[:16]}"
    try:
        os.close(os.open(mark, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        if time.time() - mark.stat().st_mtime < REPEATED:
            return
        mark.touch()
    print(sentence, file=sys.stderr, flush=True)
