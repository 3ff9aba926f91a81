"""What the temperature sensors of an axle box read over time, as arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.arguments import number
from dcrb_ros.schema.arrays import Floats

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class TemperatureReadings:
    """Readings of the temperature sensors, one per second; empty arrays without a thermal network.

    The temperatures of all bodies without lag and noise are in the states and the ground truth.
    """

    time: Floats
    """Time of each reading, shape (readings,) [s]."""
    outer_ring: Floats
    """At the outer ring of the last row, without lag, shape (readings,) [deg C]; NaN where it was not recorded, as the others."""
    box: Floats
    """In the housing of the axle box over the load zone, with the lag of ``thermal.sensor_lag``, shape (readings,) [deg C]."""
    ambient: Floats
    """In the air, shape (readings,) [deg C]."""

    @classmethod
    def none(cls) -> TemperatureReadings:
        """Return no readings."""
        return cls(**{field.name: np.zeros(0) for field in fields(cls)})

    def __call__(self) -> TemperatureReadings:
        """Return itself: ``temperatures`` of a run or a recording is read with or without parentheses."""
        return self

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        if not len(self):
            return "<TemperatureReadings: none>"
        return f"<TemperatureReadings: {len(self)} from {self.time[0]:.4g} to {self.time[-1]:.4g} s, at the end {self.to_words(-1)}>"

    def to_words(self, number: int) -> str:
        """Return a reading of all sensors as text, "unknown" of a sensor that has none."""
        values = {field.name: float(getattr(self, field.name)[number]) for field in fields(self) if field.name != "time"}
        return ", ".join(f"{sensor} unknown" if math.isnan(value) else f"{sensor} {value:.4g} deg C" for sensor, value in values.items())

    def between(self, start: float, stop: float) -> TemperatureReadings:
        """Return the readings with ``start <= time < stop`` [s]; there may be none.

        Raises
        ------
        Refusal
            ``start`` or ``stop`` is not a number.
        """
        number("start", start)
        number("stop", stop)
        inside = (self.time >= start) & (self.time < stop)
        return TemperatureReadings(**{field.name: getattr(self, field.name)[inside] for field in fields(self)})

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame over time [s] with the columns outer_ring, box and ambient [deg C].

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        columns = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "time"}
        return pandas().DataFrame(columns, index=pandas().Index(self.time, name="time"))
