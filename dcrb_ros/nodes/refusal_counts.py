"""Refusals of a running node: all are counted, and logged less and less often."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from dcrb_ros.schema import printable
from dcrb_ros.schema.refusal import Refusal

MAX_LENGTH = 400
"""Longest refusal that is logged or answered [characters]: it contains the refused value, which may be long."""


def shortened(sentence: str) -> str:
    """Return a sentence of at most `MAX_LENGTH` characters."""
    return printable.shortened(sentence, MAX_LENGTH)


class Refusals:
    """Counts refusals by kind; the first, the tenth, the hundredth and so on of each kind is logged."""

    def __init__(self, log: Callable[[str], object]) -> None:
        self._log = log
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()

    def count(self, *kinds: str) -> int:
        """Return the number of refusals of some kinds."""
        return sum(self._counts[kind] for kind in kinds)

    def note(self, kind: str, sentence: str) -> None:
        """Count a refusal, and log it if it is due."""
        with self._lock:
            self._counts[kind] += 1
            count = self._counts[kind]
        if count == 10 ** (len(str(count)) - 1):
            self._log(shortened(sentence) + (f" ({count} refusals so far)" if count > 1 else ""))

    @contextmanager
    def counted(self, kind: str) -> Iterator[None]:
        """Count a refusal raised in the context, and raise it again."""
        try:
            yield
        except Refusal as refusal:
            self.note(kind, str(refusal))
            raise

    @contextmanager
    def suppressed(self, kind: str) -> Iterator[None]:
        """Count a refusal raised in the context, and suppress it."""
        with suppress(Refusal), self.counted(kind):
            yield
