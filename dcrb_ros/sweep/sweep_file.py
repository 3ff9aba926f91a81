"""The schema of a sweep file, and the sweep resolved with the files that it refers to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import Field, model_validator

from dcrb_ros.faults import Faults
from dcrb_ros.schema.fields import Group
from dcrb_ros.settings.files import fields_by_key, flatten
from dcrb_ros.sweep.design import Axes, Choice, Value, size

Extent = int | dict[str, int]
"""Number of points or lives, or the number of values of each axis of a grid [-]."""
EXTENDED = "extended"
"""Key with the extents of the sweep before each extension."""
SCENARIO = "scenario"
"""The only key of an axis that is not a parameter: the name or the file of a scenario."""
ABOUT, COPY, KEPT_BASE = "sweep.json", "sweep.yaml", "base.yaml"
"""Names of the files in which a data set keeps its inputs with the scenarios, its sweep file and its base."""
LONGEST_RUN = 600.0
"""Longest run whose waveform is kept in memory [s]: 370 MB at 51.2 kHz."""
NO_FAULTS: Mapping[str, Value] = {f"faults.{key}": value for key, value in flatten(Faults().model_dump()).items()}
"""Values of all fault parameters without faults."""


MOST_RUNS = 1_000_000
"""Runs of a sweep [-]; the plan of so many takes some 50 s and 0.3 GB."""
LONGEST_WINDOW = 10_000_000
"""Most samples in a window [-]."""


class Windows(Group):
    """Division of the waveform into windows."""

    length: int = Field(ge=16, le=LONGEST_WINDOW)
    """Samples in a window [-]."""
    overlap: float = Field(0.0, ge=0.0, le=0.99)
    """Overlap of consecutive windows as a share of their length [-]."""
    kind: Literal["npz", "parquet"] = "npz"

    @property
    def hop(self) -> int:
        """Samples from the start of a window to the start of the next [-]."""
        return max(1, round(self.length * (1.0 - self.overlap)))


class Shares(Group):
    """Shares of the bearing conditions in each split [-], or of the groups of conditions that share a bearing or a machine."""

    train: float = Field(0.6, ge=0.0, le=1.0)
    validation: float = Field(0.2, ge=0.0, le=1.0)
    test: float = Field(0.2, ge=0.0, le=1.0)
    apart: list[Literal["bearing_id", "machine"]] | None = None
    """Identities that two splits must not share, in addition to conditions; None for those of which the design has enough."""

    @model_validator(mode="after")
    def _whole(self) -> Shares:
        total = self.train + self.validation + self.test
        if abs(total - 1.0) > 1e-6:
            raise ValueError(f"train, validation and test add up to {total:g}, but must add up to 1")
        return self


class SweepFile(Group):
    """A sweep as written in its file."""

    base: str = "healthy"
    """Configuration on which all runs are based: a shipped name or a file."""
    fixed: dict[str, Any] = Field(default_factory=dict, alias="set")
    """Parameters common to all runs."""
    design: Literal["grid", "random", "latin_hypercube"] = "grid"
    points: int = Field(0, ge=0)
    """Points of a random or Latin-hypercube design [-]."""
    seed: int = Field(1, ge=0, le=2**31 - 1)
    """Seed of the design."""
    vary: dict[str, Any] = Field(default_factory=dict)
    """Values or a range for each parameter; a point of the design is a condition of the bearing."""
    cases: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Faults by case name, simulated in every condition: values or ranges of fault and sensor parameters, and a scenario."""
    seeds: int | list[int] = 1
    """Number of seeds per condition, or the seeds themselves."""
    twins: bool = False
    """Whether every faulty run has a healthy twin with the same condition and seed."""
    duration: float = Field(gt=0.0, le=1e6)
    """Recorded time of a run [s]."""
    settle: float = Field(0.0, ge=0.0, le=1e4)
    """Time before the first recorded sample [s]."""
    branch_at: float = Field(0.0, ge=0.0, le=1e4)
    """Time at which the cases branch from one healthy simulation [s]; 0: every run is simulated from its own start."""
    output: Literal["npz", "parquet", "bag"] = "npz"
    windows: Windows | None = None
    split: Shares = Shares()
    extended: list[Extent] = Field(default_factory=list, max_length=1000)
    """Numbers of points, lives or values that the data set had before it was extended; `dcrb sweep` writes it."""
    licence: str = "CC-BY-4.0"
    """Licence of the data, for the data card."""


@dataclass(frozen=True)
class Sweep:
    """A sweep with the contents of the files that it refers to, from which a plan can be made."""

    file: SweepFile
    text: str
    """The text of the sweep file."""
    base: Mapping[str, Value]
    """Parameters of all runs by dotted key."""
    vary: Axes
    cases: Mapping[str, Axes]
    scenarios: Mapping[str, Any]
    """Scenarios by the names used in the sweep."""

    @property
    def inputs(self) -> dict[str, Any]:
        """All inputs of the plan apart from base and scenarios, as written to the description of the data set."""
        inputs = self.file.model_dump(mode="json", by_alias=True)
        return inputs if self.file.extended else {key: value for key, value in inputs.items() if key != EXTENDED}

    @property
    def rate(self) -> int:
        """Sampling rate of the base [Hz]."""
        return int(self.base["sensor.sampling_rate"])

    @property
    def subject(self) -> str:
        """What is simulated, in words."""
        axis = self.vary.get("bearing.rows", Choice((self.base["bearing.rows"],)))
        rows = {int(count) for count in (axis.values if isinstance(axis, Choice) else (axis.low, axis.high))}
        return f"{' or '.join({1: 'single-row', 2: 'double-row'}[count] for count in sorted(rows))} roller bearing"

    @property
    def varied(self) -> Mapping[str, type]:
        """Varied parameters, each of which has a column of the labels, with their types."""
        keys = {key for axes in (self.vary, *self.cases.values()) for key in axes}
        return {key: field.kind for key, field in fields_by_key().items() if key in keys}

    @property
    def seeds(self) -> int:
        """Number of seeds per condition [-]."""
        return self.file.seeds if isinstance(self.file.seeds, int) else len(self.file.seeds)

    @property
    def count(self) -> int:
        """Number of runs, including duplicates that the plan leaves out [-]."""
        design, conditions = self.file.design, size(self.file.design, self.vary, self.file.points)
        runs = sum(size(design, axes, 1) for axes in self.cases.values())
        return conditions * self.seeds * runs
