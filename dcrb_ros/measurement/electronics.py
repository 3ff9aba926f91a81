"""What happens to a sampled signal before its converter: cross-axis sensitivity, hum, offset and alternating-current coupling."""

from __future__ import annotations

import numpy as np

from dcrb_ros.measurement.background import Hum
from dcrb_ros.measurement.filters import Filter, high_pass
from dcrb_ros.measurement.streams import stream
from dcrb_ros.measurement.timetable import Timetable
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration


class Electronics:
    """The stages in their order; those that are off cost nothing. Linear, so they may stand behind the anti-alias filter."""

    def __init__(self, configuration: Configuration) -> None:
        c, rate = configuration, float(configuration.sensor.sampling_rate)
        self._cross = c.sensor.cross_axis
        self._hum, self._hum_level = Hum(c), c.background.hum_level
        self._offset = np.full(2, c.sensor.bias)
        self._walk = c.sensor.bias_drift / np.sqrt(rate)
        self._random = stream(c.simulation.seed, "bias_drift")
        self._high_pass = Filter(high_pass(c.sensor.ac_coupling, rate)) if c.sensor.ac_coupling > 0.0 else None
        self.hum_levels: Timetable[float] = Timetable(self._set)
        """Changes of the hum's level [m/s^2] by the sample at which they come."""

    def _set(self, hum_level: float) -> None:
        self._hum_level = hum_level

    def feed(self, samples: Floats) -> Floats:
        """Return what comes out for samples of shape (samples, 2) [m/s^2]."""
        present = self._crossed(samples) if self._cross else samples
        first = self.hum_levels.reached
        for piece in self.hum_levels.pieces(len(samples)):
            if self._hum_level > 0.0:
                present = present.copy() if present is samples else present
                hum = self._hum.feed(first + piece.start, piece.stop - piece.start, self._hum_level)
                for axis in (0, 1):
                    present[piece, axis] += hum
        if self._walk > 0.0:
            present = present + self._drifting(len(samples))
        elif self._offset.any():
            present = present + self._offset
        return self._high_pass.feed(present) if self._high_pass is not None else present

    def _crossed(self, samples: Floats) -> Floats:
        """Return what each axis has of the other, with its own."""
        crossed: Floats = samples.copy()
        for axis in (0, 1):
            crossed[:, axis] += self._cross * samples[:, 1 - axis]
        return crossed

    def _drifting(self, count: int) -> Floats:
        """Return the offset of the next samples, a random walk, shape (samples, 2) [m/s^2]."""
        steps = self._walk * self._random.standard_normal((count, 2))
        path: Floats = np.empty((count + 1, 2))
        for axis in (0, 1):
            np.cumsum(np.concatenate([self._offset[axis : axis + 1], steps[:, axis]]), out=path[:, axis])
        self._offset = path[-1]
        return path[1:]
