"""Extension of a data set: a sweep with more points, lives or values adds runs, and the earlier ones keep their names and splits."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from yaml import YAMLError

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.design import GRID
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.machine import flatten_axes
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.sweep_file import EXTENDED, Extent
from dcrb_ros.text.yaml import parsed


def extended_plan(plan: Plan, known: Mapping[str, Any]) -> Plan:
    """Return a plan that continues a data set with more points, lives or values, or the plan itself if it does not.

    ``known`` are the inputs of the data set, empty for a new one.

    Raises:
        Refusal: the data set has these extents already in another order, or the sweep file cannot be extended.
    """
    earlier, later = known.get("sweep", {}), plan.sweep.inputs
    before, extent, history = _extent(earlier), _extent(later), earlier.get(EXTENDED, [])
    numbers = [entry.values() if isinstance(entry, dict) else [entry] for entry in history] if isinstance(history, list) else [[None]]
    valid = all(type(number) is int for entry in numbers for number in entry)
    if before is None or extent is None or not valid or later.get(EXTENDED, history) != history:
        return plan
    extents = [*history, before] if _grows(earlier, later) else history if before == extent else []
    if not extents or extents == later.get(EXTENDED):
        return plan
    sweep = plan.sweep
    file = sweep.file.model_copy(update={EXTENDED: extents})
    return plan_of(replace(sweep, file=file, text=_with_history(sweep.text, extents)))


def without_extension(inputs: Mapping[str, Any], first: Extent | None) -> dict[str, Any]:
    """Return the inputs of a sweep without its history and its points, lives or added values: of a grid, the ``first`` values are kept."""
    kept = {key: value for key, value in inputs.items() if key not in ("points", EXTENDED)}
    if isinstance(first, dict):
        return kept | {"vary": _cut(inputs, first)}
    numbers = kept.get("numbers")
    return kept | {"numbers": {**numbers, "lives": 0}} if isinstance(numbers, Mapping) else kept


def _extent(inputs: Mapping[str, Any]) -> Extent | None:
    """Return the number of points or lives of a sweep, or the number of values of each axis of a grid."""
    numbers = inputs.get("numbers")
    if inputs.get("design") == GRID and not isinstance(numbers, Mapping):
        return {key: len(values) for key, values in _axes(inputs).items()} or None
    count = numbers.get("lives") if isinstance(numbers, Mapping) else inputs.get("points")
    return count if type(count) is int and count > 0 else None


def _axes(inputs: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Return the values of the axes of a grid as written; a range is one value, since another count moves its values."""
    vary = inputs.get("vary")
    axes = flatten_axes(vary) if isinstance(vary, Mapping) else {}
    return {key: value if isinstance(value, list) else [value] for key, value in axes.items()}


def _grows(earlier: Mapping[str, Any], later: Mapping[str, Any]) -> bool:
    """Return whether a sweep has all points, lives or values of an earlier one, in the same places, and more."""
    before, after = _extent(earlier), _extent(later)
    if isinstance(before, int) and isinstance(after, int):
        return before < after
    return isinstance(before, dict) and isinstance(after, dict) and before != after and _axes(earlier) == _cut(later, before)


def _cut(inputs: Mapping[str, Any], first: Mapping[str, int]) -> dict[str, list[Any]]:
    """Return the ``first`` values of each axis of a grid."""
    return {key: values[: first.get(key, 0)] for key, values in _axes(inputs).items()}


def _with_history(text: str, extents: list[Extent]) -> str:
    """Return the text of a sweep file with the earlier extents, from which the same splits follow.

    Raises:
        Refusal: a line with them cannot be added to the text.
    """
    lines = "".join(f"{line}\n" for line in text.splitlines())
    others = re.sub(rf"^{EXTENDED}:.*\n([- ].*\n)*", "", lines, flags=re.MULTILINE)
    changed = f"{others}{EXTENDED}: {json.dumps(extents)}\n"
    try:
        same = parsed(changed) == {**(parsed(text) or {}), EXTENDED: extents}
    except YAMLError:
        same = False
    if not same:
        raise Refusal(
            f"the sweep file cannot be extended as it is written: write one key per line without braces, and '{EXTENDED}' in one line"
        )
    return changed
