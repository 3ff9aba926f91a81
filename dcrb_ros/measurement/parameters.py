"""Parameters of the accelerometer that several stages depend on."""

from __future__ import annotations

from typing import Literal

from dcrb_ros.schema.fields import Group, choice, quantity

GRAVITY = 9.80665
"""Standard gravity, the unit of acceleration in data sheets [m/s^2]."""
MICRO_G = 1e-6 * GRAVITY
"""One ug [m/s^2]."""

SensorFault = Literal["none", "stuck", "loose", "saturated", "spikes", "dead", "gain_drift"]
AXES = {"both": (0, 1), "x": (0,), "y": (1,)}
"""Columns of the samples that a fault of the sensor affects."""


class Accelerometer(Group):
    """Sampling, range and fault of the accelerometer."""

    sampling_rate: int = quantity(51200, "Hz", "Sampling rate", 1000, 204800, symbol="f_s")
    range: float = quantity(
        5000.0,
        "m/s^2",
        "Measuring range: larger accelerations are clipped and counted",
        1.0,
        1e6,
        remedy="give m/s^2, 1 g is 9.81 m/s^2",
        run_time=True,
    )
    fault: SensorFault = choice(
        "none", "Fault of the sensor: stuck, loose mount, saturated, spikes of a loose cable, dead, or gain_drift", run_time=True
    )
    fault_severity: float = quantity(
        1.0, "-", "Severity of the sensor fault; 0 for none", 0.0, 1.0, run_time=True, remedy="give a share, not per cent"
    )
    fault_axis: Literal["both", "x", "y"] = choice("both", "Axes with the sensor fault; a loose mount always affects both", run_time=True)
    fault_time: float = quantity(5.0, "s", "Time in which gain_drift reaches its severity", 0.001, 1e6, run_time=True)

    @property
    def present_fault(self) -> SensorFault:
        """The fault of the sensor, none at a severity of 0."""
        return self.fault if self.fault_severity > 0.0 else "none"

    def severity(self, fault: SensorFault) -> float:
        """Return the severity of a fault of the sensor, 0 if the sensor does not have it [-]."""
        return self.fault_severity if self.fault == fault else 0.0

    def described(self) -> dict[str, dict[str, float]]:
        """Return the fields of a fault of the sensor by its name in the ground truth, ``sensor.stuck``; axis 0 is both, 1 x, 2 y."""
        if self.present_fault == "none":
            return {}
        axis = "both" if self.fault == "loose" else self.fault_axis
        return {f"sensor.{self.fault}": {"severity": self.fault_severity, "axis": tuple(AXES).index(axis)}}
