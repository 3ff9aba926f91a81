"""The ground truth of a run over time, as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from dcrb_ros.faults.ground_truth import summary_of
from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.stream.block import Truth
from dcrb_ros.stream.event_text import encode_event
from dcrb_ros.stream.events import LoadCommand, ParameterChange, SpeedCommand, TimedCommand, UnknownCommand

if TYPE_CHECKING:
    import pandas as pd


FREQUENCIES = ("FTF", "BPFO", "BPFI", "BSF")
"""Characteristic frequencies in the ground truth."""


@dataclass(frozen=True, eq=False, repr=False)
class GroundTruth:
    """Ground truth of a run: at the start, ten times a second and whenever something changes."""

    truths: tuple[Truth, ...]
    """The ground truth at each instant."""

    def __call__(self) -> GroundTruth:
        """Return itself: ``truth`` of a run or a recording is read with or without parentheses."""
        return self

    def __len__(self) -> int:
        return len(self.truths)

    def __repr__(self) -> str:
        return f"<GroundTruth: {len(self)} times, at the end {summary_of(self.faults)}>"

    @staticmethod
    def of(truths: Sequence[Truth]) -> GroundTruth:
        """Return the ground truth of some instants."""
        return GroundTruth(tuple(truths))

    @property
    def time(self) -> Floats:
        """Simulated time, shape (times,) [s]."""
        return np.array([truth.time_ns * 1e-9 for truth in self.truths])

    @property
    def speed(self) -> Floats:
        """Speed of the inner ring, shape (times,) [rad/s]."""
        return np.array([truth.speed for truth in self.truths])

    @property
    def load(self) -> Floats:
        """Force on the inner ring in X and Y, shape (times, 2) [N]."""
        return np.array([truth.load for truth in self.truths], np.float64).reshape(-1, 2)

    @property
    def faults(self) -> Mapping[str, Mapping[str, Any]]:
        """The faults at the end by name, each with its fields and its onset [s]."""
        return self.truths[-1].faults if self.truths else {}

    def frequency(self, name: str) -> Floats:
        """Return FTF, BPFO, BPFI or BSF at the speed of each instant, shape (times,) [Hz].

        Raises
        ------
        Refusal
            Unknown name.
        """
        if not isinstance(name, str) or name not in FREQUENCIES:
            raise Refusal(
                f"there is no characteristic frequency {name!r}: give one of {', '.join(FREQUENCIES)}{nearest(str(name), FREQUENCIES)}"
            )
        return np.array([truth.frequencies[name] for truth in self.truths])

    def thermal(self, name: str) -> Floats:
        """Return a temperature, heat or loss by its name with the unit, such as ``box [deg C]``, shape (times,); NaN where there is none.

        Raises
        ------
        Refusal
            No instant has such a number.
        """
        known = list(dict.fromkeys(key for truth in self.truths for key in truth.thermal))
        if name not in known:
            has = f"it has {', '.join(known)}" if known else "it has no temperatures: simulate with thermal.law = network"
            raise Refusal(f"the ground truth has no {name!r}{nearest(str(name), known)}: {has}")
        return np.array([truth.thermal.get(name, np.nan) for truth in self.truths])

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame over time [s]: speed [rad/s], load [N], characteristic frequencies [Hz], names of the faults and the event.

        Temperatures, heat and lost lubricant follow in columns whose names contain the unit, such as ``box [deg C]``, where there are any.

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        rows = [
            {
                "speed": truth.speed,
                "load_x": truth.load[0],
                "load_y": truth.load[1],
                **truth.frequencies,
                "faults": ", ".join(truth.faults),
                "event": encode_event(truth.event),
                **truth.thermal,
            }
            for truth in self.truths
        ]
        return pandas().DataFrame(rows, index=pandas().Index(self.time, name="time"))


def commands_in(truths: Iterable[Truth]) -> list[TimedCommand]:
    """Return the commands that took effect according to the ground truth."""
    commands = (SpeedCommand, LoadCommand, ParameterChange, UnknownCommand)
    return [TimedCommand(truth.time_ns, truth.event) for truth in truths if isinstance(truth.event, commands)]
