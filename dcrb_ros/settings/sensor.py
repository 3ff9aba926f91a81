"""What the user says about the way from the outer ring to the samples: structure, background and accelerometer."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Literal

from pydantic import model_validator

from dcrb_ros.schema.fields import Group, choice, quantity

GRAVITY = 9.80665
"""Standard gravity, by which data sheets count [m/s^2]."""
MICRO_G = 1e-6 * GRAVITY
"""One ug [m/s^2]."""
REFERENCE_SPEED = 20.0
"""Vehicle speed to which the levels of joints, flats and track noise belong [m/s], 72 km/h."""

SensorFault = Literal["none", "stuck", "loose", "saturated", "spikes", "dead", "gain_drift"]

TYPICAL: Mapping[str, Mapping[str, Any]] = {
    "none": {},
    "ideal": {"range": 1e6, "noise_density": 0.0, "adc_bits": 0},
    "iepe_100mv_g": {
        "range": 80.0 * GRAVITY,
        "noise_density": 0.0,
        "white_noise_ug": 4.0,
        "pink_noise_ug": 25.0,
        "mount_frequency": 25000.0,
        "mount_damping": 0.03,
        "cross_axis": 0.05,
        "ac_coupling": 0.5,
        "adc_bits": 24,
    },
    "mems": {
        "range": 100.0 * GRAVITY,
        "noise_density": 0.0,
        "white_noise_ug": 30.0,
        "pink_noise_ug": 100.0,
        "mount_frequency": 21000.0,
        "mount_damping": 0.05,
        "bandwidth": 11000.0,
        "cross_axis": 0.01,
        "bias": 1.0,
        "bias_drift": 0.01,
        "adc_bits": 16,
    },
}
"""Presets: an accelerometer without errors, an industrial one with 100 mV/g and IEPE supply, and a wide-band MEMS one."""


def typical(preset: str) -> dict[str, Any]:
    """Return all that presets set, as this one has it, by dotted key: for what is set on top of a whole configuration, of another preset.

    An unknown one sets nothing.
    """
    if preset not in (*TYPICAL, SensorParameters.model_fields["preset"].default):
        return {}
    keys = sorted({key for values in TYPICAL.values() for key in values})
    own = TYPICAL.get(preset, {})
    return {f"sensor.{key}": own.get(key, SensorParameters.model_fields[key].default) for key in keys}


def numbers(text: str, key: str) -> list[float]:
    """Return the numbers of a list in a text.

    Raises:
        ValueError: a word that is no number.
    """
    words = [word for word in re.split(r"[,\s]+", text) if word]
    try:
        return [float(word) for word in words]
    except ValueError:
        raise ValueError(f"{key}: '{text}' is no list of numbers; write them with commas, such as '900, 2300'") from None


class Structure(Group):
    """The path from outer ring to accelerometer: a bank of modes of the axle box."""

    modes: int = quantity(
        0, "-", "Modes of the axle box drawn by structure.seed, 500 to 8000 Hz, damping 1 to 5 %; 0 for a rigid path", 0, 24
    )
    seed: int = quantity(1, "-", "Seed of the axle box; the same box for every simulation.seed", 0, 2**31 - 1)
    frequencies: str = choice("", "Natural frequencies of given modes [Hz], such as '900, 2300, 5200', in place of drawn ones")
    dampings: str = choice("", "Damping ratio of each given mode [-], such as '0.02, 0.03, 0.01'; empty for 0.02 each")
    coupling: float = quantity(
        0.7,
        "-",
        "Share of the acceleration that goes through the modes; the rest goes straight",
        0.0,
        1.0,
        remedy="give a share, not per cent",
    )

    @property
    def on(self) -> bool:
        """Whether there is any mode."""
        return (self.modes > 0 or bool(self.frequencies.strip())) and self.coupling > 0.0


class Background(Group):
    """What a detector must live with: it shakes the axle box without any fault of the bearing. All off by default."""

    unbalance: float = quantity(
        0.0, "m", "Unbalance: amplitude over the square of the shaft speed; 1e-4 is 1.6 m/s^2 at 1200 rpm", 0.0, 0.01, run_time=True
    )
    joint_level: float = quantity(0.0, "m/s^2", "Peak of a rail joint's pulse at 72 km/h; grows with the speed", 0.0, 1e4, run_time=True)
    joint_spacing: float = quantity(25.0, "m", "Distance between rail joints", 1.0, 1000.0)
    flat_level: float = quantity(
        0.0, "m/s^2", "Peak of a wheel flat's pulse at 72 km/h, once a turn; grows with the speed", 0.0, 1e4, run_time=True
    )
    track_level: float = quantity(
        0.0, "m/s^2", "Random track noise at 72 km/h, rms per axis; grows with the speed", 0.0, 1e3, run_time=True
    )
    track_low: float = quantity(20.0, "Hz", "Lower edge of the track noise", 1.0, 20000.0)
    track_high: float = quantity(1500.0, "Hz", "Upper edge of the track noise", 2.0, 40000.0)
    impact_rate: float = quantity(0.0, "1/s", "Look-alike impacts a second, at random times", 0.0, 1000.0, run_time=True)
    impact_level: float = quantity(200.0, "m/s^2", "Mean peak of a look-alike impact, 0.1 ms long", 0.0, 1e5, run_time=True)
    hum_level: float = quantity(0.0, "m/s^2", "Mains hum in the cable: amplitude of the fundamental", 0.0, 1e3, run_time=True)
    hum_frequency: float = quantity(50.0, "Hz", "Mains frequency", 10.0, 500.0, remedy="50, 60 or 16.7 Hz")

    def described(self) -> dict[str, float]:
        """Return the levels of what is on, by key."""
        keys = ("unbalance", "joint_level", "flat_level", "track_level", "impact_rate", "hum_level")
        found = {key: float(getattr(self, key)) for key in keys if getattr(self, key) > 0.0}
        return found | ({"impact_level": self.impact_level} if self.impact_rate > 0.0 else {})


class SensorParameters(Group):
    """The accelerometer on the outer ring."""

    preset: Literal["none", "ideal", "iepe_100mv_g", "mems"] = choice(
        "none", "Typical values for the keys of this group that are not given: docs/measurement.md; none for the defaults below"
    )
    sampling_rate: int = quantity(51200, "Hz", "Sampling rate", 1000, 204800, symbol="f_s")
    range: float = quantity(
        5000.0,
        "m/s^2",
        "Range: larger accelerations are clipped and counted",
        1.0,
        1e6,
        remedy="give m/s^2, 1 g is 9.81 m/s^2",
        run_time=True,
    )
    noise_density: float = quantity(
        2e-3,
        "m/s^2/sqrt(Hz)",
        "White noise density (IEPE: 0.5e-3 to 4e-3, that is 50 to 400 ug/sqrt(Hz))",
        0.0,
        10.0,
        remedy="100 ug/sqrt(Hz) is 0.00098 m/s^2/sqrt(Hz)",
        run_time=True,
    )
    white_noise_ug: float = quantity(
        0.0, "ug/sqrt(Hz)", "White noise density as data sheets give it; its power adds to that of noise_density", 0.0, 1e6, run_time=True
    )
    pink_noise_ug: float = quantity(
        0.0, "ug/sqrt(Hz)", "1/f noise: density at 1 Hz, falling with the root of the frequency", 0.0, 1e6, run_time=True
    )
    adc_bits: int = quantity(24, "bit", "Resolution of the converter over the range; 0 for none", 0, 32, run_time=True)
    mount_frequency: float = quantity(0.0, "Hz", "Resonance of the sensor on its mount; 0 for rigid", 0.0, 90000.0)
    mount_damping: float = quantity(0.05, "-", "Damping ratio of that resonance", 0.001, 1.0)
    bandwidth: float = quantity(0.0, "Hz", "Second-order low-pass of the sensor, -3 dB; 0 for none", 0.0, 90000.0)
    cross_axis: float = quantity(0.0, "-", "Cross-axis sensitivity: share of the other axis", 0.0, 0.5, remedy="give a share, not per cent")
    ac_coupling: float = quantity(
        0.0, "Hz", "First-order high-pass of the supply, -3 dB; 0 for a sensor that sees constant acceleration", 0.0, 100.0
    )
    bias: float = quantity(0.0, "m/s^2", "Constant offset of both axes", -1e4, 1e4)
    bias_drift: float = quantity(0.0, "m/s^2/sqrt(s)", "Random walk of the offset: rms after one second", 0.0, 100.0)
    clock_offset_ppm: float = quantity(
        0.0, "ppm", "Sample clock: samples come so much later than their stamps say; negative for earlier", -1000.0, 1000.0
    )
    clock_jitter: float = quantity(0.0, "s", "Sample clock: rms error of a sample's time", 0.0, 1e-5, remedy="give seconds, 1 ns is 1e-9")
    fault: SensorFault = choice(
        "none", "Fault of the sensor: stuck, loose mounting, saturated, cable spikes, dead or gain_drift", run_time=True
    )
    fault_severity: float = quantity(
        1.0, "-", "Severity of that fault; 0 for none", 0.0, 1.0, run_time=True, remedy="give a share, not per cent"
    )
    fault_axis: Literal["both", "x", "y"] = choice("both", "Axes that the fault is in; a loose mounting is in both", run_time=True)
    fault_time: float = quantity(5.0, "s", "Time that gain_drift takes to its severity", 0.001, 1e6, run_time=True)

    @model_validator(mode="before")
    @classmethod
    def _typical(cls, given: Any) -> Any:
        """Fill in the preset's values for what is not given."""
        if not isinstance(given, Mapping) or not isinstance(given.get("preset"), str):
            return given
        return {**TYPICAL.get(given["preset"], {}), **given}

    def described(self) -> dict[str, dict[str, float]]:
        """Return the fields of a fault of the sensor by its name in the ground truth, ``sensor.stuck``; axis 0 is both, 1 x, 2 y."""
        if self.fault == "none" or self.fault_severity == 0.0:
            return {}
        return {f"sensor.{self.fault}": {"severity": self.fault_severity, "axis": ("both", "x", "y").index(self.fault_axis)}}
