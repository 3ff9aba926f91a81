"""Help texts that are printed literally, also those of shell completion: a unit in brackets is not read as markup."""

from __future__ import annotations

import copy
from typing import Any, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup

Part = TypeVar("Part")


def _literal(part: Part) -> Part:
    """Return a command or parameter whose help text rich prints as it is."""
    from rich.markup import escape

    shown: Any = copy.copy(part)
    shown.help = escape(shown.help) if getattr(shown, "help", None) else None
    shown.params = [_literal(parameter) for parameter in getattr(shown, "params", ())]
    shown.commands = {name: _literal(command) for name, command in getattr(shown, "commands", {}).items()}
    return shown  # type: ignore[no-any-return]


class LiteralCommand(TyperCommand):
    """A command whose help text is printed literally."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        TyperCommand.format_help(_literal(self), ctx, formatter)

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        return TyperCommand.shell_complete(_literal(self), ctx, incomplete)


class LiteralGroup(TyperGroup):
    """A group of commands whose help texts are printed literally."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        TyperGroup.format_help(_literal(self), ctx, formatter)

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        return TyperGroup.shell_complete(_literal(self), ctx, incomplete)


class Commands(typer.Typer):
    """A group of commands; its help and that of its commands are printed literally."""

    def __init__(self, *, cls: type[LiteralGroup] = LiteralGroup, **options: Any) -> None:
        super().__init__(cls=cls, no_args_is_help=True, **options)

    def command(self, name: str | None = None, **options: Any) -> Any:
        """Return the decorator that adds a command, see `typer.Typer.command`."""
        return super().command(name, cls=LiteralCommand, **options)
