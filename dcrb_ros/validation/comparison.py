"""One line of the table: a quantity, what the paper says, what we find, whether it holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from dcrb_ros.validation.runs import Run

Runs = Mapping[tuple[str, str], Run]
"""Runs by name of the case and joint."""


@dataclass(frozen=True)
class Comparison:
    """A quantity held against a number."""

    quantity: str
    joint: str
    """revolute, pocket or both."""
    paper: str
    """What the paper prints, with its place; a dash where it says nothing."""
    ours: str
    accept: str
    """What is accepted."""
    holds: bool

    @property
    def verdict(self) -> str:
        """holds, or falls short."""
        return "holds" if self.holds else "falls short"


def within(value: float, expected: float, relative: float) -> bool:
    """Return whether a value lies within a relative tolerance of what is expected."""
    return abs(value - expected) <= relative * abs(expected)
