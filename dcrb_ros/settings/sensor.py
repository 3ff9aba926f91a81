"""The groups of the measurement chain, whose fields are declared by the stages that use them, and the tacho."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import model_validator

from dcrb_ros.measurement.parameters import GRAVITY, Accelerometer
from dcrb_ros.measurement.registry import parameters_of
from dcrb_ros.schema.composition import with_fields_of
from dcrb_ros.schema.fields import Group, choice, quantity

PRESETS: Mapping[str, Mapping[str, Any]] = {
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
        "static_gravity": GRAVITY,
        "cross_axis": 0.01,
        "bias": 1.0,
        "bias_drift": 0.01,
        "adc_bits": 16,
    },
}
"""Typical sensors: one without errors, an industrial accelerometer with 100 mV/g and IEPE supply, a wide-band MEMS accelerometer."""


def preset_values(preset: str) -> dict[str, Any]:
    """Return the value of every key that any preset sets, by dotted key, as one preset has it or else the default.

    These are the changes from a configuration with another preset. An unknown preset changes nothing.
    """
    if preset not in PRESETS:
        return {}
    keys = sorted({key for values in PRESETS.values() for key in values})
    return {f"sensor.{key}": PRESETS[preset].get(key, SensorParameters.model_fields[key].default) for key in keys}


def as_recorded(configuration: Any) -> Any:
    """Return the configuration of a recording without what its preset has come to set since it was written.

    A manifest names every parameter of its time, so that a missing one had no effect.
    """
    sensor = configuration.get("sensor") if isinstance(configuration, Mapping) else None
    if not isinstance(sensor, Mapping) or "static_gravity" in sensor:
        return configuration
    return {**configuration, "sensor": {**sensor, "static_gravity": 0.0}}


@with_fields_of(parameters_of("structure"))
class Structure(Group):
    """The path from outer ring to accelerometer: a bank of modes of the axle box."""


@with_fields_of(parameters_of("background"))
class Background(Group):
    """Vibration of the axle box that no fault of the bearing causes. All levels are off by default."""

    def described(self) -> dict[str, float]:
        """Return the levels above zero, which are the fields that change at run time, by key."""
        extra = {key: field.json_schema_extra for key, field in type(self).model_fields.items()}
        levels = [key for key, about in extra.items() if isinstance(about, dict) and about.get("run_time")]
        present = {key: float(getattr(self, key)) for key in levels if getattr(self, key) > 0.0}
        impact_level = present.pop("impact_level", 0.0)
        return present | ({"impact_level": impact_level} if "impact_rate" in present else {})


class Preset(Group):
    """Choice of a typical sensor."""

    preset: Literal[tuple(PRESETS)] = choice(  # type: ignore[valid-type]
        "none", "Typical sensor: values for the parameters of this group that are not given; none for the defaults below"
    )


@with_fields_of(parameters_of("sensor"))
class SensorParameters(Accelerometer, Preset):
    """The accelerometer on the outer ring."""

    @model_validator(mode="before")
    @classmethod
    def _fill_in_preset(cls, given: Any) -> Any:
        """Add the preset's values for the keys that are not given."""
        if not isinstance(given, Mapping) or not isinstance(given.get("preset"), str):
            return given
        return {**PRESETS.get(given["preset"], {}), **given}


class Tacho(Group):
    """A toothed wheel on the shaft, as the wheel speed sensor of an axle box has one."""

    pulses_per_turn: int = quantity(
        0, "-", "Pulses of the tacho per turn of the shaft; 0 for no tacho, since the waveform has the angle of the shaft", 0, 10000
    )
