"""What happens to the acceleration before it is sampled, at every time step: background, structure, mount, bandwidth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.measurement.background import Shaking
from dcrb_ros.measurement.filters import Filter, low_pass, resonance
from dcrb_ros.measurement.structure import sections
from dcrb_ros.measurement.timetable import Timetable
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.sensor import Background, SensorParameters

LOOSE_FREQUENCY = 8000.0
"""Resonance of a mount that is about to come loose [Hz]; it falls to a tenth with the severity."""
LOOSE_DAMPING = 0.1
"""Damping ratio of a loose mount [-]."""
RATTLE = 0.3
"""Share by which a fully loose mount passes one direction more than the other [-]."""


class Surroundings(NamedTuple):
    """What may change while the bench runs."""

    sensor: SensorParameters
    background: Background


class Path:
    """From the axle box to the sensor's terminals: structure, mount and bandwidth, axis by axis."""

    def __init__(self, configuration: Configuration) -> None:
        c, rate = configuration, float(configuration.step_rate)
        self._rate = rate
        self._structure = [Filter(axis, columns=1) for axis in sections(c.structure, rate)] if c.structure.on else []
        self._low_pass = Filter(low_pass(c.sensor.bandwidth, rate)) if c.sensor.bandwidth > 0.0 else None
        self._mount: Filter | None = None
        self._mounted = (0.0, 0.0)
        self._rattle = 0.0
        self.set(c.sensor)

    def set(self, sensor: SensorParameters) -> None:
        """Mount the sensor as its parameters say; a mount that stays alike goes on swinging."""
        loose = sensor.fault_severity if sensor.fault == "loose" else 0.0
        frequency, damping = (LOOSE_FREQUENCY * 0.1**loose, LOOSE_DAMPING) if loose else (sensor.mount_frequency, sensor.mount_damping)
        if (frequency, damping) != self._mounted:
            self._mount = Filter(resonance(frequency, damping, self._rate)) if frequency > 0.0 else None
        self._mounted, self._rattle = (frequency, damping), RATTLE * loose

    @property
    def on(self) -> bool:
        """Whether anything happens on the way."""
        return bool(self._structure) or self._mount is not None or self._low_pass is not None

    def feed(self, acceleration: Floats) -> Floats:
        """Return what arrives of an acceleration, shape (steps, 2) [m/s^2]."""
        present = acceleration
        if self._structure:
            axes = (bank.feed(present[:, axis : axis + 1]) for axis, bank in enumerate(self._structure))
            present = np.concatenate(list(axes), axis=1)
        for stage in (self._mount, self._low_pass):
            present = stage.feed(present) if stage is not None else present
        return present + self._rattle * np.abs(present) if self._rattle else present


class Analog:
    """The stages before sampling in their order; those that are off cost nothing."""

    def __init__(self, configuration: Configuration) -> None:
        c = configuration
        self._path, self._shaking = Path(c), Shaking(c)
        self._turned: float | None = None
        self._first_turn = c.operating.speed / c.step_rate
        self.changes: Timetable[Surroundings] = Timetable(self._set)
        """Changes by the time step at which they come."""

    def _set(self, surroundings: Surroundings) -> None:
        self._path.set(surroundings.sensor)
        self._shaking.background = surroundings.background

    def touches(self, count: int) -> bool:
        """Return whether anything happens to the acceleration of the next ``count`` steps."""
        return self._path.on or self._shaking.on or self.changes.due(count)

    def feed(self, acceleration: Floats, angle: Floats) -> Floats:
        """Return what comes out for the outer ring's acceleration, shape (steps, 2) [m/s^2], while the shaft is at ``angle`` [rad]."""
        if not len(angle):
            return acceleration
        before = float(angle[0]) - self._first_turn if self._turned is None else self._turned
        self._turned = float(angle[-1])
        touched, first = self.touches(len(angle)), self.changes.reached
        turned = np.concatenate([[before], angle]) if touched else angle
        arriving = np.empty_like(acceleration) if touched else acceleration
        for piece in self.changes.pieces(len(acceleration)):
            present = acceleration[piece]
            if self._shaking.on:
                present = present + self._shaking.feed(first + piece.start, turned[piece.start : piece.stop + 1])
            if touched:
                arriving[piece] = self._path.feed(present)
        return arriving
