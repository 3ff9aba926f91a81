"""Stages of the ADC: range, steps, noise, and faults of the sensor, each alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from chain import chain, changed

from dcrb_ros.measurement.parameters import Accelerometer
from dcrb_ros.measurement.registry import STAGES
from dcrb_ros.measurement.stage import Span, Stage
from dcrb_ros.measurement.stages.adc import Adc
from dcrb_ros.measurement.stages.measuring_range import MeasuringRange
from dcrb_ros.measurement.stages.signal_fault import SignalFault
from dcrb_ros.measurement.stages.stuck import Stuck
from dcrb_ros.measurement.stages.white_noise import WhiteNoise

RATE = 51200.0


def stage(kind: type[Stage], *, background: dict[str, Any] | None = None, **sensor: Any) -> Any:
    """Return a stage with parameters of the sensor from tick 0 on."""
    setup = chain(sensor=sensor, background=background or {}).measurement
    made = kind(setup, RATE)
    made.set_parameters(setup.parameters, 0)
    return made


def through(made: Stage, samples: npt.ArrayLike, first: int = 0) -> npt.NDArray[np.float64]:
    """Return samples after a stage."""
    acceleration = np.asarray(samples, float)
    return made.process(acceleration, Span(first, np.zeros(len(acceleration) + 1)))


def test_stages_without_a_level_are_skipped() -> None:
    setup = chain(sensor={"preset": "none"}).measurement
    made = [kind(setup, RATE) for kind in STAGES]
    for one in made:
        one.set_parameters(setup.parameters, 0)
    assert {type(one).__name__ for one in made if one.active} == {"WhiteNoise", "MeasuringRange", "Adc", "Stuck"}


@pytest.mark.parametrize(("bits", "step"), [(1, 16.0), (2, 8.0), (4, 2.0), (12, 2.0**-7)])
def test_the_adc_rounds_to_steps_of_the_range_over_half_the_codes(bits: int, step: float) -> None:
    ramp = np.repeat(np.linspace(-16.0, 16.0, 20001)[:, None], 2, axis=1)
    found = through(stage(Adc, range=16.0, adc_bits=bits), ramp)
    assert np.abs(found - ramp).max() == pytest.approx(0.5 * step, rel=0.5 if bits == 12 else 0.01)
    codes = np.unique(found)
    assert np.diff(codes) == pytest.approx(step)
    assert len(codes) == 2**bits + 1  # both ends of the range included
    assert not stage(Adc, range=16.0, adc_bits=0).active


def test_samples_are_clipped_beyond_the_range_only_and_counted_per_sample() -> None:
    made = stage(MeasuringRange, range=10.0)
    samples = [[10.0, -10.0], [10.1, 0.0], [0.0, -12.0], [11.0, 11.0], [0.0, 0.0]]
    assert through(made, samples).tolist() == [[10.0, -10.0], [10.0, 0.0], [0.0, -10.0], [10.0, 10.0], [0.0, 0.0]]
    assert made.take_clipped().tolist() == [False, True, True, True, False]
    assert made.take_clipped().tolist() == []


def test_a_saturated_axis_clips_at_a_hundredth_at_full_severity() -> None:
    made = stage(MeasuringRange, range=10.0, fault="saturated", fault_axis="x")
    assert through(made, [[5.0, 5.0], [-5.0, 20.0]]) == pytest.approx(np.array([[0.1, 5.0], [-0.1, 10.0]]))
    assert made.take_clipped().tolist() == [True, True]
    assert through(stage(MeasuringRange, range=10.0, fault="saturated", fault_severity=0.5), [[5.0, 5.0]]).tolist() == [[1.0, 1.0]]


def test_a_drifting_gain_falls_in_a_straight_line_from_its_onset() -> None:
    made = stage(SignalFault, fault="gain_drift", fault_severity=0.5, fault_time=0.01)
    expected = 1.0 - 0.5 * np.clip(np.arange(1000) / 512.0, 0.0, 1.0)
    assert through(made, np.ones((1000, 2)))[:, 1] == pytest.approx(expected)
    late = stage(SignalFault)
    late.set_parameters(changed(chain(), fault="gain_drift", fault_time=0.01), 300)
    assert through(late, np.ones((10, 2)), 300)[:, 0] == pytest.approx(1.0 - np.arange(10) / 512.0)
    # The loss stays, a fiftieth, and grows with the slope of the new severity.
    late.set_parameters(changed(chain(), fault="gain_drift", fault_time=0.01, fault_severity=0.5), 310)
    assert through(late, np.ones((10, 2)), 310)[:, 0] == pytest.approx(1.0 - (10.0 + 0.5 * np.arange(10)) / 512.0)
    late.set_parameters(changed(chain(), fault="gain_drift", fault_time=0.01, fault_severity=0.01), 320)  # less than is lost already
    assert through(late, np.ones((10, 2)), 320)[:, 0] == pytest.approx(np.full(10, 0.99))


@pytest.mark.parametrize(("axis", "gains"), [("both", [0.75, 0.75]), ("x", [0.75, 1.0]), ("y", [1.0, 0.75])])
def test_a_dying_sensor_loses_its_severity_in_the_faulty_axes(axis: str, gains: list[float]) -> None:
    made = stage(SignalFault, fault="dead", fault_severity=0.25, fault_axis=axis)
    assert through(made, np.full((3, 2), 8.0)) == pytest.approx(np.tile(8.0 * np.array(gains), (3, 1)))


@pytest.mark.parametrize("severity", [1.0, 0.5])
def test_spikes_of_a_cable_are_a_fifth_to_the_whole_of_the_range_and_decay_in_a_tenth_of_a_millisecond(severity: float) -> None:
    made = stage(SignalFault, fault="spikes", fault_severity=severity, range=1000.0)
    found = through(made, np.zeros((round(60 * RATE), 2)))
    assert np.array_equal(found[:, 0], found[:, 1])
    decay = math.exp(-1.0 / (1e-4 * RATE))
    heights = np.concatenate([found[:1, 0], found[1:, 0] - decay * found[:-1, 0]])
    heights = heights[np.abs(heights) > 1e-6]
    assert len(heights) == pytest.approx(1200 * severity, rel=0.15)
    assert (heights > 0.0).mean() == pytest.approx(0.5, abs=0.07)
    sizes = np.sort(np.abs(heights)) / (1000.0 * severity)
    assert 0.2 <= sizes[1] < 0.23
    assert 0.97 < sizes[-2] <= 1.0
    assert np.median(sizes) == pytest.approx(0.6, abs=0.04)  # evenly between both


def test_a_stuck_sensor_sticks_once_in_a_tenth_of_a_second() -> None:
    ramp = np.arange(20480.0)[:, None] * [1.0, -1.0]
    made = stage(Stuck)
    through(made, ramp[:1000])
    made.set_parameters(changed(chain(), fault="stuck", fault_severity=0.25), 1000)
    found = through(made, ramp[1000:], 1000)
    phase = np.arange(len(found)) % 5120
    expected = np.where(phase < 1280, np.arange(len(found)) - phase - 1, np.arange(len(found))) + 1000.0
    assert found[:, 0].tolist() == expected.tolist()
    assert found[:, 1].tolist() == (-expected).tolist()


def test_a_sensor_that_is_stuck_from_the_start_repeats_zero() -> None:
    found = through(stage(Stuck, fault="stuck", fault_severity=0.5, fault_axis="y"), np.ones((5120, 2)))
    assert found[:, 0].tolist() == [1.0] * 5120
    assert found[:, 1].tolist() == [0.0] * 2560 + [1.0] * 2560


def test_white_noise_has_its_density_and_its_seed_alone() -> None:
    found = through(stage(WhiteNoise, noise_density=0.01), np.zeros((100000, 2)))
    assert found.std(axis=0) == pytest.approx(0.01 * math.sqrt(0.5 * RATE), rel=0.01)
    expected = np.random.Generator(np.random.Philox(chain().measurement.seed)).standard_normal((100000, 2))
    assert found == pytest.approx(0.01 * math.sqrt(0.5 * RATE) * expected)


@pytest.mark.parametrize(("fault", "severity"), [("none", 1.0), ("stuck", 0.0)])
def test_a_sensor_without_fault_has_no_entry_in_the_ground_truth(fault: str, severity: float) -> None:
    assert Accelerometer(fault=fault, fault_severity=severity).described() == {}


@pytest.mark.parametrize(("axis", "number"), [("both", 0), ("x", 1), ("y", 2)])
def test_the_ground_truth_has_severity_and_axis_of_a_fault(axis: str, number: int) -> None:
    sensor = Accelerometer(fault="stuck", fault_severity=0.5, fault_axis=axis)
    assert sensor.described() == {"sensor.stuck": {"severity": 0.5, "axis": number}}
    assert (sensor.severity("stuck"), sensor.severity("loose")) == (0.5, 0.0)
