"""What happens to the acceleration before it is sampled, at every time step: background, structure, mount, bandwidth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.configuration import Configuration
from dcrb_ros.measurement.background import Shaking
from dcrb_ros.measurement.filters import Filter, Floats, low_pass, resonance
from dcrb_ros.measurement.structure import ModeBank
from dcrb_ros.measurement.timetable import Timetable
from dcrb_ros.sensing import Background, SensorParameters

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


class Mount:
    """The sensor on its mount: rigid, resonant or loose."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._filter: Filter | None = None
        self._like: tuple[float, float] | None = None
        self._rattle = 0.0

    def set(self, sensor: SensorParameters) -> None:
        """Mount the sensor as its parameters say; what stays alike goes on swinging."""
        loose = sensor.fault_severity if sensor.fault == "loose" else 0.0
        frequency, damping = sensor.mount_frequency, sensor.mount_damping
        if loose > 0.0:
            frequency, damping = LOOSE_FREQUENCY * 0.1**loose, LOOSE_DAMPING
        self._rattle = RATTLE * loose
        like = (frequency, damping)
        if like != self._like:
            self._filter = Filter(resonance(*like, self._rate)) if frequency > 0.0 else None
            self._like = like

    @property
    def on(self) -> bool:
        """Whether the mount is anything but rigid."""
        return self._filter is not None

    def feed(self, acceleration: Floats) -> Floats:
        """Return the acceleration of the sensor, shape (steps, 2) [m/s^2]."""
        if self._filter is None:
            return acceleration
        swinging = self._filter.feed(acceleration)
        return swinging + self._rattle * np.abs(swinging) if self._rattle else swinging


class Analog:
    """The stages before sampling in their order; those that are off cost nothing."""

    def __init__(self, configuration: Configuration) -> None:
        c, rate = configuration, float(configuration.step_rate)
        self._step = 1.0 / rate
        self._start_speed = c.operating.speed
        self._shaking = Shaking(c)
        self._structure = ModeBank(c.structure, rate) if c.structure.on else None
        self._mount = Mount(rate)
        self._low_pass = Filter(low_pass(c.sensor.bandwidth, rate)) if c.sensor.bandwidth > 0.0 else None
        self._turned: float | None = None
        self.changes: Timetable[Surroundings] = Timetable(self._set)
        """Changes by the time step at which they come."""
        self._set(Surroundings(c.sensor, c.background))

    def _set(self, surroundings: Surroundings) -> None:
        self._mount.set(surroundings.sensor)
        self._shaking.background = surroundings.background

    def touches(self, count: int) -> bool:
        """Return whether anything happens to the acceleration of the next ``count`` steps."""
        steady = self._structure is not None or self._low_pass is not None
        return steady or self._mount.on or self._shaking.on or self.changes.due(count)

    def feed(self, acceleration: Floats, angle: Floats) -> Floats:
        """Return what comes out for the outer ring's acceleration, shape (steps, 2) [m/s^2], while the shaft is at ``angle`` [rad]."""
        before = self._before(angle)
        turned = np.concatenate([[before], angle])
        arriving = np.empty_like(acceleration)
        first = self.changes.reached
        for piece in self.changes.pieces(len(acceleration)):
            present = acceleration[piece]
            if self._shaking.on:
                present = present + self._shaking.feed(first + piece.start, turned[piece.start : piece.stop + 1])
            for stage in (self._structure, self._mount, self._low_pass):
                present = stage.feed(present) if stage is not None else present
            arriving[piece] = present
        return arriving

    def _before(self, angle: Floats) -> float:
        """Return the shaft's angle at the step before [rad], and keep the last one of these."""
        before = self._turned
        if before is None:
            before = float(angle[0]) - self._start_speed * self._step if len(angle) else 0.0
        if len(angle):
            self._turned = float(angle[-1])
        return before
