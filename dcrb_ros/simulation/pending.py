"""Commands and changes of parameters that wait for the next block."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.events import Command, ParameterChange

MAX_PENDING = 1000
"""Commands that may wait for the next block."""

Alter = Callable[[Mapping[str, Any], Configuration | None], Configuration]
"""Returns a configuration, the present one for None, with some changes, or refuses them."""


class PendingCommands:
    """Keeps commands from any thread until the next block, which may be far away while the bench is paused."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        """Held while the configuration changes, so that a change is checked against the present one."""
        self.commands: deque[Command] = deque()
        self._after: Configuration | None = None
        """The configuration after the last pending change; None if no change is pending."""

    def add(self, command: Command) -> None:
        """Keep a command.

        Raises
        ------
        Refusal
            Too many commands are pending.
        """
        with self.lock:
            self._check_room()
            self.commands.append(command)

    def add_change(self, changes: Mapping[str, Any], alter: Alter) -> None:
        """Keep a change of parameters; see `check_change`."""
        with self.lock:
            self._after = self._check_change(changes, alter)
            self.commands.append(ParameterChange(changes))

    def check_change(self, changes: Mapping[str, Any], alter: Alter) -> Configuration:
        """Check a change of parameters after those that are pending, and return the configuration after it.

        Raises
        ------
        Refusal
            ``alter`` refuses the values, or too many commands are pending.
        """
        with self.lock:
            return self._check_change(changes, alter)

    def _check_change(self, changes: Mapping[str, Any], alter: Alter) -> Configuration:
        after = alter(changes, self._after)
        self._check_room()
        return after

    def _check_room(self) -> None:
        if len(self.commands) >= MAX_PENDING:
            raise Refusal(
                f"{MAX_PENDING} commands are already waiting for the next block; this one is refused, send it again once the bench runs"
            )

    def rebase(self, alter: Alter) -> None:
        """Compute the configuration after the pending changes anew, with the lock held: a scenario has changed the present one."""
        self._after = None
        for command in self.commands:
            if isinstance(command, ParameterChange):
                with suppress(Refusal):
                    self._after = alter(command.changes, self._after)

    def apply(self, apply: Callable[[Command], None]) -> None:
        """Remove the commands in order and apply them."""
        with self.lock:
            while self.commands:
                apply(self.commands.popleft())
            self._after = None
