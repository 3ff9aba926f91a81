"""Parameter changes at exact ticks, whatever the length of the blocks in which the ticks are processed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

Change = TypeVar("Change")


class ScheduledChanges(Generic[Change]):
    """Changes that wait for their tick."""

    def __init__(self, apply: Callable[[Change, int], None]) -> None:
        """Start at tick 0; ``apply`` is called with a change and its tick."""
        self._apply = apply
        self._waiting: deque[tuple[int, Change]] = deque()
        self.reached = 0
        """Number of ticks processed so far."""

    def add(self, tick: int, change: Change) -> None:
        """Schedule a change at a tick, which must not be before that of an earlier call."""
        self._waiting.append((tick, change))

    def due(self, count: int) -> bool:
        """Return whether a change falls into the next ``count`` ticks."""
        return bool(self._waiting) and self._waiting[0][0] < self.reached + count

    def skip(self, count: int) -> None:
        """Pass over the next ``count`` ticks, in which no change is due."""
        self.reached += count

    def pieces(self, count: int) -> Iterator[slice]:
        """Yield the next ``count`` ticks in pieces; each change is applied before the piece that starts at its tick."""
        begin = 0
        while begin < count:
            while self._waiting and self._waiting[0][0] <= self.reached:
                self._apply(self._waiting.popleft()[1], self.reached)
            end = min(count, begin + self._waiting[0][0] - self.reached) if self._waiting else count
            yield slice(begin, end)
            self.reached += end - begin
            begin = end
