"""Commands as a recording keeps them: what was asked for, and the simulated time from which it counted."""

from __future__ import annotations

import ast
import re
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from dcrb_ros.runtime.refusal import Refusal

WORDS = re.compile(r"(command/speed) (\S+) rad/s|(command/load) (\S+) (\S+) N")
CHANGE = re.compile(r"([\w.]+) = (.*?)(?:, (?=[\w.]+ = )|$)")
"""A parameter and its value, as `dcrb_ros.bearing.runtime_change.spoken` says a change."""
ASIDE = ("start", "scenario:", "refused:", "lost:")
"""How what is no command begins: the start, what a scenario does by itself, what was refused, and a block that was lost."""


class Commanded(Protocol):
    """What takes commands: the simulation."""

    @property
    def time_ns(self) -> int:
        """Simulated time at which the next command takes effect [ns]."""

    def command_speed(self, speed: float) -> None:
        """Ask for a speed [rad/s]."""

    def command_load(self, x: float, y: float) -> None:
        """Ask for a force in X and Y [N]."""

    def change(self, changes: Mapping[str, Any]) -> None:
        """Ask for other faults or another sensor."""


@dataclass(frozen=True)
class Command:
    """A command that took effect."""

    time_ns: int
    """Simulated time from which it counted [ns]."""
    words: str
    """As the ground truth says it: ``command/speed 130.0 rad/s``."""

    def obey(self, simulation: Commanded) -> None:
        """Give it to a simulation.

        Raises:
            Refusal: it is of a kind that this version does not know.
        """
        found, changes = WORDS.fullmatch(self.words), changes_of(self.words)
        if changes:
            simulation.change(changes)
        elif found is None:
            raise Refusal(f"the recording has the command '{self.words}' at {self.time_ns * 1e-9:g} s, which cannot be repeated")
        elif found[1]:
            simulation.command_speed(float(found[2]))
        else:
            simulation.command_load(float(found[4]), float(found[5]))

    def described(self) -> dict[str, Any]:
        """Return it for the manifest."""
        return {"time_ns": self.time_ns, "command": self.words}


def command_of(time_ns: int, changed: str) -> Command | None:
    """Return the command that a ground truth of ``time_ns`` [ns] tells by ``changed``; none for a repetition or what stands in `ASIDE`."""
    return Command(time_ns, changed) if changed and not changed.startswith(ASIDE) else None


def changes_of(words: str) -> dict[str, Any]:
    """Return the parameters and values of a change as the ground truth says it; nothing for anything else."""
    pairs = CHANGE.findall(words)
    if not pairs or ", ".join(f"{key} = {value}" for key, value in pairs) != words:
        return {}
    try:
        return {key: ast.literal_eval(value) for key, value in pairs}
    except (SyntaxError, ValueError):
        return {}


class Agenda:
    """Commands that wait for their time."""

    def __init__(self, commands: Iterable[Command]) -> None:
        self._waiting = deque(sorted(commands, key=lambda command: command.time_ns))

    def give(self, simulation: Commanded) -> None:
        """Give the simulation, between two blocks, what is due."""
        while self._waiting and self._waiting[0].time_ns <= simulation.time_ns:
            self._waiting.popleft().obey(simulation)

    @property
    def left(self) -> int:
        """Commands whose time has not come."""
        return len(self._waiting)
