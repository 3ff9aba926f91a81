"""A comparison of one quantity with its expected value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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

    @property
    def verdict(self) -> str:
        """The result in words: holds, or falls short."""
        return "holds" if self.holds else "falls short"


def within(value: float, expected: float, relative: float) -> bool:
    """Return whether a value is within a relative tolerance of the expected one."""
    return abs(value - expected) <= relative * abs(expected)
