"""The announcement of a compilation: made when a kernel is really compiled, not guessed from the files of the cache.

A kernel is compiled again for another path of the sources, another processor, touched sources, or laws with arguments of other types.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from numba.core import event

SENTENCE = "compiling the kernels for this machine (once, 15 s to over a minute) ..."
"""What a program says when it is started for the first time; 14 to 66 s were measured on two cores."""


class _Announcement(event.Listener):
    """Says the sentence at the first compilation after `announce_compilation`."""

    def __init__(self) -> None:
        self.say: Callable[[str], object] | None = None
        self._lock = threading.Lock()

    def on_start(self, event: Any) -> None:
        with self._lock:
            say, self.say = self.say, None
        if say is not None:
            say(SENTENCE)

    def on_end(self, event: Any) -> None:
        """Do nothing."""


_announcement = _Announcement()
event.register("numba:compile", _announcement)  # type: ignore[no-untyped-call]


def announce_compilation(say: Callable[[str], object]) -> None:
    """Call ``say`` with a sentence when the first kernel is compiled in this process from now on; it replaces an earlier ``say``."""
    _announcement.say = say
