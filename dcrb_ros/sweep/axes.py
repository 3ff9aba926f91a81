"""Axes of a sweep as written in its file: lists of values and ranges, checked against their parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, cast

from dcrb_ros.schema.parameter_field import ParameterField, flaw_of
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.sweep.design import GRID, Axes, Choice, Span, Value
from dcrb_ros.sweep.machine import flatten_axes

MOST_VALUES = 10_000
GAP_PARAMETERS = ("publishing.loss_probability", "publishing.burst_period")
"""Parameters that cause gaps in the waveform."""


def value_of(key: str, given: Any, field: ParameterField, source: str) -> Value:
    """Return a value converted to the type of its parameter.

    Raises:
        Refusal: it is of another type, or outside the range of the parameter.
    """
    value: Any = float(given) if field.kind is float and type(given) is int else given
    if flaw := flaw_of(replace(field, key=key), value):
        raise Refusal(f"{source}: {flaw}")
    return cast(Value, value)


def choice_of(key: str, value: Any, field: ParameterField | None, source: str) -> Choice:
    """Return the axis of a value or a list of values of a parameter, or of names of scenarios without one.

    Raises:
        Refusal: the list is empty or too long, or a value is invalid.
    """
    values = value if isinstance(value, list) else [value]
    if not values:
        raise Refusal(f"{source}: {key} has an empty list, so there would be no run: give at least one value, or leave the key out")
    if len(values) > MOST_VALUES:
        raise Refusal(f"{source}: {key} has {len(values)} values, more than {MOST_VALUES}: give fewer, or a range")
    if field is None:
        for name in values:
            if not isinstance(name, str):
                raise Refusal(f"{source}: {key} = {name!r} is not the name of a scenario: give a name, or '' for no scenario")
        return Choice(tuple(values))
    return Choice(tuple(value_of(key, value, field, source) for value in values))


def span_of(key: str, tree: Mapping[str, Any], field: ParameterField, design: str, source: str) -> Span:
    """Return the axis of a range of a parameter.

    Raises:
        Refusal: a key is unknown or missing, or a value is invalid.
    """
    known = ("low", "high", "scale", "count")
    for name in tree:
        if name not in known:
            raise Refusal(f"{source}: {key}: unknown key '{name}'{nearest(str(name), known)}; a range has {', '.join(known)}")
    if not {"low", "high"} <= set(tree) or field.kind not in (int, float):
        raise Refusal(f"{source}: {key}: a range needs low and high, and applies to numeric parameters only")
    low, high = (value_of(f"{key} ({end})", tree[end], field, source) for end in ("low", "high"))
    scale, count = tree.get("scale", "linear"), tree.get("count", 0)
    if scale not in ("linear", "log"):
        raise Refusal(f"{source}: {key}: scale = {scale!r} is not one of linear, log")
    if not float(low) < float(high):
        raise Refusal(f"{source}: {key}: low = {low!r} is not below high = {high!r}: swap them, or give a list of values")
    if scale == "log" and not float(low) > 0.0:
        raise Refusal(f"{source}: {key}: low = {low!r} is not above 0: a logarithmic scale needs a positive lower limit")
    if design != GRID and "count" in tree:
        raise Refusal(f"{source}: {key}: count = {count!r} applies to a grid only: remove it, the design has 'points'")
    if type(count) is not int or (design == GRID and not 1 <= count <= MOST_VALUES):
        raise Refusal(f"{source}: {key}: a grid needs the number of values of a range: give count, 1 .. {MOST_VALUES}, not {count!r}")
    return Span(float(low), float(high), scale == "log", field.kind is int, count)


def axes_of(
    tree: Mapping[str, Any], design: str, source: str, field_of: Callable[[str, Any], ParameterField | None]
) -> dict[str, Choice | Span]:
    """Return the axes of a group; ``field_of`` returns the parameter of a key and its value, and None for that of a scenario."""
    axes: dict[str, Choice | Span] = {}
    for key, value in flatten_axes(tree).items():
        field = field_of(key, value)
        if field is not None and isinstance(value, Mapping):
            axes[key] = span_of(key, value, field, design, source)
        else:
            axes[key] = choice_of(key, value, field, source)
    return axes


def refuse_fixed(vary: Axes, fixed: Mapping[str, Any], source: str) -> None:
    """Refuse a parameter that is fixed and varied, whose fixed value would have no effect."""
    twice = next((key for key in vary if key in fixed), None)
    if twice is not None:
        raise Refusal(
            f"{source}: {twice} = {fixed[twice]!r} under 'set' would have no effect, because the parameter is varied, by 'vary' or by the "
            "intervals of a machine: remove it, or give the value under 'vary'"
        )
