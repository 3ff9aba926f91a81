"""Events as text, as the ground truth and the manifest of a recording contain them.

The format is part of every recording, old and new: extend it, but do not change it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from typing import Any

from dcrb_ros.stream.events import (
    BlockLost,
    Event,
    LoadCommand,
    ParameterChange,
    Refused,
    ScenarioEvent,
    SpeedCommand,
    Start,
    TimedCommand,
    UnknownCommand,
)

LITERAL = r"""(?:'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"|[-+.\w]+)"""
"""A number, a truth value or a string as Python prints them."""
PAIR = rf"[\w.]+ = {LITERAL}"
CHANGES = rf"(?:{PAIR}(?:, {PAIR})*)?"
EACH_PAIR = re.compile(rf"([\w.]+) = ({LITERAL})")

SPEED = re.compile(r"command/speed (\S+) rad/s")
LOAD = re.compile(r"command/load (\S+) (\S+) N")
CHANGE = re.compile(CHANGES)
SCENARIO = re.compile(rf"scenario: ({CHANGES})(?: over (\S+) s begins)?")
REFUSED = re.compile(rf"refused: ((?:scenario: )?{CHANGES}(?: over \S+ s begins)?): (.*)", re.DOTALL)
LOST = re.compile(r"lost: samples (\d+) \.\. (\d+)")


def encode_event(event: Event | None) -> str:
    """Return an event as text, the empty string for none; the duration of a change keeps six significant digits."""
    match event:
        case None:
            return ""
        case Start():
            return "start"
        case SpeedCommand(speed):
            return f"command/speed {speed!r} rad/s"
        case LoadCommand(x, y):
            return f"command/load {x!r} {y!r} N"
        case ParameterChange(changes):
            return _encode_changes(changes)
        case ScenarioEvent(changes, over):
            return f"scenario: {_encode_changes(changes)}" + (f" over {over:g} s begins" if over else "")
        case Refused(request, reason):
            return f"refused: {encode_event(request)}: {reason}"
        case BlockLost(first, last):
            return f"lost: samples {first} .. {last}"
        case UnknownCommand(text):
            return text


def decode_event(text: str) -> Event | None:
    """Return the event that `encode_event` wrote, none for the empty string; any other text is an `UnknownCommand`."""
    try:
        return _decode(text)
    except (SyntaxError, ValueError):
        return UnknownCommand(text)


def _decode(text: str) -> Event | None:
    if not text:
        return None
    if text == "start":
        return Start()
    if found := SPEED.fullmatch(text):
        return SpeedCommand(float(found[1]))
    if found := LOAD.fullmatch(text):
        return LoadCommand(float(found[1]), float(found[2]))
    if found := LOST.fullmatch(text):
        return BlockLost(int(found[1]), int(found[2]))
    if found := SCENARIO.fullmatch(text):
        return ScenarioEvent(_decode_changes(found[1]), float(found[2] or 0.0))
    if (found := REFUSED.fullmatch(text)) and isinstance(request := _decode(found[1]), ParameterChange | ScenarioEvent):
        return Refused(request, found[2])
    if CHANGE.fullmatch(text):
        return ParameterChange(_decode_changes(text))
    return UnknownCommand(text)


def _encode_changes(changes: Mapping[str, Any]) -> str:
    """Return changes of parameters as text: ``faults.outer_1.width = 0.002, faults.outer_1.row = 1``."""
    return ", ".join(f"{key} = {value!r}" for key, value in changes.items())


def _decode_changes(text: str) -> dict[str, Any]:
    return {key: ast.literal_eval(value) for key, value in EACH_PAIR.findall(text)}


def encode_command(command: TimedCommand) -> dict[str, Any]:
    """Return a command as the manifest contains it."""
    return {"time_ns": command.time_ns, "command": encode_event(command.command)}


def decode_command(entry: Mapping[str, Any]) -> TimedCommand:
    """Return the command that `encode_command` wrote.

    Raises:
        KeyError, TypeError, ValueError: the entry is damaged or not a command.
    """
    event = decode_event(str(entry["command"]))
    if not isinstance(event, SpeedCommand | LoadCommand | ParameterChange | UnknownCommand):
        raise ValueError(f"{entry['command']!r} is not a command")
    return TimedCommand(int(entry["time_ns"]), event)
