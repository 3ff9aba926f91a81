"""The mount of the sensor: a resonance, which falls when the mount is loose."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dcrb_ros.measurement.filters import Filter, above_step_rate, resonance
from dcrb_ros.measurement.parameters import Accelerometer
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

LOOSE_FREQUENCY = 8000.0
"""Highest resonance of a mount that starts to come loose [Hz]; it falls to a tenth at full severity."""
LOOSE_DAMPING = 0.1
"""Damping ratio of a loose mount [-]."""
LOWEST_FREQUENCY = 100.0
"""Lowest resonance accepted [Hz]: a smaller number is taken for kilohertz."""


class MountParameters(Group):
    """Resonance of the mounted sensor."""

    mount_frequency: float = quantity(0.0, "Hz", "Resonance frequency of the sensor on its mount; 0 for a rigid mount", 0.0, 90000.0)
    mount_damping: float = quantity(0.05, "-", "Damping ratio of that resonance", 0.001, 1.0)


class Mount(Stage):
    """Second-order resonance w^2 / (s^2 + 2 zeta w s + w^2) of the sensor on its mount."""

    parameters = MountParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._filter: Filter | None = None
        self._resonance = (0.0, 0.0)
        self._last: tuple[Floats, Floats] | None = None
        """The last two samples before and behind the mount, each of shape (2, axes) [m/s^2]; None of a rigid mount."""
        self._changed = False

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        frequency = parameters[MountParameters].mount_frequency
        yield from above_step_rate("sensor.mount_frequency", frequency, step_rate)
        if 0.0 < frequency < LOWEST_FREQUENCY:
            yield (
                f"sensor.mount_frequency = {frequency:g} Hz is below {LOWEST_FREQUENCY:g} Hz: "
                "give 0.0 for a rigid mount, or a higher frequency in Hz"
            )

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        """Replace the filter if the resonance changes; it continues from the last samples, so that a change is no impact."""
        mount, loose = parameters[MountParameters], parameters[Accelerometer].severity("loose")
        frequency, damping = mount.mount_frequency, mount.mount_damping
        if loose:
            frequency, damping = min(frequency or LOOSE_FREQUENCY, LOOSE_FREQUENCY) * 0.1**loose, LOOSE_DAMPING
        if (frequency, damping) != self._resonance:
            self._filter = Filter(resonance(frequency, damping, self.rate)) if frequency > 0.0 else None
            self._last, self._changed = self._last if self._filter else None, tick > 0
        self._resonance = frequency, damping

    @property
    def active(self) -> bool:
        return self._filter is not None

    def process(self, acceleration: Floats, span: Span) -> Floats:
        if self._filter is None or not len(acceleration):
            return acceleration
        before = self._last or (acceleration[[0, 0]], acceleration[[0, 0]])
        if self._changed:
            self._filter.continue_from(*before)
            self._changed = False
        after = self._filter.process(acceleration)
        self._last = np.concatenate([before[0], acceleration[-2:]])[-2:], np.concatenate([before[1], after[-2:]])[-2:]
        return after
