"""Events as text, as the ground truth and the manifest of a recording contain them.

The format is part of every recording, old and new: extend it, but do not change it.
"""

from __future__ import annotations

import ast
import math
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
PAIR = re.compile(rf"([\w.]+) = ({LITERAL})")
OVER = re.compile(r" over (\S+) s begins")
SCENARIO, REFUSED = "scenario: ", "refused: "
CONSTANTS = {"True": True, "False": False, "None": None}

SPEED = re.compile(r"command/speed (\S+) rad/s")
LOAD = re.compile(r"command/load (\S+) (\S+) N")
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
    if match := SPEED.fullmatch(text):
        return SpeedCommand(float(match[1]))
    if match := LOAD.fullmatch(text):
        return LoadCommand(float(match[1]), float(match[2]))
    if match := LOST.fullmatch(text):
        return BlockLost(int(match[1]), int(match[2]))
    if text.startswith(REFUSED):
        request, end = _request(text, len(REFUSED))
        if text.startswith(": ", end) and end > len(REFUSED):
            return Refused(request, text[end + 2 :])
    else:
        request, end = _request(text, 0)
        if end == len(text):
            return request
    return UnknownCommand(text)


def _request(text: str, begin: int) -> tuple[ParameterChange | ScenarioEvent, int]:
    """Return the changes of parameters or of a scenario that begin at a place, and their end, in a time linear in the text."""
    scenario = text.startswith(SCENARIO, begin)
    changes, end = _decode_changes(text, begin + len(SCENARIO) if scenario else begin)
    if not scenario:
        return ParameterChange(changes), end
    over = OVER.match(text, end)
    return ScenarioEvent(changes, float(over[1]) if over else 0.0), over.end() if over else end


def _encode_changes(changes: Mapping[str, Any]) -> str:
    """Return changes of parameters as text: ``faults.outer_1.width = 0.002, faults.outer_1.row = 1``."""
    return ", ".join(f"{key} = {value!r}" for key, value in changes.items())


def _decode_changes(text: str, begin: int) -> tuple[dict[str, Any], int]:
    """Return the changes that begin at a place, and their end."""
    changes: dict[str, Any] = {}
    end = begin
    while pair := PAIR.match(text, end + 2 if changes else end):
        changes[pair[1]] = _literal(pair[2])
        end = pair.end()
        if not text.startswith(", ", end):
            break
    return changes, end


def _literal(text: str) -> Any:
    """Return the number, truth value or string that Python prints as ``text``."""
    if text in CONSTANTS:
        return CONSTANTS[text]
    value = ast.literal_eval(text) if text[0] in "'\"" else int(text) if text.lstrip("-").isdecimal() else float(text)
    if repr(value) != text or value in (math.inf, -math.inf):
        raise ValueError(f"{text[:40]} is not as Python prints it")
    return value


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
