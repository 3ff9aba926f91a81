"""Recordings from which no machine can be calibrated are refused with a sentence that says why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from synthetic_bearing import ORDERS, synthetic

from dcrb_ros import Orders, Refusal, Waveform, calibrate
from dcrb_ros.bearing.fault_lines import UNKNOWN
from dcrb_ros.calibration.healthy_recording import check_one_machine, checked_recording
from dcrb_ros.calibration.simulated_bearing import bench_of

RATE = 25600


def recorded(seconds: float = 3.0, rate: int = RATE, *, seed: int = 1, orders: Orders = ORDERS) -> Waveform:
    """Return noise at 20 Hz of the shaft, coloured by a path: white noise would be that of a dead sensor."""
    noise = lfilter([1.0], [1.0, -0.8], np.random.default_rng(seed).standard_normal((round(seconds * rate), 2)), axis=0)
    return Waveform.from_arrays(noise, rate, bearing=orders, shaft_angle=2.0 * np.pi * 20.0 * np.arange(len(noise)) / rate)


def test_a_sound_recording_is_accepted() -> None:
    found = checked_recording(recorded(), "sound")
    assert (found.axes, found.rate, found.unit) == (("x", "y"), RATE, "m/s^2")
    assert found.speed == pytest.approx(2.0 * np.pi * 20.0, rel=1e-6)


def test_of_three_axes_the_first_two_are_calibrated() -> None:
    two = recorded()
    three = replace(two, acceleration=np.column_stack([two.acceleration, recorded(seed=2).acceleration[:, 0]]))
    assert np.array_equal(checked_recording(three, "three").acceleration, checked_recording(two, "two").acceleration)


def turned(frequency: float, *, change: float = 0.0) -> Waveform:
    """Return a recording whose shaft turns at a frequency [Hz] that changes at a rate [Hz/s]."""
    time = np.arange(3 * RATE) / RATE
    return replace(recorded(), shaft_angle=np.mod(2.0 * np.pi * (frequency * time + 0.5 * change * time**2), 2.0 * np.pi))


NOISE = recorded().acceleration
BROKEN = np.where(np.arange(len(NOISE))[:, None] == 100, np.nan, NOISE)
"""With a sample that is not a number."""


@pytest.mark.parametrize(
    ("recording", "sentence"),
    [
        pytest.param(recorded(1.5), "odd is too short: .* needs 2 s and 20 turns", id="short"),
        pytest.param(recorded(0.01), "odd is too short: .* needs 2 s and 20 turns", id="very short"),
        pytest.param(turned(1.0), "3 turns of the shaft", id="few turns"),
        pytest.param(
            turned(20.0, change=2.0), r"speed between 1\d\d\d and 1\d\d\d rpm: a calibration needs a steady one", id="varying speed"
        ),
        pytest.param(turned(np.nan), "has no speed: import it with speed_rpm", id="no speed"),
        pytest.param(replace(recorded(), acceleration=0.0 * NOISE), "empty: every sample is 0", id="zeros"),
        pytest.param(replace(recorded(), acceleration=BROKEN), "not numbers", id="samples that are not numbers"),
        pytest.param(recorded(orders=UNKNOWN), "unknown bearing", id="unknown bearing"),
    ],
)
def test_a_recording_without_what_a_calibration_needs(recording: Waveform, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        checked_recording(recording, "odd")


@pytest.mark.parametrize(("axis", "value"), [(0, -0.0), (1, 3.0)])
def test_a_recording_with_a_dead_axis(axis: int, value: float) -> None:
    acceleration = recorded().acceleration.copy()
    acceleration[:, axis] = value
    with pytest.raises(Refusal, match=rf"dead axis: every sample in {'XY'[axis]} is {abs(value):g}; import it without this channel"):
        checked_recording(replace(recorded(), acceleration=acceleration), "dead", trust=True)


def test_a_rate_too_low_for_the_detector_names_the_option() -> None:
    with pytest.raises(Refusal, match=r"^slow cannot be judged by the detector, band_low = 2000 Hz leaves no band .* say so \(--trust\)$"):
        checked_recording(recorded(rate=1280), "slow")
    assert checked_recording(recorded(rate=1280), "slow", trust=True).rate == 1280


def test_a_rate_that_the_bench_does_not_have() -> None:
    with pytest.raises(
        Refusal, match=r"^the bench cannot run like slow: sensor\.sampling_rate = 900 Hz is outside .*; resample the recording$"
    ):
        bench_of(checked_recording(recorded(rate=900), "slow", trust=True), None, ())


@pytest.mark.slow
def test_a_level_beyond_every_bench_names_the_unit() -> None:
    loud = replace(recorded(), acceleration=recorded().acceleration * np.float32(1e9))
    with pytest.raises(Refusal, match=r"^no bench is like loud: structure\.gain_x = .* outside 1e-06 \.\. 1e\+06 .*; check the unit"):
        calibrate(loud, names="loud", trust=True, source_seconds=2.0)


def test_a_source_that_is_too_short() -> None:
    with pytest.raises(Refusal, match=r"^source_seconds = 1 is below 2 s: 4 s give"):
        calibrate(recorded(), trust=True, source_seconds=1.0)


@pytest.mark.parametrize(
    ("offset", "unit", "shown"), [(0.0, "m/s^2", r"-?6 m/s\^2"), (0.0, "relative", r"-?6 \(relative\)"), (10.0, "m/s^2", r"(16|4) m/s\^2")]
)
def test_a_clipped_recording(offset: float, unit: str, shown: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.calibration.healthy_recording.unit_of", lambda signal: unit)
    impulsive = np.random.default_rng(1).standard_normal((3 * RATE, 2)) ** 3
    clipped = Waveform.from_arrays(offset + np.clip(impulsive, -6.0, 6.0), RATE, bearing=ORDERS, shaft_angle=recorded().shaft_angle)
    with pytest.raises(Refusal, match=rf"is clipped: \d+ samples are at {shown}; record with a larger range"):
        checked_recording(clipped, "clipped")


def test_a_faulty_bearing_given_as_healthy_is_noticed_unless_it_is_trusted() -> None:
    acceleration, angle = synthetic(outer=60.0, seconds=4.0)
    faulty = Waveform.from_arrays(acceleration, 51200, bearing=ORDERS, shaft_angle=angle)
    with pytest.raises(Refusal, match=r"does not seem healthy: the detector finds outer_ring .*--trust"):
        calibrate(faulty)
    assert checked_recording(faulty, "faulty", trust=True).waveform is faulty


BACK = replace(recorded(seed=2), shaft_angle=-recorded().shaft_angle)
SINGLE = Waveform.from_arrays(recorded().acceleration[:, 0], RATE, bearing=ORDERS, shaft_angle=recorded().shaft_angle)


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        (recorded(3.0, 12800), "have sampling rates of 25600 and 12800 Hz"),
        (recorded(orders=Orders(ORDERS.ftf, ORDERS.bpfo * 1.1, ORDERS.bpfi, ORDERS.bsf)), "are of different machines: BPFO is"),
        (BACK, "have opposite directions of rotation, 1200 and -1200 rpm: calibrate to each alone$"),
        (SINGLE, "have 2 and 1 axes"),
    ],
)
def test_recordings_that_do_not_fit_together(other: Waveform, sentence: str) -> None:
    with pytest.raises(Refusal, match=f"^one and two {sentence}"):
        check_one_machine([checked_recording(recorded(), "one"), checked_recording(other, "two")])


def test_no_recording_and_one_that_is_given_twice() -> None:
    with pytest.raises(Refusal, match="no recording is given"):
        check_one_machine([])
    two = [checked_recording(recorded(), "one"), checked_recording(recorded(), "two")]
    with pytest.raises(Refusal, match="one and two have the same samples, which would count twice"):
        check_one_machine(two)
    check_one_machine([two[0], checked_recording(recorded(seed=2), "three")])


def test_a_base_with_another_bearing() -> None:
    other = Orders(ORDERS.ftf, ORDERS.bpfo * 1.1, ORDERS.bpfi * 1.1, ORDERS.bsf)
    with pytest.raises(Refusal, match="has another bearing than its bench: its BPFO is"):
        calibrate(recorded(orders=other), base="healthy", trust=True)


def test_names_for_some_recordings_only() -> None:
    with pytest.raises(Refusal, match="2 names given for 1 recording"):
        calibrate(recorded(), names=["one", "two"])


def test_something_that_is_no_recording() -> None:
    with pytest.raises(Refusal, match="recording 1 is not a recording"):
        calibrate([3.0])  # type: ignore[list-item]


@pytest.mark.parametrize("setting", ["structure.gain_y=0.5", "operating.speed=100", "operating.speed_ripple=0.001", "sensor.range=50.0"])
def test_a_setting_that_the_calibration_replaces(setting: str) -> None:
    with pytest.raises(Refusal, match=rf"the setting {setting.partition('=')[0]} cannot be kept: .* omit it and change it in"):
        bench_of(checked_recording(recorded(), "sound"), None, [setting])


def test_other_settings_are_kept() -> None:
    bench = bench_of(checked_recording(recorded(), "sound"), None, {"operating": {"load": 5000.0}, "simulation.step": 1.0 / (4 * 51200)})
    assert bench.operating.load == 5000.0
    assert bench.simulation.step <= 1.0 / (4 * 51200)
    assert bench.structure.housing == "none"  # that of the default bench, `healthy`, is part of the identified path
