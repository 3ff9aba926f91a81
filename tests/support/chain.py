"""The measurement chain without the simulation, for tests of its stages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.sensor import Measurement, Sensor
from dcrb_ros.measurement.stage import Parameters
from dcrb_ros.settings.configuration import Configuration

SPEED = 125.664
QUIET = {"noise_density": 0.0, "adc_bits": 0, "range": 1e6}
EVERYTHING: dict[str, Any] = {
    "structure": {"modes": 6},
    "background": {
        "unbalance": 1e-4,
        "joint_level": 40.0,
        "joint_spacing": 1.0,
        "flat_level": 30.0,
        "track_level": 4.0,
        "impact_rate": 500.0,
        "gear_level": 3.0,
        "motor_level": 2.0,
        "hum_level": 1.0,
    },
    "sensor": {"preset": "mems", "ac_coupling": 0.5, "clock_offset_ppm": 500.0, "clock_jitter": 1e-7, "fault": "spikes"},
}
"""Every stage at once."""


def chain(**groups: Any) -> Configuration:
    """Return a configuration whose sensor has no noise, clipping or rounding unless they are given."""
    sensor = groups.pop("sensor", {})
    return Configuration.model_validate({**groups, "sensor": sensor if "preset" in sensor else {**QUIET, **sensor}})


def changed(configuration: Configuration, *, background: Mapping[str, Any] | None = None, **sensor: Any) -> Parameters:
    """Return the parameters of a configuration after some changes to its sensor and its background."""
    present = configuration.measurement.parameters
    return Parameters(present.structure, present.background.model_copy(update=background), present.sensor.model_copy(update=sensor))


def at_rest(configuration: Configuration, seconds: float, speed: float = SPEED) -> Measurement:
    """Return the measurement of an outer ring at rest while the shaft turns at a speed [rad/s]."""
    count = round(seconds * configuration.step_rate)
    return measured(configuration, np.zeros((count, 2)), speed)


def measured(configuration: Configuration, acceleration: npt.NDArray[np.float64], speed: float = SPEED) -> Measurement:
    """Return the measurement of an acceleration at every time step, shape (steps, 2) [m/s^2]."""
    return Sensor(configuration.measurement).measure(acceleration, speed * np.arange(len(acceleration)) / configuration.step_rate)


def tone(configuration: Configuration, frequency: float, seconds: float) -> npt.NDArray[np.float64]:
    """Return a tone of amplitude 1 in X and in quadrature in Y, at the middle of each time step."""
    phase = 2.0 * np.pi * frequency * (np.arange(round(seconds * configuration.step_rate)) + 0.5) / configuration.step_rate
    return np.stack([np.sin(phase), np.cos(phase)], axis=1)


def amplitude(samples: npt.NDArray[np.float64], frequency: float, rate: float) -> float:
    """Return the amplitude of a tone in samples over a whole number of its periods."""
    return 2.0 * float(abs(np.mean(samples * np.exp(-2j * np.pi * frequency * np.arange(len(samples)) / rate))))
