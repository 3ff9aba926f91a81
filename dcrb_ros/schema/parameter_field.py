"""The parameters of a model by their dotted keys, and the sentence with which an invalid value is refused."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from dcrb_ros.schema.refusal import nearest

Scalar = bool | int | float | str
KINDS: dict[Any, str] = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
"""Types of parameters, and how a message names them."""


@dataclass(frozen=True)
class ParameterField:
    """One parameter of the schema."""

    key: str
    """Dotted key, ``faults.outer_1.width``."""
    kind: type
    """bool, int, float or str."""
    default: Scalar
    low: float | int | None
    high: float | int | None
    unit: str
    symbol: str
    description: str
    remedy: str
    run_time: bool
    """Whether it can change while the simulation runs."""
    choices: tuple[str, ...] = ()

    @property
    def limits(self) -> tuple[str, ...]:
        """The ends of the range as text, integers in full; none without a range."""
        return tuple(str(limit) if isinstance(limit, int) else f"{limit:g}" for limit in (self.low, self.high) if limit is not None)


def field_of(key: str, info: FieldInfo) -> ParameterField:
    """Return the parameter of a field of a model."""
    extra: dict[str, Any] = dict(info.json_schema_extra) if isinstance(info.json_schema_extra, dict) else {}
    low = next((m.ge for m in info.metadata if hasattr(m, "ge")), None)
    high = next((m.le for m in info.metadata if hasattr(m, "le")), None)
    choices = tuple(str(choice) for choice in get_args(info.annotation))
    kind = str if choices else info.annotation
    if not isinstance(kind, type):
        raise TypeError(f"{key} has no plain type")
    return ParameterField(
        key,
        kind,
        info.default,
        low,
        high,
        extra.get("unit", "-"),
        extra.get("symbol", ""),
        info.description or "",
        extra.get("remedy", ""),
        extra.get("run_time", False),
        choices,
    )


def more(count: int) -> str:
    """Return how many problems follow the first of ``count``, as text."""
    return f" (and {count - 1} more)" if count > 1 else ""


class Contradictions(ValueError):
    """Values that contradict each other, described by ``sentences``, at least one."""

    def __init__(self, sentences: Sequence[str]) -> None:
        super().__init__(f"{sentences[0]}{more(len(sentences))}")
        self.sentences = sentences


def sentences(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """Return every problem of a model's values as a sentence with the value, the range and the remedy."""
    words: list[str] = []
    for problem in error.errors():
        cause = problem.get("ctx", {}).get("error")
        words += cause.sentences if isinstance(cause, Contradictions) else [_described(problem, model)]
    return words


def sentence(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the first problem of a model's values as a sentence with the value, the range and the remedy."""
    words = sentences(error, model)
    return f"{words[0]}{more(len(words))}"


class Problem(NamedTuple):
    """The first problem of the values in a file, as parts of a sentence: dotted key, reason, and ``" = value"`` unless it is missing."""

    key: str
    reason: str
    value: str


def first_problem(error: ValidationError) -> Problem:
    """Return what is wrong first in a file that has a schema of its own."""
    problem, reason = error.errors()[0], _without_prefix(error.errors()[0])
    value = "" if problem["type"] == "missing" else f" = {problem['input']!r}"
    return Problem(".".join(map(str, problem["loc"])), reason[0].lower() + reason[1:], value)


def _described(problem: ErrorDetails, model: type[BaseModel]) -> str:
    """Return one problem as a sentence."""
    *groups, name = [str(part) for part in problem["loc"]] or [""]
    for group in groups:
        inner = model.model_fields[group].annotation if group in model.model_fields else None
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return _without_prefix(problem)
        model = inner
    key = ".".join((*groups, name))
    if problem["type"] == "extra_forbidden":
        prefix = key.removesuffix(name)
        return f"unknown parameter '{key}'{nearest(key, [prefix + known for known in model.model_fields])}"
    info = model.model_fields.get(name)
    if info is None or not (get_origin(info.annotation) is Literal or info.annotation in KINDS):
        return _without_prefix(problem)
    return _refused(field_of(key, info), problem["input"])


def _without_prefix(problem: ErrorDetails) -> str:
    return problem["msg"].removeprefix("Value error, ")


def wrong_type(field: ParameterField, value: Any) -> str:
    """Return why a value has the wrong type for a parameter, or an empty string."""
    return "" if isinstance(value, field.kind) and isinstance(value, bool) == (field.kind is bool) else _refused(field, value)


def flaw_of(field: ParameterField, value: Any) -> str:
    """Return why a value has the wrong type for a parameter, or is outside its range or choices, or an empty string."""
    if flaw := wrong_type(field, value):
        return flaw
    outside = field.low is not None and field.high is not None and not (isinstance(value, str) or field.low <= value <= field.high)
    return _refused(field, value) if outside or (field.choices and value not in field.choices) else ""


def _refused(field: ParameterField, value: Any) -> str:
    """Return why a value is invalid."""
    said = f"{field.key} = {value!r}" + (f" {field.unit}" if field.unit != "-" else "")
    kind = KINDS[field.kind]
    if field.choices:
        return f"{said} is not one of {', '.join(field.choices)}{nearest(str(value), field.choices)}"
    if field.low is None or field.high is None:
        return f"{said} is not {kind} ({_aside(field.description)})"
    span = f"{' .. '.join(field.limits)} {field.unit}".removesuffix(" -")
    if isinstance(value, float) and not math.isfinite(value):
        return f"{said} is not a finite number within {span}"
    if field.kind is int and isinstance(value, float) and value.is_integer() and field.low <= value <= field.high:
        return f"{said} is written with a decimal point: write {value:.0f}"
    if isinstance(value, (bool, str)) or not isinstance(value, (int, float)) or (field.kind is int and isinstance(value, float)):
        return f"{said} is not {kind} within {span}"
    remedy = f": {field.remedy}" if field.remedy else f" ({_aside(field.description)})"
    return f"{said} is outside {span}{remedy}{_millimetres(field, value)}"


def _aside(description: str) -> str:
    """Return a description for parentheses within a sentence."""
    return (description[0].lower() + description[1:]).replace("; ", ", ")


def _millimetres(field: ParameterField, value: Any) -> str:
    """Return the length in metres if a value would be in range as millimetres."""
    if field.unit != "m" or not isinstance(value, (int, float)) or field.low is None or field.high is None:
        return ""
    if abs(value) > sys.float_info.max:  # a whole number that no float can hold
        return ""
    return f" (did you mean {value / 1000.0:g}?)" if field.low <= value / 1000.0 <= field.high else ""
