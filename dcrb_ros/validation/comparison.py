"""A comparison of one quantity with its expected value."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dcrb_ros.validation.runs import Run

Runs = Mapping[tuple[str, str], Run]
"""Runs by name and joint."""


@dataclass(frozen=True)
class Comparison:
    """A quantity compared with its expected value: one line of the report's table."""

    quantity: str
    joint: str
    """revolute, pocket or both."""
    paper: str
    """Value in the paper and its place; a dash if the paper gives none."""
    found: str
    """Value of this model."""
    accepted: str
    """Expected value with its tolerance."""
    holds: bool
    """Whether the value is accepted."""
    chapter: str = "The paper"
    """Chapter of the report."""

    @property
    def verdict(self) -> str:
        """The result in words: holds, or falls short."""
        return "holds" if self.holds else "falls short"


def about(chapter: str, quantity: str, found: npt.ArrayLike, expected: npt.ArrayLike, relative: float, unit: str = "") -> Comparison:
    """Return the comparison of numbers with expected ones, within a relative tolerance [-] of each."""
    ours, theirs = (np.atleast_1d(np.asarray(values, np.float64)) for values in (found, expected))
    listed = [" ".join([", ".join(f"{value:.4g}" for value in values), unit]).strip() for values in (ours, theirs)]
    holds = all(within(one, other, relative) for one, other in zip(ours, theirs, strict=True))
    return Comparison(quantity, "pocket", "-", listed[0], f"{listed[1]}, {100.0 * relative:.3g} %", holds, chapter)


def between(chapter: str, quantity: str, found: float, low: float, high: float, unit: str = "") -> Comparison:
    """Return the comparison of a number with a range."""
    accepted = f"at most {high:g}" if low == -math.inf else f"at least {low:g}" if high == math.inf else f"{low:g} to {high:g}"
    return Comparison(quantity, "pocket", "-", f"{found:.3g} {unit}".strip(), f"{accepted} {unit}".strip(), low <= found <= high, chapter)


def within(value: float, expected: float, relative: float) -> bool:
    """Return whether a value is within a relative tolerance of the expected one."""
    return abs(value - expected) <= relative * abs(expected)
