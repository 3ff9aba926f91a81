"""Events of a run: commands, changes of parameters, steps of a scenario, lost blocks.

They are data everywhere in the program. `dcrb_ros.stream.event_text` turns them into text where they leave it (ground truth, manifest)
and back.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

from dcrb_ros.schema.refusal import Refusal


@dataclass(frozen=True)
class Start:
    """The run starts."""


@dataclass(frozen=True)
class SpeedCommand:
    """A command for the speed of the inner ring."""

    speed: float
    """Target speed [rad/s], reached with the configured ramp."""


@dataclass(frozen=True)
class LoadCommand:
    """A command for the force on the inner ring."""

    x: float
    """Target force in X [N], reached with the configured ramp."""
    y: float
    """Target force in Y [N], negative downwards."""


@dataclass(frozen=True)
class ParameterChange:
    """A change of parameters while the simulation runs, such as a new defect or another sensor range."""

    changes: Mapping[str, Any]
    """Dotted keys and their new values."""


@dataclass(frozen=True)
class ScenarioEvent:
    """An entry of the scenario takes effect, or its gradual change begins."""

    changes: Mapping[str, Any]
    """Dotted keys and their values at the end of the change."""
    over: float = 0.0
    """Simulated time the change takes from now on [s]; 0 if it is complete."""


@dataclass(frozen=True)
class Refused:
    """A change that was valid when it was requested and conflicts with what changed since; it has no effect."""

    request: ParameterChange | ScenarioEvent
    reason: str


@dataclass(frozen=True)
class BlockLost:
    """A block of samples is lost in transmission."""

    first: int
    """Index of its first sample."""
    last: int
    """Index of its last sample."""


@dataclass(frozen=True)
class UnknownCommand:
    """A command in a recording that this version does not know."""

    text: str


Command: TypeAlias = SpeedCommand | LoadCommand | ParameterChange
Event: TypeAlias = Start | Command | ScenarioEvent | Refused | BlockLost | UnknownCommand


class Commandable(Protocol):
    """Accepts commands; `dcrb_ros.simulation.loop.Simulation` does."""

    @property
    def time_ns(self) -> int:
        """Simulated time at which the next command takes effect [ns]."""

    def command_speed(self, speed: float) -> None:
        """Set the target speed [rad/s]."""

    def command_load(self, x: float, y: float) -> None:
        """Set the target force in X and Y [N]."""

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change parameters."""


@dataclass(frozen=True)
class TimedCommand:
    """A command and the simulated time at which it took effect."""

    time_ns: int
    """Simulated time [ns]."""
    command: Command | UnknownCommand

    def apply(self, simulation: Commandable) -> None:
        """Pass the command to a simulation.

        Raises:
            Refusal: this version does not know the command.
        """
        match self.command:
            case SpeedCommand(speed):
                simulation.command_speed(speed)
            case LoadCommand(x, y):
                simulation.command_load(x, y)
            case ParameterChange(changes):
                simulation.change(changes)
            case UnknownCommand(text):
                raise Refusal(
                    f"the recording has the command '{text}' at {self.time_ns * 1e-9:g} s, which this version does not know: "
                    "reproduce it with the version that made it"
                )


class CommandSchedule:
    """Commands to be repeated at their simulated times."""

    def __init__(self, commands: Iterable[TimedCommand]) -> None:
        self._pending = deque(sorted(commands, key=lambda command: command.time_ns))

    def apply_due(self, simulation: Commandable) -> None:
        """Pass all commands that are due to the simulation; call it between two blocks."""
        while self._pending and self._pending[0].time_ns <= simulation.time_ns:
            self._pending.popleft().apply(simulation)
