"""Sealed exams: scenarios drawn from a secret seed, whose hash is published before the exam and which is revealed after it.

The template of a sealed exam is an exam file whose scenarios have ``draw`` and ``count``. The draws use SHA-256 and are rounded, so that
they are the same on all machines.
"""

from __future__ import annotations

import hashlib
import math
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from dcrb_ros.exam.case import canonical
from dcrb_ros.exam.exam_file import MOST_CASES, Exam, exam_of
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten
from dcrb_ros.text.counts import counted
from dcrb_ros.text.files import checked_path, read_text
from dcrb_ros.text.yaml import read_yaml

DIGITS = 6
"""Significant digits of a drawn number; powers differ between machines in the last ones of a float."""
SEEDS = 2**31
"""Seeds of the simulation that are drawn [-]."""
FEWEST_DRAWN = 4
"""Scenarios that a sealed exam must draw [-]: the hash of few could be found by trying their seeds and values."""
SECRET_DIGITS = 64
"""Length of a secret seed [hexadecimal digits]."""


class SealedExam(Group):
    """A sealed exam as published before it is held."""

    sealed: str = Field(pattern="^[0-9a-f]{64}$")
    """SHA-256 of template and secret seed."""
    scenarios_sha256: str = Field(pattern="^[0-9a-f]{64}$")
    """SHA-256 of the drawn scenarios, as in a report."""
    dcrb_ros: str
    """Version that drew them."""
    template: dict[str, Any]


def new_secret() -> str:
    """Return a secret seed of 256 bits as hexadecimal digits."""
    return secrets.token_hex(SECRET_DIGITS // 2)


def seal(template: Any, secret: str, source: str) -> SealedExam:
    """Return a sealed exam.

    Raises:
        Refusal: the template draws nothing or too few scenarios, or an exam drawn from it is invalid.
    """
    drawn = drawn_exam(template, secret, source)
    count = sum(entry.get("count", 1) for entry in template["scenarios"] if "draw" in entry)
    if count < FEWEST_DRAWN:
        raise Refusal(
            f"{source} draws {counted(count, 'scenario')}, so few that their published hash could be found by trying all values: "
            f"draw at least {FEWEST_DRAWN}"
        )
    digest = commitment(template, secret)
    opened = exam_of({**drawn, "seal": digest}, source)
    return SealedExam(sealed=digest, scenarios_sha256=opened.digest, dcrb_ros=__version__, template=dict(template))


def commitment(template: Any, secret: str) -> str:
    """Return the SHA-256 of template and secret seed, which binds both and reveals neither scenarios nor seed.

    Raises:
        Refusal: the template has a value or a key that JSON does not have.
    """
    try:
        about = canonical({"secret": secret, "template": template})
    except (TypeError, ValueError) as error:
        raise Refusal(f"the template cannot be sealed ({error}): its keys must be words, and its values finite numbers or texts") from None
    return hashlib.sha256(about.encode()).hexdigest()


def open_exam(sealed: SealedExam, secret: str, source: str) -> tuple[Exam, dict[str, Any]]:
    """Return the exam that was sealed, and its file as a tree.

    Raises:
        Refusal: the secret is not the one with which it was sealed.
    """
    if commitment(sealed.template, secret) != sealed.sealed:
        raise Refusal(f"{source} was not sealed with this secret, or its template has been changed: its SHA-256 is {sealed.sealed}")
    tree = {**drawn_exam(sealed.template, secret, source), "seal": sealed.sealed}
    return exam_of(tree, source), tree


def read_sealed(path: Path) -> SealedExam:
    """Return the sealed exam in a file.

    Raises:
        Refusal: the file cannot be read, or is not a sealed exam.
    """
    tree = read_yaml(checked_path(path))
    try:
        return SealedExam.model_validate(tree)
    except ValidationError as error:
        key, reason, _ = first_problem(error)
        raise Refusal(f"{path} is not a sealed exam ({key or 'the file'}: {reason}): give a file of dcrb exam seal") from None


def read_secret(path: Path) -> str:
    """Return the secret seed in a file.

    Raises:
        Refusal: the file cannot be read, or contains anything else.
    """
    text = read_text(checked_path(path), 1000).strip()
    if len(text) != SECRET_DIGITS or set(text) - set("0123456789abcdef"):
        raise Refusal(
            f"{path} does not contain a secret seed of {SECRET_DIGITS} hexadecimal digits: give the file that dcrb exam seal wrote"
        )
    return text


def drawn_exam(template: Any, secret: str, source: str) -> dict[str, Any]:
    """Return the exam file drawn from a template.

    Raises:
        Refusal: no scenario has ``draw``, or one has an invalid range or count, or a value that the draw would replace.
    """
    scenarios = template.get("scenarios") if isinstance(template, Mapping) else None
    if not isinstance(scenarios, list) or not any(isinstance(entry, Mapping) and "draw" in entry for entry in scenarios):
        raise Refusal(f"{source} draws nothing, so there is nothing to seal: give at least one scenario 'draw' with ranges of parameters")
    counts = [_count(entry, f"{source}, scenario {k}") for k, entry in enumerate(scenarios, 1) if isinstance(entry, Mapping)]
    if sum(counts) > MOST_CASES:
        raise Refusal(f"{source} draws {sum(counts)} scenarios: an exam has at most {MOST_CASES}")
    drawn = [scenario for k, entry in enumerate(scenarios, 1) for scenario in _drawn(entry, secret, f"{source}, scenario {k}")]
    return {**template, "scenarios": drawn}


def _count(entry: Mapping[str, Any], where: str) -> int:
    count = entry.get("count", 1)
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST_CASES:
        raise Refusal(f"{where}: count = {count!r} is outside 1 .. {MOST_CASES}: give the number of scenarios to draw")
    return count


def _drawn(entry: Any, secret: str, where: str) -> list[Any]:
    """Return the scenarios that an entry of a template stands for."""
    if not isinstance(entry, Mapping):
        raise Refusal(f"{where} is {'empty' if entry is None else repr(entry)}: give it a name and a verdict, or remove it")
    if "draw" not in entry:
        if "count" in entry:
            raise Refusal(f"{where}: it has 'count' but no 'draw': give the ranges to draw from, or leave out 'count'")
        return [entry]
    ranges = entry["draw"]
    if not isinstance(ranges, Mapping) or not ranges or set(ranges) - {"set", "fault"}:
        raise Refusal(f"{where}: 'draw' must have 'set' or 'fault', each with parameters and their ranges")
    if not isinstance(entry.get("name"), str):
        raise Refusal(f"{where}: name = {entry.get('name')!r} is not a text: give the scenario a name")
    rest = {key: value for key, value in entry.items() if key not in ("draw", "count")}
    for group in ("set", "fault"):
        if not isinstance(rest.get(group) or {}, Mapping):
            raise Refusal(f"{where}: {group} = {rest[group]!r} must name parameters and their values")
        twice = next((key for key in flatten(rest.get(group) or {}) if key in (ranges.get(group) or ())), None)
        if twice is not None:
            raise Refusal(f"{where}: {twice} is in '{group}' and in draw.{group}, which would replace it: give one of them")
    if "seeds" in rest:
        raise Refusal(f"{where}: seeds = {rest['seeds']!r} would have no effect, every drawn scenario has a seed of its own: remove it")
    drawn = []
    for number in range(1, _count(entry, where) + 1):
        name = f"{entry['name']}/{number}"
        scenario: dict[str, Any] = {**rest, "name": name, "seeds": [int(_share(secret, name, "seed") * SEEDS)]}
        for group, axes in ranges.items():
            if not isinstance(axes, Mapping):
                raise Refusal(f"{where}: draw.{group} must name parameters and their ranges, such as {{low: 0.0005, high: 0.003}}")
            values = {key: _value(axis, _share(secret, name, group, key), f"{where}: {key}") for key, axis in axes.items()}
            scenario[group] = {**(rest.get(group) or {}), **values}
        drawn.append(scenario)
    return drawn


def _share(secret: str, *names: str) -> float:
    """Return a number 0 <= u < 1 that follows from the secret seed and from what it is drawn for [-]."""
    digest = hashlib.sha256(canonical([secret, *names]).encode()).hexdigest()
    return int(digest[:13], 16) / 16**13


def _value(axis: Any, share: float, where: str) -> Any:
    """Return the value at a position in a range, or one of a list."""
    if isinstance(axis, list) and axis:
        return axis[int(share * len(axis))]
    if not isinstance(axis, Mapping) or not {"low", "high"} <= set(axis) or set(axis) - {"low", "high", "scale"}:
        raise Refusal(f"{where} = {axis!r} is not a range: give {{low: LOW, high: HIGH}}, with 'scale: log' if wanted, or a list of values")
    low, high, scale = axis["low"], axis["high"], axis.get("scale", "linear")
    log = scale == "log"
    if scale not in ("linear", "log"):
        raise Refusal(f"{where}: scale = {scale!r} is unknown: give linear or log")
    if any(isinstance(end, bool) or not isinstance(end, (int, float)) for end in (low, high)) or not low <= high or (log and low <= 0):
        raise Refusal(f"{where}: the range {low!r} .. {high!r} is invalid: give numbers in increasing order, above 0 with scale: log")
    whole = isinstance(low, int) and isinstance(high, int)
    if whole and not log:
        return low + int(share * (high - low + 1))
    exact = low * (high / low) ** share if log else low + share * (high - low)
    if whole:
        return round(exact)
    return min(max(float(f"{exact:.{DIGITS}g}"), float(low)), float(high)) if math.isfinite(exact) else float(low)
