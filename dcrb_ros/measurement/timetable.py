"""Changes at exact ticks of a clock, met while the time goes by in stretches of any length."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

Change = TypeVar("Change")


class Timetable(Generic[Change]):
    """Changes that wait for their tick, and the tick that has been reached."""

    def __init__(self, meet: Callable[[Change], None]) -> None:
        """Begin at tick 0; ``meet`` carries a change out."""
        self._meet = meet
        self._waiting: deque[tuple[int, Change]] = deque()
        self.reached = 0

    def add(self, tick: int, change: Change) -> None:
        """Let a change wait for a tick, which must not lie before an earlier change's."""
        self._waiting.append((tick, change))

    def due(self, count: int) -> bool:
        """Return whether a change falls into the next ``count`` ticks."""
        return bool(self._waiting) and self._waiting[0][0] < self.reached + count

    def pieces(self, count: int) -> Iterator[slice]:
        """Yield the next ``count`` ticks in pieces; every change is carried out before the piece at its tick."""
        begin = 0
        while begin < count:
            while self._waiting and self._waiting[0][0] <= self.reached:
                self._meet(self._waiting.popleft()[1])
            end = min(count, begin + self._waiting[0][0] - self.reached) if self._waiting else count
            yield slice(begin, end)
            self.reached += end - begin
            begin = end
