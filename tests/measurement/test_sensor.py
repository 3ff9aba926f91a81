"""The measurement chain as a whole: rates, presets, noise, changes at exact samples, the same bits for any block size."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chain import EVERYTHING, amplitude, at_rest, chain, changed, measured, tone
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from dcrb_ros.measurement.parameters import MICRO_G, Accelerometer
from dcrb_ros.measurement.sensor import Measurement, Sensor, StageSequence
from dcrb_ros.measurement.stages.background import Background
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration, parameter_fields
from dcrb_ros.settings.sensor import PRESETS

STEPS = {12800: 1.0 / 102400, 25600: 1.0 / 102400, 51200: 1.0 / 102400, 102400: 1.0 / 204800}


@pytest.mark.parametrize("rate", STEPS)
def test_no_alias_reaches_the_band_at_any_rate(rate: int) -> None:
    c = load_configuration("dry", [f"sensor.sampling_rate={rate}", f"simulation.step={STEPS[rate]!r}", "sensor.preset=ideal"])
    passed = measured(c, tone(c, 0.39 * rate, 0.05)).measured[200:]
    assert passed.std() == pytest.approx(np.sqrt(0.5), rel=1e-3)
    for share in (0.601, 0.7, 0.85, 0.99):  # aliases to 0.399 .. 0.01 of the rate
        folded = measured(c, tone(c, share * rate, 0.05)).measured[200:]
        assert 20.0 * np.log10(np.abs(folded).max()) < -80.0


@pytest.mark.parametrize("rate", STEPS)
def test_the_gain_of_a_mode_does_not_depend_on_the_rate(rate: int) -> None:
    c = chain(
        structure={"frequencies": "3000", "dampings": "0.03", "coupling": 1.0},
        sensor={"sampling_rate": rate},
        simulation={"step": STEPS[rate]},
        publishing={"preview_rate": 100},
    )
    found = measured(c, tone(c, 3000.0, 0.1)).measured[round(0.05 * rate) : round(0.09 * rate)]
    assert amplitude(found[:, 0], 3000.0, rate) == pytest.approx(16.7, rel=0.01)  # sqrt(1 + 4 zeta^2) / (2 zeta)


@settings(max_examples=25)
@given(st.lists(st.integers(1, 900), min_size=1, max_size=8), st.integers(0, 300))
def test_the_result_does_not_depend_on_the_split_with_every_stage_and_changes(cuts: list[int], at: int) -> None:
    c, count = Configuration.model_validate(EVERYTHING), sum(cuts)
    ring, angle = np.random.default_rng(7).normal(0.0, 30.0, (count, 2)), 125.0 * np.arange(count) / c.step_rate
    background = {"hum_level": 5.0, "track_level": 0.0}

    def run(pieces: list[int]) -> Measurement:
        sensor, start, parts = Sensor(c.measurement), 0, []
        sensor.change(changed(c, background=background, fault="loose", range=100.0), at)
        sensor.change(changed(c, background=background), at + 150)
        for piece in pieces:
            parts.append(sensor.measure(ring[start : start + piece], angle[start : start + piece]))
            start += piece
        return Measurement(*(np.concatenate([getattr(part, name) for part in parts]) for name in Measurement.__dataclass_fields__))

    whole, cut_up = run([count]), run(cuts)
    for name in Measurement.__dataclass_fields__:
        assert np.array_equal(getattr(whole, name), getattr(cut_up, name)), name


def test_a_copy_continues_independently() -> None:
    c = Configuration.model_validate(EVERYTHING)
    sensor, ring, angle = Sensor(c.measurement), np.random.default_rng(7).normal(0.0, 30.0, (3000, 2)), 1e-3 * np.arange(3000)
    sensor.measure(ring[:1500], angle[:1500])
    sensor.change(changed(c, fault="stuck"), 1000)
    copies = copy.deepcopy(sensor), pickle.loads(pickle.dumps(sensor))
    found = sensor.measure(ring[1500:], angle[1500:]).measured
    for other in copies:
        assert np.array_equal(other.measure(ring[1500:], angle[1500:]).measured, found)


def test_switching_one_stage_on_changes_no_random_number_of_another() -> None:
    one = {"track_level": 3.0}
    quiet, white = at_rest(chain(background=one), 0.1), at_rest(chain(background=one, sensor={"noise_density": 0.01}), 0.1)
    noise = at_rest(chain(sensor={"noise_density": 0.01}), 0.1)
    assert white.measured - quiet.measured == pytest.approx(noise.measured, abs=1e-12)
    assert not np.array_equal(at_rest(chain(background=one, simulation={"seed": 2}), 0.1).measured, quiet.measured)


def test_white_noise_densities_add_in_power() -> None:
    found = at_rest(chain(sensor={"noise_density": 300.0 * MICRO_G, "white_noise_ug": 400.0}), 2.0).measured
    assert found.std() == pytest.approx(500.0 * MICRO_G * np.sqrt(25600.0), rel=0.01)


def test_pink_noise_has_its_density_at_one_hertz() -> None:
    c = chain(sensor={"pink_noise_ug": 100.0, "sampling_rate": 12800})
    frequencies, power = signal.welch(at_rest(c, 20.0).measured, c.sensor.sampling_rate, nperseg=12800, axis=0)
    for low, high in ((5, 10), (10, 100), (100, 1000)):
        inside = (frequencies >= low) & (frequencies < high)
        density = np.sqrt(np.mean(power[inside] * frequencies[inside, None]))
        assert density == pytest.approx(100.0 * MICRO_G, rel=0.12)


def test_cross_axis_bias_and_ac_coupling_have_their_values() -> None:
    c = chain(sensor={"cross_axis": 0.05})
    ring = tone(c, 1000.0, 0.1) * [1.0, 0.0]
    assert amplitude(measured(c, ring).measured[2560:, 1], 1000.0, 51200.0) == pytest.approx(0.05, rel=1e-3)
    assert at_rest(chain(sensor={"bias": 2.5}), 0.01).measured == pytest.approx(2.5)
    coupled = at_rest(chain(sensor={"bias": 2.5, "ac_coupling": 10.0}), 1.0).measured
    assert abs(coupled[-1, 0]) < 1e-6
    assert coupled[round(51200 / (2.0 * np.pi * 10.0)), 0] == pytest.approx(2.5 / np.e, rel=0.01)  # after one time constant


def test_the_bias_is_a_random_walk() -> None:
    walks = [at_rest(chain(sensor={"bias_drift": 0.5}, simulation={"seed": seed}), 0.25).measured[-1] for seed in range(60)]
    assert np.std(walks) == pytest.approx(0.5 * np.sqrt(0.25), rel=0.25)


def test_mount_and_bandwidth_have_their_gain() -> None:
    c = chain(sensor={"mount_frequency": 25000.0, "mount_damping": 0.03})
    raised = amplitude(measured(c, tone(c, 10000.0, 0.1)).measured[2560:, 0], 10000.0, 51200.0)
    ratio = np.tan(np.pi * 10000.0 / 102400.0) / np.tan(np.pi * 25000.0 / 102400.0)  # prewarped frequencies of the bilinear transform
    assert raised == pytest.approx(1.0 / abs(1.0 - ratio**2 + 0.06j * ratio), rel=1e-3)
    c = chain(sensor={"bandwidth": 11000.0})
    assert amplitude(measured(c, tone(c, 11000.0, 0.1)).measured[2560:, 0], 11000.0, 51200.0) == pytest.approx(0.7071, rel=1e-3)


def test_a_preset_supplies_only_values_that_are_not_given() -> None:
    for name, typical in PRESETS.items():
        sensor = load_configuration("dry", [f"sensor.preset={name}"]).sensor.model_dump()
        assert {key: sensor[key] for key in typical} == dict(typical)
    sensor = load_configuration("dry", ["sensor.preset=mems", "sensor.adc_bits=12", "sensor.bandwidth=0.0"]).sensor
    assert (sensor.adc_bits, sensor.bandwidth, sensor.cross_axis) == (12, 0.0, 0.01)
    known = {field.key.removeprefix("sensor.") for field in parameter_fields() if field.key.startswith("sensor.")}
    assert all(set(typical) <= known for typical in PRESETS.values())


def test_an_ideal_sensor_measures_the_acceleration_of_the_ring() -> None:
    c = chain(sensor={"preset": "ideal"})
    found = measured(c, np.random.default_rng(1).normal(0.0, 300.0, (4096, 2)))
    assert np.array_equal(found.measured, found.clean)


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("sensor.preset=iepe", r"sensor.preset = 'iepe' is not one of none, ideal, iepe_100mv_g, mems"),
        ("sensor.fault=stuk", r"sensor.fault = 'stuk' is not one of .*; did you mean 'stuck'\?"),
        ("sensor.fault_severity=40.0", r"sensor.fault_severity = 40\.0 is outside 0 \.\. 1: give a share, not per cent"),
        ("sensor.mount_frequency=60000.0", r"sensor.mount_frequency = 60000 Hz is above 46080 Hz, 0\.45 of the step rate"),
        ("sensor.mount_frequency=25.0", r"below 100 Hz: give 0\.0 for a rigid mount"),
        ("sensor.bandwidth=1.0", r"below 10 Hz: give 0\.0 for no low-pass"),
        ("sensor.clock_jitter=5.0", r"give seconds, 1 ns is 1e-9"),
        ("sensor.clock_offset_ppm=.nan", r"sensor.clock_offset_ppm = nan ppm is not a finite number"),
        ("structure.frequencies=900; 2300", r"structure.frequencies: '900; 2300' is not a list of numbers"),
        ("structure.frequencies=0.9", r"structure.frequencies: 0\.9 Hz is outside 50 \.\. 20000 Hz"),
        ("structure.dampings=0.02", r"structure.dampings has 1 numbers for 0 structure.frequencies"),
        ("background.track_low=1400.0", r"background.track_high = 1500 Hz is less than 1\.2 times"),
        ("background.joint_level=-1.0", r"background.joint_level = -1\.0 m/s\^2 is outside"),
        ("publishing.burst_length=2.0", r"has no publishing.burst_period"),
        ("publishing.burst_period=2.0", r"publishing.burst_length = 0 s is outside 0\.02 \.\. 2 s"),
        ("publishing.loss_probability=1.0", r"publishing.loss_probability = 1\.0 is outside 0 \.\. 0\.9"),
        ("operating.speed_kmh=1e9", r"operating.speed_kmh = 1000000000\.0 km/h is outside -1000 \.\. 1000 km/h"),
        ("operating.wheel_diameter=920.0", r"did you mean 0\.92\?"),
        ("sensor.sampling_rate=102400", r"must be a whole number, at least 2: take 4\.8828125e-06"),
    ],
)
def test_impossible_parameters_are_refused(setting: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_configuration("dry", [setting])


def test_a_vehicle_speed_gives_the_shaft_speed(tmp_path: Path) -> None:
    operating = load_configuration("dry", ["operating.speed_kmh=-72.0", "operating.wheel_diameter=1.0"]).operating
    assert (operating.speed, operating.speed_kmh) == (-40.0, 0.0)
    path = tmp_path / "bench.yaml"
    path.write_text("/**: {ros__parameters: {operating: {speed_kmh: 90.0}}}", encoding="utf-8")
    assert load_configuration(path).operating.speed == pytest.approx(25.0 / 0.46)
    assert load_configuration(path, ["operating.speed=40.0"]).operating.speed == 40.0


def with_fault(kind: str, severity: float = 1.0, **sensor: Any) -> Measurement:
    """Return what a faulty sensor measures of a tone of 10 m/s^2 at 1 kHz; the fault comes after 0.1 s."""
    c = chain(sensor={"range": 5000.0, **sensor})
    found = Sensor(c.measurement)
    found.change(changed(c, fault=kind, fault_severity=severity, fault_time=0.1), 5120)
    ring = 10.0 * tone(c, 1000.0, 0.4)
    return found.measure(ring, 125.0 * np.arange(len(ring)) / c.step_rate)


def test_a_dead_sensor_measures_only_noise() -> None:
    found = with_fault("dead", noise_density=1e-3).measured
    assert found[2560:5120].std() == pytest.approx(7.07, rel=0.01)
    assert found[5120:].std() == pytest.approx(1e-3 * np.sqrt(25600.0), rel=0.05)


@pytest.mark.parametrize(("severity", "share"), [(1.0, 1.0), (0.4, 0.4)])
def test_a_stuck_sensor_repeats_its_last_sample(severity: float, share: float) -> None:
    found = with_fault("stuck", severity, noise_density=1e-3).measured[:, 0]
    assert found[5120] == found[5119]
    repeats = np.diff(found[5119:]) == 0.0
    assert repeats[:10240].mean() == pytest.approx(share, abs=0.01)


def test_a_saturated_sensor_clips_and_counts() -> None:
    found = with_fault("saturated", 0.75, range=100.0)
    assert np.abs(found.measured[5120:]).max() == pytest.approx(100.0 * 0.01**0.75)
    assert not found.clipped[:5120].any()
    assert found.clipped[5120:].mean() > 0.5


def test_a_drifting_gain_reaches_its_severity() -> None:
    found = with_fault("gain_drift", 0.6).measured[:, 0]
    level = [amplitude(found[5120 + begin : 5120 + begin + 512], 1000.0, 51200.0) for begin in (2304, 5120, 8000)]
    assert level == pytest.approx([7.0, 4.0, 4.0], rel=0.01)


def drifting(changes: dict[int, dict[str, Any]]) -> list[float]:
    """Return the gain every 0.1 s of 1 s in which the parameters of a drift change at samples."""
    c = chain(sensor={"fault": "gain_drift", "fault_severity": 0.0})
    sensor = Sensor(c.measurement)
    for at, values in changes.items():
        sensor.change(changed(c, fault="gain_drift", **values), at)
    ring = tone(c, 1000.0, 1.1)
    found = sensor.measure(ring, 125.0 * np.arange(len(ring)) / c.step_rate).measured[:, 0]
    return [amplitude(found[begin : begin + 512], 1000.0, 51200.0) for begin in range(5120, 56320, 5120)]


def test_a_drift_begins_where_its_severity_is_above_zero() -> None:
    """At a severity of 0 there is no fault, and the truth states none."""
    late = drifting({25600: {"fault_severity": 0.8, "fault_time": 0.4}})
    assert late == pytest.approx([1.0, 1.0, 1.0, 1.0, 1.0, 0.8, 0.6, 0.4, 0.2, 0.2], abs=0.02)


def test_a_drift_continues_from_its_share_with_another_time() -> None:
    start = {"fault_severity": 0.8, "fault_time": 0.8}
    slower = drifting({0: start, 20480: {"fault_severity": 0.8, "fault_time": 1.6}})
    assert slower == pytest.approx([0.9, 0.8, 0.7, 0.6, 0.55, 0.5, 0.45, 0.4, 0.35, 0.3], abs=0.02)


def test_a_loose_cable_adds_spikes() -> None:
    found = with_fault("spikes", range=1000.0).measured
    after = np.abs(found[5120:, 0])
    assert after.max() > 150.0
    assert np.median(after) < 10.0
    c = chain(sensor={"range": 1000.0, "fault": "spikes"})
    spikes = at_rest(c, 20.0).measured[:, 0]
    assert np.sum(np.abs(np.diff(spikes)) > 185.0) == pytest.approx(400, abs=60)  # 20 a second


def test_a_loose_mount_attenuates_high_frequencies_and_adds_harmonics() -> None:
    c = chain(sensor={"fault": "loose"})
    high = measured(c, tone(c, 5000.0, 0.2)).measured[5120:, 0]
    assert amplitude(high, 5000.0, 51200.0) < 0.05  # far above its resonance of 800 Hz
    low = measured(c, tone(c, 200.0, 0.2)).measured[5120:, 0]
    assert amplitude(low, 400.0, 51200.0) > 0.05  # different gains of the two directions: a second harmonic


def test_a_loose_mount_is_in_both_axes_and_never_raises_a_resonance() -> None:
    c = chain(sensor={"fault": "loose", "fault_axis": "x", "fault_severity": 0.2, "mount_frequency": 3000.0})
    assert c.measurement.parameters[Accelerometer].described() == {"sensor.loose": {"severity": 0.2, "axis": 0}}
    gains = [amplitude(measured(c, tone(c, f, 0.2)).measured[5120:, 0], f, 51200.0) for f in (3000.0 * 0.1**0.2, 5048.0)]
    assert gains[0] > 4.0
    assert gains[1] < 0.2


@pytest.mark.parametrize("before", [0.0, 0.5])
def test_a_mount_that_comes_loose_makes_no_impact(before: float) -> None:
    """The filter of the mount continues from the last samples: a slow vibration passes before and after alike."""
    c = chain(sensor={"range": 5000.0, "fault": "loose", "fault_severity": before})
    sensor, ring = Sensor(c.measurement), 10.0 * tone(c, 5.0, 0.2)
    for k in range(4):
        sensor.change(changed(c, fault="loose", fault_severity=0.5 + 0.005 * k), 5120 + 512 * k)
    found = sensor.measure(ring, np.zeros(len(ring))).measured[4000:9000, 0]
    assert np.abs(np.diff(found)).max() < 0.05 if before else np.abs(np.diff(found)).max() < 1.6  # where the rattle begins


def test_a_fault_may_be_in_one_axis() -> None:
    found = with_fault("dead").measured[6000:]
    assert np.abs(found).max() < 1e-12
    c = chain(sensor={"fault": "dead", "fault_axis": "y"})
    found = measured(c, tone(c, 1000.0, 0.1)).measured[512:]
    assert (found[:, 0].std() > 0.7, found[:, 1].std()) == (True, 0.0)


@pytest.mark.parametrize("clock", [{}, {"clock_offset_ppm": 1000.0}, {"clock_offset_ppm": -1000.0, "clock_jitter": 1e-6}])
@pytest.mark.parametrize("rate", [12800, 51200])
def test_the_steps_for_a_number_of_samples_are_enough_and_not_many_more(rate: int, clock: dict[str, float]) -> None:
    c = chain(sensor={"sampling_rate": rate, **clock}, publishing={"preview_rate": 100})
    for samples in (1, 7, 500):
        steps = Sensor(c.measurement).steps(samples)
        found, fewer = (
            Sensor(c.measurement).measure(np.zeros((count, 2)), np.zeros(count)).measured for count in (steps, steps - c.step_rate // rate)
        )
        assert len(fewer) < len(found)
        assert samples <= len(found) <= samples + (1 if clock else 0)
        if not clock:
            assert len(Sensor(c.measurement).measure(np.zeros((steps - 1, 2)), np.zeros(steps - 1)).measured) == samples - 1


def test_the_shaft_turns_at_its_initial_speed_before_the_first_step() -> None:
    setup = chain(background={"unbalance": 1e-4}).measurement
    rate = float(setup.step_rate)
    sequence = StageSequence([Background], setup, rate)
    found = sequence.process(np.zeros((3, 2)), setup.speed * np.arange(3) / rate)
    assert np.hypot(*found.T) == pytest.approx(1e-4 * setup.speed**2, rel=1e-9)


def test_the_angle_of_a_sample_is_that_of_its_first_step() -> None:
    c = chain()
    factor = c.step_rate // c.sensor.sampling_rate
    angle = np.arange(4000.0)
    found = Sensor(c.measurement).measure(np.zeros((4000, 2)), angle).angle
    assert found.tolist() == (factor * np.arange(len(found))).tolist()


def test_a_parameter_group_without_the_fields_of_a_stage_is_reported() -> None:
    parameters = chain().measurement.parameters

    class Unknown(Group):
        pass

    with pytest.raises(KeyError, match="Unknown"):
        parameters[Unknown]
