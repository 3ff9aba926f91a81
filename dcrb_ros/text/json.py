"""JSON: from outside its size, number of values and nesting are limited; every number is finite."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from dcrb_ros.schema.refusal import Refusal

LARGEST = 16 * 1024 * 1024
"""Longest text that is read unless another limit is given [characters]: the records of a recording, with some 200000 commands."""
MOST_VALUES = 1_000_000
"""Most values unless another limit is given [-], counted by the commas and brackets of the text."""
DEEPEST = 100
"""Deepest nesting [-]."""
MOST_DIGITS = 300
"""Longest integer [digits] that converts to a float."""


def parsed_json(text: str | bytes, source: str, largest: int = LARGEST, most: int = MOST_VALUES) -> Any:
    """Return the value of a JSON text.

    Raises:
        Refusal: the text is too long, has too many values, is nested too deeply, contains NaN or too large a number, or is not JSON.
    """
    if len(text) > largest:
        raise Refusal(f"{source} has {len(text)} characters; at most {largest} are read")
    try:
        decoded = text if isinstance(text, str) else text.decode("utf-8")
        values = sum(map(decoded.count, ",[{"))
        if values > most:
            raise Refusal(f"{source} has some {values} values; at most {most} are read")
        value = json.loads(decoded, parse_int=_integer, parse_float=_finite, parse_constant=_finite)
        if _depth(value) > DEEPEST:
            raise RecursionError
    except RecursionError:
        raise Refusal(f"{source} is nested more than {DEEPEST} deep: flatten it") from None
    except Refusal:
        raise
    except ValueError as error:
        raise Refusal(f"{source} is not valid JSON: {error}") from None
    return value


def json_text(tree: Any) -> str:
    """Return a tree as indented JSON, with null for a number that JSON does not have."""
    return json.dumps(with_nulls(tree), indent=2, allow_nan=False)


def with_nulls(tree: Any) -> Any:
    """Return a tree with NaN and infinity replaced by null, since JSON has neither."""
    if isinstance(tree, Mapping):
        return {key: with_nulls(value) for key, value in tree.items()}
    if isinstance(tree, Sequence) and not isinstance(tree, str):
        return [with_nulls(value) for value in tree]
    return None if isinstance(tree, float) and not math.isfinite(tree) else tree


def digest_of(entries: Mapping[str, Any], key: str) -> str:
    """Return the SHA-256 of the entries of an object other than ``key``, under which the object has it, as JSON with sorted keys."""
    others = {name: value for name, value in entries.items() if name != key}
    return hashlib.sha256(json.dumps(others, sort_keys=True, default=str).encode()).hexdigest()


def _integer(digits: str) -> int:
    if len(digits) > MOST_DIGITS:
        raise ValueError(f"a number has {len(digits)} digits, at most {MOST_DIGITS} are read")
    return int(digits)


def _finite(digits: str) -> float:
    number = float(digits)
    if not math.isfinite(number):
        raise ValueError(f"{digits[:40]} is not a finite number")
    return number


def _depth(value: Any) -> int:
    """Return the number of containers around the innermost value, up to one more than `DEEPEST`."""
    depth, level = 0, [value] if isinstance(value, dict | list) else []
    while level and depth <= DEEPEST:
        depth += 1
        inside = (inner for outer in level for inner in (outer.values() if isinstance(outer, dict) else outer))
        level = [inner for inner in inside if isinstance(inner, dict | list)]
    return depth
