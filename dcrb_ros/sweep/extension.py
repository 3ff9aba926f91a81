"""Extension of a data set: a sweep with more points or lives adds runs, and the earlier ones keep their names and splits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.lives.plan import plan_of
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.sweep_file import EXTENDED


def extended_plan(plan: Plan, known: Mapping[str, Any]) -> Plan:
    """Return a plan that continues a data set with more points or lives, or the plan itself if it does not.

    Args:
        plan: the plan of the command.
        known: the inputs of the data set, empty for a new one.

    Raises:
        Refusal: the data set has these numbers already in another order, or the sweep file cannot be extended.
    """
    earlier, later = known.get("sweep", {}), plan.sweep.inputs
    before, count, history = _count(earlier), _count(later), earlier.get(EXTENDED, [])
    valid = isinstance(history, list) and all(type(number) is int for number in history)
    if before is None or count is None or not valid or later.get(EXTENDED, history) != history:
        return plan
    counts = [*history, before] if before < count else history if before == count else []
    if not counts or counts == later.get(EXTENDED):
        return plan
    sweep = plan.sweep
    file = sweep.file.model_copy(update={EXTENDED: counts})
    return plan_of(replace(sweep, file=file, text=_with_history(sweep.text, counts)))


def without_count(inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the inputs of a sweep without the number of points or lives and its history, in which an extension differs."""
    kept = {key: value for key, value in inputs.items() if key not in ("points", EXTENDED)}
    numbers = kept.get("numbers")
    return kept | {"numbers": {**numbers, "lives": 0}} if isinstance(numbers, Mapping) else kept


def _count(inputs: Mapping[str, Any]) -> int | None:
    """Return the number of points or lives of a sweep; None for a grid."""
    numbers = inputs.get("numbers")
    count = numbers.get("lives") if isinstance(numbers, Mapping) else inputs.get("points")
    return count if type(count) is int and count > 0 else None


def _with_history(text: str, counts: list[int]) -> str:
    """Return the text of a sweep file with the earlier numbers of points or lives, from which the same splits follow."""
    lines = [line for line in text.splitlines() if not line.startswith(f"{EXTENDED}:")]
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
    if first.startswith("{"):
        raise Refusal("the sweep file is written in braces and cannot be extended: write one key per line")
    return "\n".join([*lines, f"{EXTENDED}: {counts}", ""])
