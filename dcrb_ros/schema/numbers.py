"""Numbers given by the user."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

from dcrb_ros.schema.refusal import Refusal

HIGHEST_RATE = 10_000_000
"""Highest sampling rate [Hz]; the memory of a detector grows with it."""

MOST_BITS = 1000
"""Bits of an integer that a float can hold, less some."""


def _short(value: Any) -> bool:
    return not isinstance(value, int) or value.bit_length() <= MOST_BITS


def sampling_rate(value: Any, source: str) -> int:
    """Return the sampling rate that ``source`` gives, a whole number from 1 to `HIGHEST_RATE` [Hz].

    Raises:
        Refusal: it is not such a number.
    """
    whole = isinstance(value, Real) and not isinstance(value, bool) and _short(value) and math.isfinite(value) and float(value).is_integer()
    if not whole or not 1 <= value <= HIGHEST_RATE:
        raise Refusal(f"{source} gives a sampling rate of {value!r} Hz: it must be a whole number within 1 .. {HIGHEST_RATE} Hz")
    return int(value)


def finite_number(name: str, value: Any, unit: str) -> float:
    """Return a finite real number of Python or numpy as a float; ``name`` introduces it in the message, such as ``"duration ="``.

    Raises:
        Refusal: it is another type, a truth value, NaN or infinite.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise Refusal(f"{name} {value!r} is not a number: give it in {unit}")
    if not _short(value):
        raise Refusal(f"{name} an integer of more than 300 digits is not a number in {unit}: give a smaller one")
    if not math.isfinite(value):
        raise Refusal(f"{name} {float(value):g} {unit} is not a finite number")
    return float(value)


def duration_within(name: str, value: Any, longest: float, remedy: str) -> float:
    """Return a duration above 0 and up to ``longest`` [s].

    Raises:
        Refusal: it is not a number in that range.
    """
    duration = finite_number(name, value, "s")
    if not 0.0 < duration <= longest:
        raise Refusal(f"{name} {duration:g} s is out of range: it must be above 0 and at most {longest:g} s; {remedy}")
    return duration
