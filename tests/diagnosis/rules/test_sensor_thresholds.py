"""Rules for the sensor at their thresholds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.optimize import brentq

from dcrb_ros.diagnosis.evidence import LevelEvidence, LevelHistory, Levels, SampleEvidence
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rules import rattling_mount
from dcrb_ros.diagnosis.rules.constant import Constant
from dcrb_ros.diagnosis.rules.dead import Dead
from dcrb_ros.diagnosis.rules.gain_drift import GainDrift
from dcrb_ros.diagnosis.rules.loose_mount import LooseMount
from dcrb_ros.diagnosis.rules.not_finite import NotFinite
from dcrb_ros.diagnosis.rules.rattling_mount import RattlingMount, asymmetry
from dcrb_ros.diagnosis.rules.saturation import Saturation
from dcrb_ros.diagnosis.rules.silence import Silence
from dcrb_ros.diagnosis.rules.spikes import Spikes, count_jumps
from dcrb_ros.diagnosis.rules.stuck import Stuck

RATE = 51200
P = DetectorParameters()
Floats = npt.NDArray[np.float64]


def samples(
    x: npt.ArrayLike, y: npt.ArrayLike | None = None, *, not_finite: int = 0, sensor_range: float = 0.0, hops: int = 8, rate: int = RATE
) -> SampleEvidence:
    first = np.asarray(x, float)
    second = np.random.default_rng(1).normal(size=len(first)) if y is None else np.asarray(y, float)
    return SampleEvidence(np.column_stack([first, second]), len(first), not_finite, rate, sensor_range, hops, 20.0)


def noise(count: int = 10000, seed: int = 3) -> Floats:
    return np.random.default_rng(seed).normal(size=count)


def test_a_constant_axis_is_dead_and_the_least_change_is_not() -> None:
    assert "in Y does not change" in Constant(P).flaw(samples(noise(100), np.full(100, 2.0)))
    assert Constant(P).flaw(samples(noise(100), [2.0] * 99 + [2.0000001])) == ""


@pytest.mark.parametrize(("count", "flaw"), [(100, ""), (101, "101 of 10000 samples are not finite numbers")])
def test_a_hundredth_of_the_samples_may_be_not_finite(count: int, flaw: str) -> None:
    assert NotFinite(P).flaw(samples(noise(), not_finite=count)) == flaw
    assert (NotFinite(P).at_standstill, NotFinite(P).fewest_samples) == (True, 0)


def clipped(count: int, limit: float = 3.5) -> Floats:
    """Return noise within a limit, of which the last ``count`` samples are clipped at it."""
    column = noise()
    column *= 0.9 * limit / np.abs(column).max()
    column[-count:] = limit
    return column


@pytest.mark.parametrize(
    ("count", "sensor_range", "flawed"),
    [(1500, 0.0, False), (1501, 0.0, True), (5, 10.0, False), (6, 10.0, True), (6, 3.5 / 0.9, False), (6, 3.9, True), (6, 0.0, False)],
)
def test_clipping_is_a_fault_from_its_shares_on(count: int, sensor_range: float, flawed: bool) -> None:
    rule = Saturation(P)
    flaw = rule.flaw(samples(clipped(count), sensor_range=sensor_range))
    assert bool(flaw) is flawed
    assert rule.clipped == count
    if flawed:
        known = f" where its range is {sensor_range:g}" if sensor_range else ""
        assert flaw == f"the acceleration in X is clipped at 3.5 m/s^2{known} for {count / 1e4:.1%} of the time: the sensor is saturated"


def test_both_ends_count_where_two_neighbours_are_equal() -> None:
    column = clipped(3)
    column[100:102] = -3.9
    rule = Saturation(P)
    assert rule.flaw(samples(column)) == ""
    assert rule.clipped == 5
    single = noise()
    single[[10, 200]] = 9.0
    rule.flaw(samples(single))
    assert rule.clipped == 5  # equal peaks that are not neighbours are no clipping
    rule.flaw(samples(noise(), clipped(4)))
    assert rule.clipped == 9


@pytest.mark.parametrize(("values", "flawed"), [(15, False), (16, True)])
def test_a_signal_of_few_values_is_not_clipped_but_coarse(values: int, flawed: bool) -> None:
    column = np.tile(np.arange(values, dtype=float), 1000)[:10000]
    column[-2000:] = values - 1.0
    assert bool(Saturation(P).flaw(samples(column))) is flawed
    late = np.concatenate([np.full(1000, values - 1.0), column])
    assert bool(Saturation(P).flaw(samples(late))) is flawed  # whatever the first samples are


@pytest.mark.parametrize(("limit", "flawed"), [(1.0, True), (4.0, False)])
def test_a_coarse_adc_may_be_saturated_at_both_ends(limit: float, flawed: bool) -> None:
    assert bool(Saturation(P).flaw(samples(np.clip(np.round(4.0 * noise()), -limit, limit)))) is flawed
    assert Saturation(P).flaw(samples(np.clip(np.round(0.4 * noise() + 0.4), 0.0, 1.0))) == ""  # of a sensor at rest


@pytest.mark.parametrize(("sensor_range", "flawed"), [(3.5 / 0.91, False), (3.5 / 0.89, True)])
def test_the_limit_is_that_of_the_end_that_is_clipped(sensor_range: float, flawed: bool) -> None:
    column = clipped(20)
    column[100] = -9.0
    flaw = Saturation(P).flaw(samples(column, sensor_range=sensor_range))
    assert bool(flaw) is flawed
    assert not flawed or "is clipped at 3.5 m/s^2" in flaw


def test_an_end_that_two_samples_reach_by_chance_is_no_limit() -> None:
    column = clipped(100)  # at 3.5
    column[[500, 501]] = 1.01 * column.min()
    assert Saturation(P).flaw(samples(column, sensor_range=3.5)) == ""


def test_few_samples_at_either_end_are_counted_together() -> None:
    column = clipped(3)
    column[-9:-6] = -3.5
    assert "is clipped at 3.5 m/s^2" in Saturation(P).flaw(samples(column, sensor_range=10.0))
    assert Saturation(P).flaw(samples(np.where(column == -3.5, 0.0, column), sensor_range=10.0)) == ""


@pytest.mark.parametrize("steps", [1.2, 1.45, 2.4, 3.0])
def test_a_hum_over_a_few_steps_of_a_coarse_adc_is_not_saturated(steps: float) -> None:
    hum = steps * np.sin(2.0 * np.pi * 50.0 / 12000 * np.arange(12000)) + 0.05 * np.random.default_rng(2).normal(size=12000)
    assert Saturation(P).flaw(samples(np.round(hum), sensor_range=5000.0)) == ""


@pytest.mark.parametrize(("limit", "flawed"), [(22, False), (18, True)])
def test_the_largest_step_of_a_coarse_adc_is_rarer_than_the_next_one(limit: int, flawed: bool) -> None:
    """The sum of two numbers up to 11: 22 has a share of 1/144, and 21 twice that; clipped at 18, that has 15/144, and 17 has 6/144."""
    column = np.minimum(np.random.default_rng(1).integers(0, 12, (20000, 2)).sum(axis=1), limit) - 11.0
    column[[100, 101]] = limit - 11.0
    assert bool(Saturation(P).flaw(samples(column, sensor_range=1000.0))) is flawed


def stuck(share: float, run: int) -> Floats:
    column = noise()
    for k in range(round(share * len(column) / run)):
        column[k * 2 * run + 1 : k * 2 * run + run + 1] = 0.1
    return column


@pytest.mark.parametrize(("share", "run", "flawed"), [(0.0306, 51, True), (0.0255, 51, False), (0.5, 50, False), (0.25, 51, True)])
def test_runs_of_a_millisecond_may_take_three_per_cent(share: float, run: int, flawed: bool) -> None:
    assert bool(Stuck(P).flaw(samples(stuck(share, run)))) is flawed


@pytest.mark.parametrize("rate", [5600, 12000])
def test_a_quiet_signal_of_a_coarse_adc_is_not_stuck(rate: int) -> None:
    """Half of the values are equal, so that some are in runs of a millisecond at 5600 Hz."""
    quiet = [np.round(noise(rate // 2, seed) * 0.75) for seed in (3, 4)]
    assert Stuck(P).flaw(samples(*quiet, rate=rate)) == ""
    assert Stuck(P).flaw(samples(stuck(0.25, 16), rate=rate))


def test_runs_at_the_largest_magnitude_are_clipping() -> None:
    for end in (9.0, -9.0):
        column = noise()
        column[:2000] = end
        assert Stuck(P).flaw(samples(column)) == ""
    column[:2000] = 2.5
    assert Stuck(P).flaw(samples(column)) == "the acceleration in X repeats the same value for 20% of the time: the sensor is stuck"
    assert "in Y" in Stuck(P).flaw(samples(noise(), stuck(0.25, 51)))


def tones(densities: dict[tuple[float, float], float], seed: int = 1) -> Floats:
    """Return a second of tones at random phases with given amplitudes in bands [Hz]."""
    spectrum, random = np.zeros(RATE // 2 + 1, complex), np.random.default_rng(seed)
    for (low, high), amplitude in densities.items():
        bins = np.arange(round(low), round(high))
        spectrum[bins] = amplitude * np.exp(2j * np.pi * random.random(len(bins)))
    return np.fft.irfft(spectrum) * RATE


@pytest.mark.parametrize("level", [-15.0, -9.1, -8.9, 0.0, 8.9, 9.1, 15.0])
def test_a_signal_is_noise_if_no_part_of_its_spectrum_stands_out_by_nine_decibels(level: float) -> None:
    """The parts are sixteenths of 200 Hz to 0.4 of the sampling rate; what lies beside them does not count."""
    width = (0.4 * RATE - 200.0) / 16.0
    low, high = 200.0 + 3.0 * width, 200.0 + 4.0 * width
    bands = {
        (50.0, 200.0): 9.0,
        (200.0, low): 1.0,
        (low, high): 10.0 ** (level / 20.0),
        (high, 0.4 * RATE): 1.0,
        (0.4 * RATE, 0.5 * RATE): 9.0,
    }
    column, alive = 4.0 + tones(bands), tones({(200.0, 2000.0): 1.0})
    assert Dead(P)._spread_of_noise(column, RATE) == pytest.approx(abs(level), abs=0.1)

    def dying() -> Dead:
        """Return a rule that has heard both axes loud."""
        rule = Dead(P)
        assert not rule.flaw(samples(100.0 * alive, -100.0 * alive))
        return rule

    flaw = dying().flaw(samples(column, 100.0 * alive))
    assert bool(flaw) is (abs(level) < 9.0)
    if flaw:
        assert flaw.startswith("the acceleration in X is white noise, whose power density varies by ")
    assert bool(dying().flaw(samples(100.0 * alive, column))) is (abs(level) < 9.0)
    assert bool(Dead(P).flaw(samples(alive, column))) is (abs(level) < 2.0)


@pytest.mark.parametrize(("fall", "flawed"), [(9.5, False), (10.5, True)])
def test_a_noisy_sensor_is_dead_only_if_it_was_not_always_noisy(fall: float, flawed: bool) -> None:
    """A tone 12 dB over the density of white noise leaves a spread of more than 2 dB: this is no noise alone."""
    time = np.arange(RATE // 2) / RATE
    noisy = noise(len(time)) + 0.1 * np.sin(2.0 * np.pi * 3000.0 * time)
    spread = Dead(P)._spread_of_noise(noisy, RATE)
    assert spread is None or spread < 9.0
    column = noisy + 0.3 * np.sin(2.0 * np.pi * 3000.0 * time)
    found = Dead(P)._spread_of_noise(column, RATE)
    assert found is not None
    assert P.dead_white < found < P.dead_level
    assert not Dead(P).flaw(samples(column, column))
    rule, louder = Dead(P), np.sqrt(np.var(column) / np.var(time)) * 10.0 ** (0.05 * fall) * (time - time.mean())
    assert not rule.flaw(samples(louder, louder))
    assert bool(rule.flaw(samples(column, column))) is flawed


@pytest.mark.parametrize(
    ("before", "after", "flawed"), [(30.0, 30.0, True), (30.0, 29.2, True), (30.0, 28.0, False), (30.0, 0.0, False), (0.0, 0.0, False)]
)
def test_a_bearing_may_fall_silent_with_the_shaft(before: float, after: float, flawed: bool) -> None:
    """Powers are compared within 3 % of a speed that is known; the spectrum left is that of a noisy sensor, not white."""
    time = np.arange(RATE // 2) / RATE
    left = noise(len(time)) + 0.4 * np.sin(2.0 * np.pi * 3000.0 * time)
    rule = Dead(P)
    loud, quiet = (replace(samples(gain * left, gain * left), frequency=speed) for gain, speed in ((10.0, before), (1.0, after)))
    assert not rule.flaw(loud)
    assert bool(rule.flaw(quiet)) is flawed


@pytest.mark.parametrize("rhythm", [3.0, 30.0, 200.0])
@pytest.mark.parametrize("rate", [12000, 51200])
def test_white_noise_that_follows_the_machine_is_no_dead_sensor(rhythm: float, rate: int) -> None:
    time = np.arange(rate // 2) / rate
    for seed in range(20):
        still = noise(len(time), seed)
        assert Dead(P).flaw(samples(still, still, rate=rate))
        alive = still * (1.0 + 0.3 * np.cos(2.0 * np.pi * rhythm * time))
        assert not Dead(P).flaw(samples(alive, alive, rate=rate))


@pytest.mark.parametrize(("kurtosis", "found"), [(3.9, True), (4.1, False)])
def test_a_signal_with_impacts_is_not_noise(kurtosis: float, found: bool) -> None:
    column = noise(50000)
    # One sample in a hundred of height h has a kurtosis of (3 + h^4 / 100) / (1 + h^2 / 100)^2, here about.
    place = np.arange(len(column)) % 100 == 50

    def measured(height: float) -> float:
        changed = np.where(place, height * np.sign(column), column)
        centred = changed - changed.mean()
        return float(np.mean(centred**4) / np.mean(centred**2) ** 2)

    height = float(brentq(lambda h: measured(h) - kurtosis, 2.0, 9.0))
    changed = np.where(place, height * np.sign(column), column)
    assert (Dead(P)._spread_of_noise(changed, RATE) is not None) is found
    assert (Dead(P)._spread_of_noise(changed + 5.0, RATE) is not None) is found  # an offset is no impact


@pytest.mark.parametrize("gain", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(("frequency", "flawed"), [(4.9, True), (5.1, False), (300.0, False)])
def test_a_signal_that_drifts_without_vibrating_is_dead_at_any_gain(frequency: float, flawed: bool, gain: float) -> None:
    drift = gain * np.sin(2.0 * np.pi * frequency * np.arange(2 * RATE) / RATE)
    assert bool(Silence(P).flaw(samples(drift, noise(2 * RATE)))) is flawed


def levels(*change: float, level: tuple[float, ...] = (), third: int | None = 2) -> LevelEvidence:
    """Return levels without noise, whose change is certain."""
    changes, fall = np.array(change), -float(np.mean(change))
    return LevelEvidence(Levels(np.array(level or change), changes, fall, changes, fall), third)


@pytest.mark.parametrize(
    ("change", "flawed"),
    [
        ((-3.0, -3.0, -3.0), True),
        ((-2.99, -3.0, -3.0), False),
        ((-3.5, -4.0, -4.5), True),  # a spread of a quarter of the mean
        ((-3.49, -4.0, -4.51), False),
        ((3.0, 3.0, 3.0), False),
        ((-9.0,), False),
    ],
)
def test_a_gain_drifts_if_all_bands_fall_alike(change: tuple[float, ...], flawed: bool) -> None:
    flaw = GainDrift(P).flaw(levels(*change))
    assert flaw == (
        f"all bands have decreased by {-np.mean(change):.1f} dB at the same speed: the gain of the sensor drifts" if flawed else ""
    )


def test_a_drift_lasts_until_a_band_has_recovered() -> None:
    rule = GainDrift(P)
    assert rule.flaw(levels(-3.0, -9.0)) == ""  # never fell together
    assert rule.flaw(levels(-4.0, -4.0))
    assert rule.flaw(levels(-3.0, -9.0))
    assert rule.flaw(levels(-2.9, -9.0)) == ""
    assert rule.flaw(levels(-3.0, -9.0)) == ""


def drifted(
    gain: float, *, signal: tuple[float, ...] = (20.0, 10.0, 5.0, 0.1), scatter: float = 0.0, before: tuple[float, ...] = ()
) -> str:
    """Return the flaw once a gain has fallen to a value; four bands of 1, 2, 3 and 4 Hz hear a signal beside noise of density 1.

    The powers are scaled to 20 Hz, as is the signal, but not the noise, at other frequencies ``before`` [Hz].
    """
    widths, rule = np.array([1.0, 2.0, 3.0, 4.0]), GainDrift(P)
    history, flaw = LevelHistory(widths, 1.0), ""
    for frequency in before:
        history.add(widths * (20.0 / frequency) ** 2 + signal, frequency)
    for number in range(12):
        sound = np.array(signal) * (gain**2 if number >= 6 else 1.0) * 10.0 ** (0.1 * scatter * (-1.0) ** number)
        found = history.add(widths + sound, 20.0)
        flaw = rule.flaw(LevelEvidence(found, None)) if found is not None else ""
    return flaw


@pytest.mark.parametrize("gain", [0.69, 0.5, 0.2])
def test_the_noise_of_the_sensor_does_not_hide_a_drift(gain: float) -> None:
    """Of the power, bands 2 and 3 lose less than band 1, and band 4 nothing, but the signal in all of them falls alike."""
    assert "the gain of the sensor drifts" in drifted(gain)
    assert drifted(0.75) == ""  # 2.5 dB


@pytest.mark.parametrize("before", [40.0, 10.0, 0.2])
def test_noise_that_was_heard_at_another_speed_does_not_hide_a_drift(before: float) -> None:
    assert "the gain of the sensor drifts" in drifted(0.5, before=(before, 20.0, before))


def test_a_common_fall_takes_two_bands_with_more_signal_than_noise() -> None:
    assert drifted(0.2, signal=(20.0, 1.5, 0.5, 0.0)) == ""
    assert drifted(0.2, signal=(20.0, 2.1, 0.5, 0.0))


def test_a_drift_exceeds_the_scatter_of_the_hops() -> None:
    """A fall by 4.4 dB is less than 3 dB beyond a scatter of 1 dB in either direction."""
    assert drifted(0.6)
    assert drifted(0.6, scatter=1.0) == ""
    assert drifted(0.4, scatter=1.0)
    loud = (2e4, 1e4, 5e3, 1e3)  # so that the powers of all bands fall alike
    assert drifted(0.6, signal=loud)
    assert drifted(0.6, signal=loud, scatter=2.0) == ""


def test_levels_without_noise_of_which_nothing_is_heard_are_unknown() -> None:
    history = LevelHistory([1.0, 1.0], 1.0)
    found = [history.add(np.array([1.0, 1.0]), 20.0) for _ in range(4)][-1]
    assert found is not None
    assert np.isnan(found.signal).all()
    assert np.isnan(found.signal_fall)
    assert GainDrift(P).flaw(LevelEvidence(found, None)) == ""


def rattling(*shares: float, hops: int = 4) -> list[str]:
    """Return the flaws of hops in which both axes transmit one direction better than the other by shares, after ``hops`` good ones."""
    rule, random = RattlingMount(P), np.random.default_rng(11)
    flaws = []
    for share in (*[0.0] * hops, *shares):
        x, y = random.normal(size=(2, 20000))
        flaws.append(rule.flaw(samples(x + share * np.abs(x), y - share * np.abs(y))))
    return flaws[hops:]


def test_asymmetry_is_the_difference_of_the_two_directions() -> None:
    x = np.random.default_rng(2).normal(size=200_000)
    found = asymmetry(np.column_stack([x + 0.2 * np.abs(x), 1e-6 * (x - 0.3 * np.abs(x)) + 9.0, np.zeros(len(x))]))
    assert found[:, 0] == pytest.approx(0.2, abs=0.01)
    assert found[:, 1] == pytest.approx(-0.3, abs=0.01)
    assert found[:, 2].tolist() == [0.0] * 4


def test_a_mount_that_transmits_one_direction_better_is_loose() -> None:
    found = rattling(0.2, 0.2, 0.2, 0.2, hops=6)
    assert found[0] == ""  # the median of three hops
    assert all("in all axes: the mount of the sensor is loose" in flaw for flaw in found[1:])
    assert not any(rattling(0.02, 0.02, 0.02, hops=6))
    assert not any(rattling(0.2, 0.2, 0.2, hops=0)), "loose from the start"


def test_a_mount_stays_loose_and_may_be_fastened() -> None:
    assert all(rattling(*[0.2] * 130, hops=6)[1:])
    assert rattling(*[0.2] * 4, *[0.0] * 4, hops=6)[-2:] == ["", ""]


def test_an_axis_that_is_added_begins_a_new_comparison() -> None:
    rule, random = RattlingMount(P), np.random.default_rng(13)
    for count in (2, 3):
        for _ in range(8):
            columns = random.normal(size=(5000, count))
            columns += 0.2 * (count == 3) * np.abs(columns)
            assert rule.flaw(SampleEvidence(columns, 5000, 0, RATE, 0.0, 8)) == ""


@pytest.mark.parametrize("small", [0.0, -0.3])
@pytest.mark.parametrize("axes", [1, 2])
def test_what_changes_one_axis_or_large_samples_alone_is_no_mount(axes: int, small: float) -> None:
    """In one axis all samples are transmitted better in one direction, in two axes large ones only, or small ones in the other."""
    rule, random = RattlingMount(P), np.random.default_rng(12)
    for number in range(14):
        columns = random.normal(size=(2, 20000))
        if number >= 8:
            for column in columns[:axes]:
                column += np.where(np.abs(column) > 1.2, 0.3, small if axes == 2 else 0.3) * np.abs(column)
        assert rule.flaw(samples(*columns)) == ""


def test_a_signal_whose_large_samples_are_more_asymmetric_is_no_loose_mount() -> None:
    """So do impacts: ring faults of a measured rig have -0.09 for small samples and -0.22 for large ones."""
    rule, random = RattlingMount(P), np.random.default_rng(14)
    for number in range(14):
        columns = random.normal(size=(2, 20000))
        if number >= 8:
            columns += 0.1 * columns**2  # 0.07 beyond quartiles, 0.2 beyond the 2nd percentiles
        assert rule.flaw(samples(*columns)) == ""


@pytest.mark.parametrize(("ratio", "loose"), [(1.4, True), (1.6, False)])
def test_small_and_large_samples_of_a_loose_mount_change_alike(monkeypatch: pytest.MonkeyPatch, ratio: float, loose: bool) -> None:
    values = iter([0.0] * 8 + [0.1] * 3)
    rows = np.array([[1.0], [1.0], [ratio], [ratio]]) * np.ones((4, 2))
    monkeypatch.setattr(rattling_mount, "asymmetry", lambda _: next(values) * rows)
    rule, hop = RattlingMount(P), samples(*np.zeros((2, 10)))
    assert bool([rule.flaw(hop) for _ in range(11)][-1]) is loose


def test_a_loose_mount_has_lost_eight_decibels_and_is_below_its_level() -> None:
    def level(value: float) -> Any:
        return levels(0.0, 0.0, 0.0, 0.0, level=(50.0, 50.0, 7.0 + value, 7.0))

    rule = LooseMount(P)
    assert [rule.flaw(level(value)) for value in (-14.0, -22.9)] == ["", ""]
    expected = "the third quarter of the band has decreased from 14.0 to 23.0 dB below the band under the detector's"
    assert rule.flaw(level(-23.0)) == f"{expected}: the mount of the sensor is loose"
    rule = LooseMount(P)
    assert [rule.flaw(level(value)) for value in (-40.0, -47.9)] == ["", ""]
    assert rule.flaw(level(-48.0))
    assert LooseMount(DetectorParameters(firm_level=-10.0)).flaw(level(-23.0))
    assert LooseMount(P).flaw(levels(0.0, 0.0, 0.0, 0.0, level=(50.0, 50.0, -90.0, 7.0), third=None)) == ""


def test_a_defect_that_raises_the_band_below_loosens_no_mount() -> None:
    """A spall of 3 mm on the greased bench: the band below rises by 21 dB, and the quarters by 2 to 11 dB."""
    rule = LooseMount(P)
    assert rule.flaw(levels(0.0, 0.0, 0.0, 0.0, 0.0, level=(1.4, -0.4, -3.7, -7.0, 5.8))) == ""
    assert rule.flaw(levels(11.0, 10.0, 5.0, 2.0, 21.7, level=(12.5, 9.6, 1.3, -5.0, 27.5))) == ""
    assert rule.flaw(levels(-6.0, -6.0, -6.8, -2.0, 21.7, level=(-4.6, -6.4, -10.5, -9.0, 27.5)))


def test_a_quiet_bearing_shows_a_loose_mount_in_the_lower_quarters() -> None:
    """The greased bench at 1200 rpm, whose third quarter falls to the noise of the sensor only."""
    loose = levels(-12.7, -13.1, -7.8, -2.1, -3.5, level=(-11.3, -13.5, -11.6, -9.1, 2.4))
    sentence = "the first two quarters of the band have lost 9.2 dB to the band below them: the mount of the sensor is loose"
    assert LooseMount(P).flaw(loose) == sentence
    assert LooseMount(P).flaw(levels(-12.7, -11.4, 0.0, 0.0, -3.5, level=(0.0, 0.0, -8.0, 0.0, 0.0))) == ""
    assert LooseMount(P).flaw(levels(-2.9, -2.9, 0.0, 0.0, 9.0, level=(0.0, 0.0, -8.0, 0.0, 0.0))) == ""


def test_levels_are_averaged_over_four_hops_and_compared_with_the_first_average() -> None:
    history, powers = LevelHistory([1.0, 1.0], 1.0), np.array([1.0, 100.0])
    assert [history.add(powers, 20.0) for _ in range(3)] == [None] * 3
    first = history.add(10.0 * powers, 20.0)
    assert first is not None
    assert first.level.tolist() == [2.5, 22.5]
    assert first.change.tolist() == [0.0, 0.0]
    second = history.add(10.0 * powers, 20.0)
    assert second is not None
    assert second.change.tolist() == [2.5, 2.5]
    assert history.add(np.array([0.0, 1.0]), 20.0) is None
    assert history.add(powers, 0.0) is None
    assert history.add(powers, 20.59) is not None  # not quite 3 % faster
    assert history.add(powers, 20.61) is None
    assert [history.add(powers, 20.61) is None for _ in range(3)] == [True, True, False]
    history.restart()
    assert [history.add(powers, 20.61) is None for _ in range(4)] == [True, True, True, False]


def spiked(*, before: float = 0.0, front: float = 1.0, swing: float = 0.0, height: float = 100.0, at: int = 5000) -> Floats:
    """Return noise of median magnitude 1 with a spike: shares of its height before it, in its first sample, and to the other side."""
    column = noise()
    column /= np.median(np.abs(column - np.median(column)))
    column -= np.median(column)
    column[at - 10 : at + 60] = 0.0
    column[at - 4] = before * height
    column[at : at + 3] = front * height, height, 0.5 * height
    column[at + 8] = -swing * height
    return column


def repeated(count: int) -> Floats:
    """Return noise with such a spike at 1000 samples and its multiples."""
    column = spiked(at=1000)
    for k in range(2, count + 1):
        column[1000 * k - 5 : 1000 * k + 60] = column[995:1060]
    return column


@pytest.mark.parametrize(
    ("changes", "count"),
    [
        ({}, 1),
        ({"height": 27.0}, 1),
        ({"height": 23.0}, 0),
        ({"before": 0.10}, 1),
        ({"before": 0.14}, 0),
        ({"before": -0.14}, 0),
        ({"front": 0.92}, 1),
        ({"front": 0.88}, 0),
        ({"swing": 0.13}, 1),
        ({"swing": 0.17}, 0),
        ({"at": 10000 - 61}, 1),
    ],
)
def test_a_spike_is_quiet_before_steep_and_without_overshoot(changes: dict[str, Any], count: int) -> None:
    assert count_jumps([spiked(**changes)], 51, P).spikes == count
    assert count_jumps([-spiked(**changes)], 51, P).spikes == count
    assert count_jumps([7.0 + spiked(**changes)], 51, P).spikes == count


def test_only_the_millisecond_after_a_spike_and_four_samples_before_it_count() -> None:
    late, early = spiked(), spiked()
    late[5000 + 51], early[5000 - 5] = -20.0, 14.0
    assert count_jumps([late], 51, P).spikes == 1
    assert count_jumps([late], 52, P).spikes == 0
    assert count_jumps([early], 51, P).spikes == 1


@pytest.mark.parametrize("place", [3, 4, 9948, 9949])
def test_a_spike_needs_samples_on_either_side(place: int) -> None:
    column = noise()
    column[place : place + 2] = 200.0, 100.0
    column[max(0, place - 4) : place] = 0.0
    assert count_jumps([column], 51, P).spikes == (4 <= place < 9949)


def test_a_silent_signal_has_no_spikes() -> None:
    column = np.zeros(1000)
    column[500] = 1.0
    assert count_jumps([column], 51, P).spikes == 0


def test_a_spike_is_found_where_many_samples_are_large() -> None:
    """A median is above a threshold only if more than half of the samples are."""
    column = np.where(np.arange(10000) % 5 < 2, 9.0, 0.0) * np.sign(noise()) + 0.1 * noise()
    column[4990:5060] = 0.0
    column[5000:5002] = 200.0, 100.0
    median = float(np.median(np.abs(column - np.median(column))))
    assert 25.0 * median < 200.0
    assert count_jumps([column], 51, P).spikes >= 1


def test_spikes_of_a_window_add_up() -> None:
    rule, quiet = Spikes(P), noise()
    assert [bool(rule.flaw(samples(spiked(), quiet, hops=3))) for _ in range(3)] == [False, False, True]
    assert rule.flaw(samples(spiked(), quiet, hops=3)) == "3 spikes without ringing in the window: a cable or its plug is loose"
    assert rule.flaw(samples(quiet, quiet, hops=3)) == ""  # none in this hop
    assert rule.flaw(samples(spiked(), quiet, hops=3)) == ""  # two in the window
    assert Spikes(P).flaw(samples(spiked(), spiked(), hops=3)) == ""


def test_a_pulse_in_several_axes_is_one_spike() -> None:
    spikes = repeated(3)
    moved = np.roll(spikes, 40)  # 0.8 ms later
    assert count_jumps([spikes, -spikes, moved], 51, P) == (3, 0)
    assert count_jumps([spikes, np.roll(spikes, 60)], 51, P) == (6, 0)
    assert Spikes(P).flaw(samples(spikes, -spikes)) == "3 spikes without ringing in the window: a cable or its plug is loose"


def test_a_signal_of_one_axis_which_is_given_as_two_counts_once() -> None:
    spikes, limited, saturation = repeated(2), clipped(20), Saturation(P)
    assert Spikes(P).flaw(samples(spikes, spikes)) == ""
    assert saturation.flaw(samples(limited, limited)) == ""
    assert saturation.clipped == 20
    assert [axis for axis, _ in samples(limited, limited).axes] == ["X"]


def test_nothing_is_compared_with_what_was_before_a_restart() -> None:
    spikes, loud = Spikes(P), 100.0 * tones({(200.0, 20480.0): 20.0})
    for _ in range(2):
        spikes.flaw(samples(spiked(), noise(), hops=3))
    spikes.restart()
    assert spikes.flaw(samples(spiked(), noise(), hops=3)) == ""
    dead, mount = Dead(P), RattlingMount(P)
    for rule in (dead, mount):
        for _ in range(8):
            rule.flaw(samples(loud, loud))
        rule.restart()
    assert dead._powers == {}
    assert mount._change() == 0.0


@pytest.mark.parametrize(("impacts", "flawed"), [(3, True), (4, False)])
def test_spikes_among_as_many_impacts_are_chance(impacts: int, flawed: bool) -> None:
    """An impact rises over several samples; one that is lower than every spike does not count."""
    column = repeated(3)
    for k in range(4, 4 + impacts):
        column[1000 * k : 1000 * k + 4] = 100.0, 200.0, 300.0, -250.0
    column[9000:9004] = 20.0, 40.0, 60.0, -50.0
    assert count_jumps([column], 51, P) == (3, impacts)
    assert bool(Spikes(P).flaw(samples(column, noise()))) is flawed


def test_an_impact_that_rises_over_many_samples_is_as_high_as_a_spike() -> None:
    column = repeated(3)
    for k in range(4, 8):
        column[1000 * k : 1000 * k + 80] = 200.0 * np.sin(np.pi * np.arange(80) / 80.0)
    assert count_jumps([column], 51, P) == (3, 4)
