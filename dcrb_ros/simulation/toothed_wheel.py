"""The toothed wheel of a bench, from its configuration."""

from __future__ import annotations

from dcrb_ros.measurement.sample_clock import ClockParameters
from dcrb_ros.measurement.toothed_wheel import ToothedWheel
from dcrb_ros.settings.configuration import Configuration


def toothed_wheel_of(configuration: Configuration) -> ToothedWheel | None:
    """Return the toothed wheel on the shaft; None without pulses."""
    pulses, clock = configuration.tacho.pulses_per_turn, configuration.measurement.parameters[ClockParameters]
    return ToothedWheel(pulses, configuration.step_rate, clock.clock_offset_ppm) if pulses else None
