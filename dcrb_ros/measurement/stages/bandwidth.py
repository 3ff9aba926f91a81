"""The bandwidth of the sensor: a second-order Butterworth low-pass."""

from __future__ import annotations

from collections.abc import Iterator

from dcrb_ros.measurement.filters import Filter, above_step_rate, low_pass
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

LOWEST_BANDWIDTH = 10.0
"""Lowest bandwidth accepted [Hz]: a smaller number is taken for kilohertz."""


class BandwidthParameters(Group):
    """Bandwidth of the sensor."""

    bandwidth: float = quantity(0.0, "Hz", "Bandwidth of the sensor: -3 dB frequency of a second-order low-pass; 0 for none", 0.0, 90000.0)


class Bandwidth(Stage):
    """Second-order Butterworth low-pass, -3 dB at the bandwidth."""

    parameters = BandwidthParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        bandwidth = setup.parameters[BandwidthParameters].bandwidth
        self._filter = Filter(low_pass(bandwidth, rate)) if bandwidth > 0.0 else None

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        bandwidth = parameters[BandwidthParameters].bandwidth
        yield from above_step_rate("sensor.bandwidth", bandwidth, step_rate)
        if 0.0 < bandwidth < LOWEST_BANDWIDTH:
            yield f"sensor.bandwidth = {bandwidth:g} Hz is below {LOWEST_BANDWIDTH:g} Hz: give 0.0 for no low-pass, or more Hz"

    @property
    def active(self) -> bool:
        return self._filter is not None

    def process(self, acceleration: Floats, span: Span) -> Floats:
        return acceleration if self._filter is None else self._filter.process(acceleration)
