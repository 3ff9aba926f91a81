"""Refusals of a running node: each counted, explained once and then ever more rarely."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from dcrb_ros.runtime.refusal import Refusal

LONGEST_SENTENCE = 400
"""Longest refusal that is logged or answered [characters]; what was sent may be long and stands in it."""


def shortened(sentence: str) -> str:
    """Return a sentence of at most `LONGEST_SENTENCE` characters."""
    return sentence if len(sentence) <= LONGEST_SENTENCE else f"{sentence[: LONGEST_SENTENCE - 4]} ..."


class Refusals:
    """Counts by kind. The first, tenth, hundredth refusal of a kind and so on is logged, the others are only counted."""

    def __init__(self, log: Callable[[str], object]) -> None:
        self._log = log
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()

    def count(self, *kinds: str) -> int:
        """Return the refusals of some kinds so far."""
        return sum(self._counts[kind] for kind in kinds)

    def note(self, kind: str, sentence: str) -> None:
        """Count a refusal, and perhaps log it."""
        with self._lock:
            self._counts[kind] += 1
            count = self._counts[kind]
        if count == 10 ** (len(str(count)) - 1):
            self._log(shortened(sentence) + (f" ({count} refusals so far)" if count > 1 else ""))

    @contextmanager
    def counted(self, kind: str) -> Iterator[None]:
        """Note a refusal of what happens within, and let it through."""
        try:
            yield
        except Refusal as refusal:
            self.note(kind, str(refusal))
            raise

    @contextmanager
    def of(self, kind: str) -> Iterator[None]:
        """Note a refusal of what happens within, and go on."""
        try:
            yield
        except Refusal as refusal:
            self.note(kind, str(refusal))
