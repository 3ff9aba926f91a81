"""A comparison of one quantity with its expected value."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

PAPER = "The paper"
"""Chapter of the comparisons with Fan et al. 2025."""


@dataclass(frozen=True)
class ReportRow:
    """A quantity compared with its expected value: one line of the report's table."""

    quantity: str
    joint: str
    """revolute, pocket or both."""
    paper: str
    """Value in the paper and its section or figure; a dash if the paper gives none."""
    found: str
    """Value of this model."""
    accepted: str
    """Expected value with its tolerance."""
    holds: bool
    """Whether the value is accepted."""
    chapter: str = PAPER
    """Chapter of the report."""

    @property
    def verdict(self) -> str:
        """The result in words: holds, or falls short."""
        return "holds" if self.holds else "falls short"


def about(chapter: str, quantity: str, values: npt.ArrayLike, expected: npt.ArrayLike, relative: float, unit: str = "") -> ReportRow:
    """Return the comparison of numbers with expected ones, within a relative tolerance [-] of each."""
    ours, theirs = (np.atleast_1d(np.asarray(numbers, np.float64)) for numbers in (values, expected))
    listed = [" ".join([", ".join(f"{number:.4g}" for number in numbers), unit]).strip() for numbers in (ours, theirs)]
    holds = all(within(value, wanted, relative) for value, wanted in zip(ours, theirs, strict=True))
    return ReportRow(quantity, "pocket", "-", listed[0], f"{listed[1]}, {100.0 * relative:.3g} %", holds, chapter)


def between(
    chapter: str, quantity: str, value: float, low: float, high: float, unit: str = "", *, joint: str = "pocket", paper: str = "-"
) -> ReportRow:
    """Return the comparison of a number with a range."""
    accepted = f"at most {high:g}" if low == -math.inf else f"at least {low:g}" if high == math.inf else f"{low:g} to {high:g}"
    return ReportRow(quantity, joint, paper, f"{value:.3g} {unit}".strip(), f"{accepted} {unit}".strip(), low <= value <= high, chapter)


def within(value: float, expected: float, relative: float) -> bool:
    """Return whether a value is within a relative tolerance of the expected one."""
    return abs(value - expected) <= relative * abs(expected)
