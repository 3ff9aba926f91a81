"""Types of the arguments of public functions, checked before their values."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from numbers import Real
from typing import Any, ParamSpec, TypeVar

import numpy as np

from dcrb_ros.schema.refusal import Refusal

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")
Check = Callable[[str, Any], object]
"""Takes the name and the value of an argument, and raises a `Refusal` if the value is of a wrong type."""


def checked_arguments(**checks: Check) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """Return a decorator that checks arguments by name before it calls a function; defaults are not checked.

    Raises:
        Refusal: an argument is of a wrong type, at the call.
    """

    def decorate(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def checked(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
            given = signature.bind(*args, **kwargs).arguments
            for name, check in checks.items():
                if name in given:
                    check(name, given[name])
            return function(*args, **kwargs)

        return checked

    return decorate


def number(name: str, value: Any) -> None:
    """Refuse what is not a real number; NaN and infinity are numbers."""
    try:
        valid = isinstance(value, Real) and not isinstance(value, bool)
        float(value if valid else 0.0)
    except OverflowError:
        raise Refusal(f"{name} is an integer of more than 300 digits: give a number that fits its unit") from None
    if not valid:
        raise Refusal(f"{name} is a {type(value).__name__}, not a number: give a number")


def numbers(name: str, value: Any) -> None:
    """Refuse what is not an array of real numbers, or a sequence that makes one; masked values, texts and dates are no numbers."""
    if np.ma.is_masked(value):
        raise Refusal(f"{name} has masked values: leave these samples out, or replace them by numbers")
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "biufO":
            raise TypeError
        array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise Refusal(f"{name} is not an array of real numbers: give numbers, in rows of equal lengths") from None


def of_type(*types: type) -> Check:
    """Return a check that refuses values of other types."""

    def check(name: str, value: Any) -> None:
        if not isinstance(value, types):
            expected = " or ".join(kind.__name__ for kind in types if kind is not type(None))
            raise Refusal(f"{name} is a {type(value).__name__}: give a value of the type {expected}")

    return check


def with_attributes(*attributes: str, kind: str) -> Check:
    """Return a check that refuses values that lack an attribute of a ``kind``, such as a bearing."""

    def check(name: str, value: Any) -> None:
        lacking = [attribute for attribute in attributes if not hasattr(value, attribute)]
        if lacking:
            raise Refusal(f"{name} is a {type(value).__name__} without the attribute {lacking[0]}: give {kind}")

    return check


def texts(name: str, value: Any) -> None:
    """Refuse what is neither a text nor a sequence of texts."""
    if not (isinstance(value, str) or (isinstance(value, (list, tuple)) and all(isinstance(text, str) for text in value))):
        raise Refusal(f"{name} is not a text or a list of texts: give names")


def keyed(name: str, value: Any) -> Mapping[str, Any]:
    """Return a mapping with texts as keys, such as that of changed parameters; refuse everything else."""
    if not isinstance(value, Mapping):
        raise Refusal(f"{name} is a {type(value).__name__}: give a mapping of dotted keys to values, such as {{'operating.speed': 100.0}}")
    for key in value:
        if not isinstance(key, str):
            raise Refusal(f"{name} has the key {key!r}, which is a {type(key).__name__}: give a text, such as 'operating.speed'")
    return value


def optional(check: Check) -> Check:
    """Return a check that accepts None as well."""
    return lambda name, value: None if value is None else check(name, value)
