"""What a sweep is: the schema of its file, and the sweep with all that it needs from other files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import Field, model_validator

from dcrb_ros.faults import Faults
from dcrb_ros.schema.fields import Group
from dcrb_ros.settings.files import flatten
from dcrb_ros.sweep.design import Axes, Value, size

SCENARIO = "scenario"
"""The one key of a sweep that is no parameter: the name of a scenario, or of its file."""
SOUND: Mapping[str, Value] = {f"faults.{key}": value for key, value in flatten(Faults().model_dump()).items()}
"""Every fault absent."""


class Windows(Group):
    """Windows cut out of the waveform."""

    length: int = Field(ge=16, le=10_000_000)
    """Samples in a window [-]."""
    overlap: float = Field(0.0, ge=0.0, le=0.99)
    """Share of a window that the next one has, too [-]."""
    kind: Literal["npz", "parquet"] = "npz"

    @property
    def hop(self) -> int:
        """Samples from a window's begin to the next one's [-]."""
        return max(1, round(self.length * (1.0 - self.overlap)))


class Shares(Group):
    """Shares of the bearing conditions in each split [-]."""

    train: float = Field(0.6, ge=0.0, le=1.0)
    validation: float = Field(0.2, ge=0.0, le=1.0)
    test: float = Field(0.2, ge=0.0, le=1.0)

    @model_validator(mode="after")
    def _whole(self) -> Shares:
        total = self.train + self.validation + self.test
        if abs(total - 1.0) > 1e-6:
            raise ValueError(f"train, validation and test add up to {total:g} instead of 1")
        return self


class SweepFile(Group):
    """A sweep as the user writes it."""

    base: str = "healthy"
    """Bench that every run begins with: a shipped name or a file."""
    fixed: dict[str, Any] = Field(default_factory=dict, alias="set")
    """Parameters that all runs share."""
    design: Literal["grid", "random", "latin_hypercube"] = "grid"
    points: int = Field(0, ge=0, le=10_000_000)
    """Points of a random or Latin-hypercube design [-]."""
    seed: int = Field(1, ge=0, le=2**31 - 1)
    """Seed of the design."""
    vary: dict[str, Any] = Field(default_factory=dict)
    """Values or a range per parameter; a point of the design is a condition of the bearing."""
    cases: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """What is wrong, by name, in every condition: values or ranges of faults and sensor, and a scenario."""
    seeds: int | list[int] = 1
    """How many seeds each condition draws, or the seeds."""
    twins: bool = False
    """Whether every faulty run has a healthy twin of the same condition and seed."""
    duration: float = Field(gt=0.0, le=1e6)
    """Recorded time of a run [s]."""
    settle: float = Field(0.0, ge=0.0, le=1e4)
    """Time before the first recorded sample [s]."""
    branch_at: float = Field(0.0, ge=0.0, le=1e4)
    """Time at which one healthy bearing branches into its cases; 0: each runs from its own start [s]."""
    output: Literal["npz", "parquet", "bag"] = "npz"
    windows: Windows | None = None
    split: Shares = Shares()
    licence: str = "CC-BY-4.0"
    """Licence of the data, for the data card."""


@dataclass(frozen=True)
class Sweep:
    """A sweep with all that it needs from other files, ready to be planned."""

    file: SweepFile
    text: str
    """The sweep file as it was read."""
    base: Mapping[str, Value]
    """Flat parameters of all runs."""
    vary: Axes
    cases: Mapping[str, Axes]
    stories: Mapping[str, Any]
    """Scenarios by the names that the sweep gives them."""

    @property
    def seeds(self) -> int:
        """Seeds of a condition [-]."""
        return self.file.seeds if isinstance(self.file.seeds, int) else len(self.file.seeds)

    @property
    def count(self) -> int:
        """Runs, some of which may turn out to be the same [-]."""
        design, conditions = self.file.design, size(self.file.design, self.vary, self.file.points)
        each = sum(size(design, axes, 1) for axes in self.cases.values())
        return conditions * self.seeds * each
