"""The stage of the housing: how it joins modes and a calibrated path, bits, and parameters that it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from chain import chain, measured, tone
from hypothesis import given, settings
from hypothesis import strategies as st

from dcrb_ros import Refusal, load_configuration
from dcrb_ros.measurement.housing import dense_modes, impulse_response, unit_impulse
from dcrb_ros.measurement.housing_priors import HousingName
from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.measurement.stage import Span
from dcrb_ros.measurement.stages.housing import Housing
from dcrb_ros.measurement.stages.structure import AxleBox
from dcrb_ros.schema.arrays import Floats

RATE = 102400.0


def transmitted(samples: Floats, **structure: Any) -> Floats:
    """Return acceleration through the stage."""
    setup = chain(structure=structure).measurement
    return Housing(setup, RATE).process(samples, Span(0, np.zeros(len(samples) + 1)))


def impulse(count: int = 20480) -> Floats:
    """Return an impulse in both axes, shape (count, 2)."""
    return np.eye(1, count).T * np.ones(2)


def gain(response: Floats, low: float, high: float) -> Floats:
    """Return the mean gain of both axes in a band [dB]."""
    bins = np.fft.rfftfreq(len(response), 1.0 / RATE)
    power = np.abs(np.fft.rfft(response, axis=0)) ** 2
    return np.asarray(10.0 * np.log10(power[(bins >= low) & (bins < high)].mean(axis=0)))


def test_without_a_housing_the_stage_is_skipped() -> None:
    assert not Housing(chain().measurement, RATE).active
    assert Housing(chain(structure={"housing": "axle_box"}).measurement, RATE).active


@pytest.mark.parametrize("housing", ["laboratory", "axle_box"])
def test_the_stage_has_the_response_of_its_seed(housing: HousingName) -> None:
    expected = impulse_response(dense_modes(housing, "housing", 5), RATE, unit_impulse(RATE))
    found = transmitted(impulse(), housing=housing, seed=5)
    assert found[:10240] == pytest.approx(expected.T, abs=1e-13)
    assert not np.allclose(found, transmitted(impulse(), housing=housing, seed=6))


def test_the_seed_of_the_simulation_does_not_change_the_housing() -> None:
    c = [chain(structure={"housing": "laboratory"}, simulation={"seed": seed}) for seed in (1, 2)]
    ring = tone(c[0], 1000.0, 0.05)
    assert np.array_equal(measured(c[0], ring).measured, measured(c[1], ring).measured)


@settings(deadline=None, max_examples=20)
@given(
    st.lists(st.integers(1, 2500), min_size=1, max_size=6),
    st.sampled_from([{}, {"frequencies": "900, 2300"}, {"frequencies": "900", "path_x": "1400 0.03 1600 0.05"}]),
)
def test_the_chain_has_the_same_bits_for_any_split(cuts: list[int], joined: dict[str, Any]) -> None:
    c, count = chain(structure={"housing": "axle_box", **joined}), sum(cuts)
    ring, angle = np.random.default_rng(4).normal(0.0, 30.0, (count, 2)), np.arange(count) * 1e-3
    sensor, whole, parts, start = Sensor(c.measurement), Sensor(c.measurement).measure(ring, angle).measured, [], 0
    for piece in cuts:
        parts.append(sensor.measure(ring[start : start + piece], angle[start : start + piece]).measured)
        start += piece
    assert np.array_equal(np.concatenate(parts), whole)


def test_given_modes_replace_the_rigid_mass_line_below_the_dense_ones() -> None:
    modes = {"frequencies": "700, 3000", "dampings": "0.01, 0.02"}
    joined = transmitted(impulse(), housing="laboratory", **modes)
    alone = AxleBox(chain(structure={**modes, "coupling": 1.0}).measurement, RATE)
    sparse = alone.process(impulse(), Span(0, np.zeros(20481)))
    assert gain(joined, 50.0, 1500.0) == pytest.approx(gain(sparse, 50.0, 1500.0), abs=0.5)
    assert np.all(gain(joined, 8000.0, 12000.0) > gain(sparse, 8000.0, 12000.0) + 20.0)
    assert not AxleBox(chain(structure={**modes, "housing": "laboratory"}).measurement, RATE).active


def test_another_mounting_changes_the_path() -> None:
    as_drawn, *mounted = (transmitted(impulse(), housing="laboratory", mounting=mounting) for mounting in (0, 7, 8, 7))
    assert np.array_equal(mounted[0], mounted[2])
    assert not any(np.array_equal(as_drawn, other) for other in mounted)
    assert not np.array_equal(mounted[0], mounted[1])


def test_a_calibrated_axis_keeps_only_the_fine_structure_of_the_housing() -> None:
    found = transmitted(impulse(), housing="laboratory", path_x="1400 0.03 1600 0.05")
    plain = transmitted(impulse(), housing="laboratory")
    assert [gain(found, low, 2.0 * low)[0] for low in (500.0, 2000.0, 8000.0)] == pytest.approx([0.0] * 3, abs=1.0)
    assert np.array_equal(found[:, 1], plain[:, 1])
    assert np.abs(found[1:2000, 0]).max() > 0.01


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"structure.housing": "bogie"}, "housing"),
        (
            {"structure.housing": "axle_box", "simulation.step": 1.0 / 76800.0, "sensor.sampling_rate": 25600},
            "needs at least 80000 steps per second, and simulation.step gives 76800",
        ),
        ({"structure.housing": "laboratory", "structure.modes": 3, "structure.coupling": 0.5}, "structure.coupling = 0.5 does not apply"),
        ({"structure.housing": "laboratory", "structure.path_spread": 2.0}, "structure.path_spread = 2 dB does not apply"),
        ({"structure.housing": "none", "structure.mounting": 3}, "structure.mounting = 3 changes a housing, and there is none"),
    ],
)
def test_what_a_housing_cannot_work_with_is_refused(changes: dict[str, Any], reason: str) -> None:
    with pytest.raises(Refusal, match=reason):
        load_configuration("healthy", changes)
