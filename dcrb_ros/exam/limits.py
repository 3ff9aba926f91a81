"""Limits of a detector written in Python in one scenario."""

from __future__ import annotations

from typing import NamedTuple


class Limits(NamedTuple):
    """Limits of a detector in one scenario."""

    block: float = 60.0
    """Wall time of a block [s]."""
    scenario: float = 600.0
    """Wall time of a scenario beyond its recorded time [s]; also of the import of the detector."""
    memory: int = 4096
    """Memory that the detector can write to [MiB]."""
    options: bool = True
    """Whether the command has options for the limits, which a message then names."""
