"""Background vibration of the axle box: amplitudes, times and spectra."""

from __future__ import annotations

import numpy as np
import pytest
from chain import SPEED, amplitude, at_rest, chain, changed
from scipy import signal

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.measurement.stage import Span
from dcrb_ros.measurement.stages.background import Background
from dcrb_ros.messages.statuses import decode_truth, encode_truth
from dcrb_ros.stream.block import Truth

SPEED_SHARE = SPEED * 0.46 / 20.0
"""Vehicle speed relative to the one at which levels are given [-]."""


def test_unbalance_rotates_with_the_shaft_and_grows_with_the_square_of_its_speed() -> None:
    c = chain(background={"unbalance": 1e-4})
    for speed in (2.0 * np.pi * 20.0, -2.0 * np.pi * 40.0):
        found = at_rest(c, 0.5, speed).measured[5120 : 5120 + 15360]
        turning = found[:, 0] + 1j * found[:, 1]
        phase = np.exp(-1j * speed * np.arange(len(turning)) / 51200.0)
        assert abs(np.mean(turning * phase)) == pytest.approx(1e-4 * speed**2, rel=1e-3)


def test_rail_joints_are_their_spacing_apart() -> None:
    c = chain(background={"joint_level": 40.0, "joint_spacing": 5.0})
    found = at_rest(c, 1.0).measured[:, 1]
    peaks, _ = signal.find_peaks(found, height=1.0)
    way = 0.46 * SPEED * (peaks / 51200.0 - 0.002)  # the peak is in the middle of 4 ms
    assert np.diff(way) == pytest.approx(5.0, abs=0.46 * SPEED / 51200.0)
    assert len(way) in (11, 12)  # 57.8 m
    assert found[peaks] == pytest.approx(40.0 * SPEED_SHARE, rel=1e-2)
    assert at_rest(c, 0.2, -SPEED).measured[:, 1].max() == pytest.approx(40.0 * SPEED_SHARE, rel=1e-2)
    assert at_rest(c, 0.2, 0.0).measured.max() == 0.0


def test_a_wheel_flat_strikes_once_per_revolution() -> None:
    found = at_rest(chain(background={"flat_level": 30.0}), 1.0).measured[:, 1]
    peaks, _ = signal.find_peaks(found, height=1.0)
    assert np.diff(peaks) / 51200.0 == pytest.approx(2.0 * np.pi / SPEED, abs=1.0 / 51200.0)
    assert len(peaks) in (19, 20)


def test_track_excitation_fills_its_band_and_is_proportional_to_the_speed() -> None:
    c = chain(background={"track_level": 4.0, "track_low": 100.0, "track_high": 1000.0})
    found = at_rest(c, 4.0).measured
    assert found.std(axis=0) == pytest.approx(4.0 * SPEED_SHARE, rel=0.05)
    frequencies, power = signal.welch(found[:, 1], 51200.0, nperseg=8192)
    inside = np.mean(power[(frequencies > 150.0) & (frequencies < 800.0)])
    assert np.mean(power[frequencies > 4000.0]) < 1e-3 * inside
    assert at_rest(c, 4.0, 0.5 * SPEED).measured.std() == pytest.approx(2.0 * SPEED_SHARE, rel=0.05)


def test_look_alike_impacts_occur_at_random_times() -> None:
    found = at_rest(chain(background={"impact_rate": 40.0, "impact_level": 100.0}), 20.0).measured[:, 1]
    peaks, about = signal.find_peaks(found, height=20.0, distance=8)
    assert len(peaks) == pytest.approx(800, abs=90)
    assert about["peak_heights"].mean() == pytest.approx(100.0, rel=0.1)
    gaps = np.diff(peaks)
    assert gaps.std() == pytest.approx(gaps.mean(), rel=0.15)  # a Poisson process


def test_hum_has_its_harmonics() -> None:
    for mains in (50.0, 60.0):
        found = at_rest(chain(background={"hum_level": 2.0, "hum_frequency": mains}), 1.0).measured[:51200, 0]
        levels = [amplitude(found[:25600], k * mains, 51200.0) for k in (1, 2, 3, 4)]
        assert levels == pytest.approx([2.0, 1.0, 0.66, 0.0], abs=0.01)


def test_levels_change_at_exact_steps() -> None:
    c = chain(background={"hum_level": 1.0})
    sensor = Sensor(c.measurement)
    sensor.change(changed(c, background={"hum_level": 0.0, "flat_level": 30.0}), 1000)
    found = sensor.measure(np.zeros((20480, 2)), SPEED * np.arange(20480) / c.step_rate).measured
    assert np.abs(found[999]).max() > 0.0
    assert np.abs(found[1000:1010]).max() < 1e-9
    assert found[1010:, 1].max() == pytest.approx(30.0 * SPEED_SHARE, rel=1e-2)


def test_the_ground_truth_keeps_background_and_faults_apart() -> None:
    levels, faults = {"unbalance": 1e-4}, {"sensor.stuck": {"severity": 1.0, "axis": 2.0, "onset": 0.5}}
    truth = Truth(10, 1.0, (0.0, -1.0), {"FTF": 1.0, "BPFO": 2.0, "BPFI": 3.0, "BSF": 4.0}, faults, None, levels)
    assert decode_truth(encode_truth(truth)) == truth


@pytest.mark.parametrize(("level", "duration"), [({"joint_level": 40.0, "joint_spacing": 2.0}, 0.004), ({"flat_level": 30.0}, 0.002)])
def test_pulses_of_the_track_have_their_duration(level: dict[str, float], duration: float) -> None:
    """A Hann pulse is above a half of its peak for a half of its duration."""
    found = at_rest(chain(background=level), 0.5).measured[:, 1]
    peaks, _ = signal.find_peaks(found, height=1.0)
    widths = signal.peak_widths(found, peaks[1:-1], rel_height=0.5)[0] / 51200.0
    assert widths == pytest.approx(0.5 * duration, rel=0.01)
    assert not at_rest(chain(background=level), 0.5).measured[:, 0].any()


def test_look_alike_impacts_last_a_tenth_of_a_millisecond_and_vary_by_a_half() -> None:
    """Before the anti-alias filter: the peaks are 0.5 to 1.5 times their mean."""
    setup = chain(background={"impact_rate": 50.0, "impact_level": 100.0}).measurement
    rate = 5e6  # so that no peak falls between two steps
    stage = Background(setup, rate)
    stage.set_parameters(setup.parameters, 0)
    count = 1_000_000
    found = np.concatenate([stage.process(np.zeros((count, 2)), Span(k * count, np.zeros(count + 1)))[:, 1] for k in range(8)])
    peaks, about = signal.find_peaks(found, height=1.0)
    heights = about["peak_heights"]
    assert len(peaks) == pytest.approx(80, abs=27)  # three standard deviations of a Poisson process
    assert 50.0 - 1e-3 <= heights.min() < 62.0
    assert 138.0 < heights.max() < 200.0
    assert np.median(signal.peak_widths(found, peaks, rel_height=0.5)[0]) / rate == pytest.approx(0.5e-4, rel=0.01)


def test_phases_of_joints_flat_and_unbalance_follow_from_the_seed() -> None:
    c = chain(background={"unbalance": 1e-4})
    found = at_rest(c, 0.1).measured
    phase = 2.0 * np.pi * random_stream(c.simulation.seed, "passings").random(3)[2]
    angle = SPEED * np.arange(len(found)) / 51200.0 + phase
    assert found[200:-200, 0] == pytest.approx(1e-4 * SPEED**2 * np.cos(angle[200:-200]), abs=2e-3)
    assert found[200:-200, 1] == pytest.approx(1e-4 * SPEED**2 * np.sin(angle[200:-200]), abs=2e-3)


@pytest.mark.parametrize("level", ["unbalance", "joint_level", "flat_level", "track_level", "impact_rate"])
def test_any_level_switches_the_background_on(level: str) -> None:
    setup = chain(background={level: 0.001}).measurement
    stage = Background(setup, 51200.0)
    stage.set_parameters(setup.parameters, 0)
    assert stage.active
