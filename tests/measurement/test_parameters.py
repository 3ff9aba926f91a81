"""Defaults and ranges of the parameters of the measurement chain."""

from __future__ import annotations

from dcrb_ros.settings.files import parameter_fields

PUBLISHED: dict[str, tuple[float, float, float]] = {
    "sensor.sampling_rate": (51200, 1000, 204800),
    "sensor.range": (5000.0, 1.0, 1000000.0),
    "sensor.fault_severity": (1.0, 0.0, 1.0),
    "sensor.fault_time": (5.0, 0.001, 1000000.0),
    "structure.modes": (0, 0, 24),
    "structure.seed": (1, 0, 2147483647),
    "structure.mounting": (0, 0, 2147483647),
    "structure.coupling": (0.7, 0.0, 1.0),
    "structure.modulation": (0.0, 0.0, 1.0),
    "structure.gain_x": (1.0, 1e-06, 1000000.0),
    "structure.gain_y": (1.0, 1e-06, 1000000.0),
    "structure.path_spread": (0.0, 0.0, 20.0),
    "structure.bearing_share": (1.0, 1e-06, 1.0),
    "structure.noise_x": (0.0, 0.0, 1000000.0),
    "structure.noise_y": (0.0, 0.0, 1000000.0),
    "structure.healthy_level": (0.0, 0.0, 1000000.0),
    "structure.healthy_speed": (0.0, 0.0, 1000.0),
    "structure.background": (0.0, -60.0, 60.0),
    "structure.background_lines": (0.0, 0.0, 1.0),
    "structure.floor": (0.0, 0.0, 10.0),
    "background.unbalance": (0.0, 0.0, 0.01),
    "background.joint_level": (0.0, 0.0, 10000.0),
    "background.joint_spacing": (25.0, 1.0, 1000.0),
    "background.flat_level": (0.0, 0.0, 10000.0),
    "background.track_level": (0.0, 0.0, 1000.0),
    "background.track_low": (20.0, 1.0, 20000.0),
    "background.track_high": (1500.0, 2.0, 40000.0),
    "background.impact_rate": (0.0, 0.0, 1000.0),
    "background.impact_level": (200.0, 0.0, 100000.0),
    "background.gear_level": (0.0, 0.0, 1000.0),
    "background.gear_teeth": (87, 5, 200),
    "background.gear_modulation": (0.2, 0.0, 1.0),
    "background.motor_level": (0.0, 0.0, 1000.0),
    "background.motor_ratio": (4.14, 0.1, 20.0),
    "background.motor_pole_pairs": (2, 1, 12),
    "background.hum_level": (0.0, 0.0, 1000.0),
    "background.hum_frequency": (50.0, 10.0, 500.0),
    "sensor.mount_frequency": (0.0, 0.0, 90000.0),
    "sensor.mount_damping": (0.05, 0.001, 1.0),
    "sensor.bandwidth": (0.0, 0.0, 90000.0),
    "sensor.cross_axis": (0.0, 0.0, 0.5),
    "sensor.bias": (0.0, -10000.0, 10000.0),
    "sensor.bias_drift": (0.0, 0.0, 100.0),
    "sensor.ac_coupling": (0.0, 0.0, 100.0),
    "sensor.static_gravity": (0.0, -100.0, 100.0),
    "sensor.noise_density": (0.002, 0.0, 10.0),
    "sensor.white_noise_ug": (0.0, 0.0, 1000000.0),
    "sensor.pink_noise_ug": (0.0, 0.0, 1000000.0),
    "sensor.adc_bits": (24, 0, 32),
    "sensor.clock_offset_ppm": (0.0, -1000.0, 1000.0),
    "sensor.clock_jitter": (0.0, 0.0, 1e-05),
}
"""Default, least and largest value by key: users' files and recordings depend on them."""


def test_defaults_and_ranges_are_those_published() -> None:
    groups = ("structure.", "background.", "sensor.")
    found = {field.key: (field.default, field.low, field.high) for field in parameter_fields() if field.key.startswith(groups)}
    assert {key: values for key, values in found.items() if values[1] is not None} == PUBLISHED


RUN_TIME = {
    *("sensor.range", "sensor.fault", "sensor.fault_severity", "sensor.fault_axis", "sensor.fault_time", "sensor.adc_bits"),
    *("sensor.noise_density", "sensor.white_noise_ug", "sensor.pink_noise_ug"),
    *("background.unbalance", "background.joint_level", "background.flat_level", "background.track_level", "background.hum_level"),
    *("background.impact_rate", "background.impact_level", "background.gear_level", "background.motor_level"),
}
"""Parameters that may change while the simulation runs."""


def test_levels_range_and_faults_change_at_run_time_and_nothing_else() -> None:
    groups = ("structure.", "background.", "sensor.")
    assert {field.key for field in parameter_fields() if field.key.startswith(groups) and field.run_time} == RUN_TIME
