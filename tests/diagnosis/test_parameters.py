"""Ranges of the parameters of the detector; their defaults are those of `config/detector.yaml`."""

from __future__ import annotations

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.settings.files import parameter_fields

PUBLISHED: dict[str, tuple[float, float]] = {
    "window": (0.5, 60.0),
    "least_window": (0.5, 60.0),
    "hop": (0.05, 60.0),
    "least_turns": (4.0, 1000.0),
    "longest_gap": (0.0, 10.0),
    "most_missing": (0.0, 0.9),
    "band_low": (100.0, 90000.0),
    "band_high": (200.0, 100000.0),
    "slip": (0.0, 0.05),
    "slowest": (0.5, 500.0),
    "fastest": (1.0, 500.0),
    "whitening": (0.0, 100000.0),
    "speed_score": (0.0, 500.0),
    "speed_rival": (0.0, 1.0),
    "speed_exponent": (0.0, 4.0),
    "confirm": (1, 100),
    "release": (1, 1000),
    "release_margin": (0.0, 20.0),
    "alarm_evidence": (0.0, 20.0),
    "trend_time": (1.0, 1000000.0),
    "false_alarm": (1e-12, 0.1),
    "shadow": (0.0, 1.0),
    "ring_contrast": (0.0, 20.0),
    "outer_depth": (0.0, 2.0),
    "cage_contrast": (0.0, 20.0),
    "outer_double": (0.0, 20.0),
    "outer_limit": (0.0, 1000000.0),
    "outer_limit_high": (0.0, 1000000.0),
    "learn": (0.0, 100000.0),
    "learn_margin": (0.0, 40.0),
    "inner_depth": (0.0, 2.0),
    "roller_depth": (0.0, 2.0),
    "cage_depth": (0.0, 2.0),
    "most_senseless": (0.0, 1.0),
    "silence": (0.0, 10000.0),
    "stuck_time": (1e-05, 1.0),
    "stuck_share": (0.0, 1.0),
    "most_clipped": (0.0, 1.0),
    "least_clipped": (0.0, 1.0),
    "range_share": (0.0, 1.0),
    "dead_level": (0.0, 60.0),
    "dead_white": (0.0, 60.0),
    "dead_fall": (0.0, 120.0),
    "dead_kurtosis": (3.0, 100.0),
    "spike_height": (5.0, 10000.0),
    "spike_quiet": (0.0, 1.0),
    "spike_front": (0.0, 1.0),
    "spike_swing": (0.0, 1.0),
    "spike_time": (1e-05, 0.1),
    "most_spikes": (1, 100000),
    "gain_drop": (0.5, 60.0),
    "gain_spread": (0.01, 10.0),
    "loose_level": (-120.0, 0.0),
    "loose_drop": (1.0, 60.0),
    "loose_fall": (0.0, 60.0),
    "firm_level": (-120.0, 60.0),
}
"""Least and largest value by key: users' files depend on them."""


def test_ranges_are_those_published() -> None:
    found = {field.key: (field.low, field.high) for field in parameter_fields(DetectorParameters) if field.low is not None}
    assert found == PUBLISHED
