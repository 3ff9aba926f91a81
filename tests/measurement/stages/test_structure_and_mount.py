"""Stages between the outer ring and the electronics: modes of the axle box, mount, bandwidth, cross-axis sensitivity and bias."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from chain import amplitude, at_rest, chain, measured, tone

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Span
from dcrb_ros.measurement.stages.bias import Bias
from dcrb_ros.measurement.stages.mount import Mount
from dcrb_ros.measurement.stages.rattle import Rattle
from dcrb_ros.measurement.stages.structure import AxleBox, modes
from dcrb_ros.settings.sensor import Structure

RATE = 51200.0


def problems(**groups: Any) -> list[str]:
    """Return what the stages of the axle box and of the mount say about parameters, at a step rate of 102400 Hz."""
    from dcrb_ros.measurement.registry import STAGES
    from dcrb_ros.measurement.stage import Parameters

    present = chain().measurement.parameters
    structure, background, sensor = (
        getattr(present, name).model_copy(update=groups.get(name, {})) for name in ("structure", "background", "sensor")
    )
    parameters = Parameters(structure, background, sensor)
    return [sentence for stage in STAGES for sentence in stage.problems(parameters, 102400)]


def test_one_mode_is_drawn_in_each_of_equal_intervals_of_the_logarithm() -> None:
    for seed in range(20):
        found = modes(Structure(modes=8, seed=seed))
        places = 8.0 * np.log([mode.frequency / 500.0 for mode in found]) / math.log(8000.0 / 500.0)
        assert np.floor(places).tolist() == list(range(8))
        assert all(0.01 <= mode.damping <= 0.05 for mode in found)


def test_random_dampings_and_shares_fill_their_ranges() -> None:
    """Shares are drawn from 0.2 to 1 before they are scaled to a sum of 1."""
    found = [modes(Structure(modes=24, seed=seed)) for seed in range(30)]
    dampings = np.array([mode.damping for box in found for mode in box])
    assert (dampings.min(), dampings.max()) == (pytest.approx(0.01, abs=5e-4), pytest.approx(0.05, abs=5e-4))
    shares = np.array([[mode.share for mode in box] for box in found])
    assert shares.sum(axis=1) == pytest.approx(1.0)
    assert 4.0 < (shares.max(axis=1) / shares.min(axis=1)).max() <= 5.0


def test_given_modes_without_dampings_have_two_per_cent() -> None:
    assert [mode.damping for mode in modes(Structure(frequencies="900, 2300 5200"))] == [0.02, 0.02, 0.02]


@pytest.mark.parametrize(
    ("structure", "present"),
    [
        ({}, False),
        ({"modes": 1}, True),
        ({"frequencies": "900"}, True),
        ({"frequencies": " "}, False),
        ({"modes": 3, "coupling": 0.0}, False),
        ({"modes": 3, "coupling": 0.01}, True),
    ],
)
def test_the_axle_box_is_skipped_without_modes_or_coupling(structure: dict[str, Any], present: bool) -> None:
    assert AxleBox(chain(structure=structure).measurement, RATE).active is present


@pytest.mark.parametrize(
    ("groups", "sentence"),
    [
        ({"structure": {"frequencies": "50, 20000", "dampings": "0.001, 0.5"}}, ""),
        ({"structure": {"frequencies": "49.9"}}, "structure.frequencies: 49.9 Hz is outside 50 .. 20000 Hz"),
        ({"structure": {"frequencies": "20001"}}, "structure.frequencies: 20001 Hz is outside 50 .. 20000 Hz"),
        ({"structure": {"frequencies": "900", "dampings": "0.0009"}}, "structure.dampings: 0.0009 is outside 0.001 .. 0.5"),
        ({"structure": {"frequencies": "900", "dampings": "0.51"}}, "structure.dampings: 0.51 is outside 0.001 .. 0.5"),
        ({"structure": {"frequencies": "900 " * 24}}, ""),
        ({"structure": {"frequencies": "900 " * 25}}, "structure.frequencies has 25 numbers; at most 24 are allowed"),
        ({"structure": {"frequencies": "900 1000", "dampings": "0.1"}}, "structure.dampings has 1 numbers for 2"),
        ({"sensor": {"mount_frequency": 100.0}}, ""),
        ({"sensor": {"mount_frequency": 0.0}}, ""),
        ({"sensor": {"mount_frequency": 99.0}}, "sensor.mount_frequency = 99 Hz is below 100 Hz"),
        ({"sensor": {"mount_frequency": 46081.0}}, "sensor.mount_frequency = 46081 Hz is above 46080 Hz"),
        ({"sensor": {"mount_frequency": 0.5}}, "sensor.mount_frequency = 0.5 Hz is below 100 Hz"),
        ({"sensor": {"bandwidth": 10.0}}, ""),
        ({"sensor": {"bandwidth": 9.9}}, "sensor.bandwidth = 9.9 Hz is below 10 Hz"),
        ({"sensor": {"bandwidth": 0.5}}, "sensor.bandwidth = 0.5 Hz is below 10 Hz"),
        ({"sensor": {"bandwidth": 46081.0}}, "sensor.bandwidth = 46081 Hz is above 46080 Hz"),
        ({"background": {"track_low": 1000.0, "track_high": 1200.0}}, ""),
        ({"background": {"track_low": 1000.0, "track_high": 1199.0}}, "background.track_high = 1199 Hz is less than 1.2 times"),
        ({"background": {"track_high": 46081.0}}, "background.track_high = 46081 Hz is above 46080 Hz"),
    ],
)
def test_limits_of_the_stages_are_inclusive(groups: dict[str, dict[str, Any]], sentence: str) -> None:
    found = problems(**groups)
    assert len(found) == bool(sentence)
    assert all(sentence in one for one in found)


@pytest.mark.parametrize(("severity", "frequency"), [(1.0, 800.0), (0.5, 8000.0 / math.sqrt(10.0)), (0.1, 8000.0 * 0.1**0.1)])
def test_the_resonance_of_a_loose_mount_falls_to_a_tenth_with_ten_per_cent_damping(severity: float, frequency: float) -> None:
    setup = chain(sensor={"fault": "loose", "fault_severity": severity}).measurement
    mount = Mount(setup, 102400.0)
    mount.set_parameters(setup.parameters, 0)
    count = 40960
    turns = 2.0 * np.pi * frequency * np.arange(count) / 102400.0
    out = mount.process(np.stack([np.sin(turns), np.cos(turns)], axis=1), Span(0, np.zeros(count + 1)))
    assert np.abs(out[-5000:, 0]).max() == pytest.approx(5.0, rel=0.01)  # 1 / (2 zeta)


@pytest.mark.parametrize(("severity", "share"), [(1.0, 0.3), (0.5, 0.15)])
def test_a_loose_mount_transmits_pulling_and_pushing_differently(severity: float, share: float) -> None:
    setup = chain(sensor={"fault": "loose", "fault_severity": severity}).measurement
    rattle = Rattle(setup, RATE)
    rattle.set_parameters(setup.parameters, 0)
    found = rattle.process(np.array([[2.0, -2.0], [0.0, 1.0]]), Span(0, np.zeros(3)))
    assert found == pytest.approx(np.array([[2.0 + 2.0 * share, -2.0 + 2.0 * share], [0.0, 1.0 + share]]))


def test_cross_axis_sensitivity_works_both_ways() -> None:
    c = chain(sensor={"cross_axis": 0.2})
    for axis in (0, 1):
        ring = tone(c, 1000.0, 0.1) * np.eye(2)[axis]
        found = measured(c, ring).measured[2560:]
        assert amplitude(found[:, axis], 1000.0, RATE) == pytest.approx(1.0, rel=1e-3)
        assert amplitude(found[:, 1 - axis], 1000.0, RATE) == pytest.approx(0.2, rel=1e-3)


def test_a_drifting_bias_walks_from_its_offset_in_independent_steps() -> None:
    setup = chain(sensor={"bias": 3.0, "bias_drift": 0.5}).measurement
    bias = Bias(setup, RATE)
    steps = 0.5 / math.sqrt(RATE) * random_stream(setup.seed, "bias_drift").standard_normal((2000, 2))
    found = np.concatenate([bias.process(np.ones((1000, 2)), Span(k, np.zeros(1001))) for k in (0, 1000)])
    assert found == pytest.approx(1.0 + 3.0 + np.cumsum(steps, axis=0))


def test_mains_hum_is_alike_in_both_axes_with_the_phase_of_its_seed() -> None:
    c = chain(background={"hum_level": 2.0})
    found = at_rest(c, 0.2).measured
    assert np.array_equal(found[:, 0], found[:, 1])
    phase = 2.0 * math.pi * (50.0 * np.arange(len(found)) / RATE + random_stream(c.simulation.seed, "hum").random())
    assert found[:, 0] == pytest.approx(2.0 * (np.sin(phase) + 0.5 * np.sin(2.0 * phase) + 0.33 * np.sin(3.0 * phase)), abs=1e-9)
