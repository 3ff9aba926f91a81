"""Commands that print their help texts literally, also in shell completion, and check what is given before they run.

A unit in brackets is not read as markup. An option of one value is taken once, and an empty path is refused.
"""

from __future__ import annotations

import copy
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup

from dcrb_ros.schema.refusal import Refusal

Part = TypeVar("Part")


def _literal(part: Part) -> Part:
    """Return a command or parameter whose help text rich prints as it is."""
    from rich.markup import escape

    shown: Any = copy.copy(part)
    shown.help = escape(shown.help) if getattr(shown, "help", None) else None
    shown.params = [_literal(parameter) for parameter in getattr(shown, "params", ())]
    shown.commands = {name: _literal(command) for name, command in getattr(shown, "commands", {}).items()}
    return shown  # type: ignore[no-any-return]


class _LiteralHelp:
    """Prints help texts literally."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        super(_LiteralHelp, _literal(self)).format_help(ctx, formatter)  # type: ignore[misc]

    def shell_complete(self, ctx: Any, incomplete: str) -> Any:
        return super(_LiteralHelp, _literal(self)).shell_complete(ctx, incomplete)  # type: ignore[misc]


class LiteralCommand(_LiteralHelp, TyperCommand):
    """A command whose help text is printed literally, and which refuses an option of one value that is given twice, and an empty path."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments; of an option that is given twice, click would take the last value without a word.

        Raises:
            Refusal: an option of one value is given more than once, or a path is empty, which would be the current folder.
        """
        if ctx.resilient_parsing:
            return TyperCommand.parse_args(self, ctx, args)
        given, _, order = self.make_parser(ctx).parse_args(args=list(args))
        twice = next((option for option, count in Counter(order).items() if count > 1 and _has_one_value(option)), None)
        if twice is not None:
            raise Refusal(f"{_longest_name(twice)} is given more than once, but has one value: give it once")
        try:
            rest = TyperCommand.parse_args(self, ctx, args)
        except Exception as error:
            _name_value(error, given)
            raise
        for parameter in self.params:
            value = given.get(parameter.name)
            paths = value if isinstance(value, (list, tuple)) and parameter.param_type_name == "argument" else ()
            of_path = isinstance(ctx.params.get(parameter.name), Path) or "--output" in parameter.opts  # which may be an address
            if "" in paths or (of_path and value == ""):
                otherwise = "" if parameter.required else ", or leave it out"
                raise Refusal(f"{_longest_name(parameter)} is empty: give a path, such as . for this folder{otherwise}")
        return rest


def _has_one_value(parameter: Any) -> bool:
    """Return whether a parameter is an option whose later value replaces an earlier one; a flag that cannot be unset has no value."""
    option = parameter.param_type_name == "option" and not parameter.multiple and not parameter.count
    return option and (not parameter.is_flag or bool(parameter.secondary_opts))


def _longest_name(parameter: Any) -> str:
    """Return the longest name of an option, such as ``--output``, or the word for an argument in the usage, such as ``BAG``."""
    if parameter.param_type_name == "argument":
        return str(parameter.metavar or parameter.name.upper()).rstrip(" .")
    return str(max(parameter.opts, key=len))


def _name_value(error: Any, given: Mapping[str, Any]) -> None:
    """Put the value of an option into the message of an error about it, where the release of typer leaves it out."""
    value = given.get(getattr(getattr(error, "param", None), "name", None) or "")
    message = getattr(error, "message", "")
    if isinstance(value, str) and message and not message.startswith(value) and repr(value) not in message:
        error.message = f"{value!r}; {message[:1].lower()}{message[1:]}"


class LiteralGroup(_LiteralHelp, TyperGroup):
    """A group of commands whose help texts are printed literally."""


class Commands(typer.Typer):
    """A group of commands; its help and that of its commands are printed literally."""

    def __init__(self, *, cls: type[LiteralGroup] = LiteralGroup, **options: Any) -> None:
        super().__init__(cls=cls, no_args_is_help=True, **options)

    def __call__(self, *args: Any, **options: Any) -> Any:
        """Run the command line. Of the commands, the one that is called is prepared; typer takes 0.06 s for all of them."""
        called, name = copy.copy(self), sys.argv[1:2]
        called.registered_commands = [command for command in self.registered_commands if [command.name] == name]
        called.registered_groups = [group for group in self.registered_groups if [group.name] == name]
        known = called.registered_commands or called.registered_groups
        return typer.Typer.__call__(called if known else self, *args, **options)

    def command(self, name: str | None = None, **options: Any) -> Any:
        """Return the decorator that adds a command, see `typer.Typer.command`."""
        return super().command(name, cls=LiteralCommand, **options)
