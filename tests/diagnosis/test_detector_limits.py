"""The detector at its limits: bands, shortest hop, first verdict, turns, missing samples, and what it publishes."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from synthetic_bearing import ORDERS, RATE, TURN, diagnoses, synthetic

from dcrb_ros.diagnosis.demodulation import Band, band_tree, detector_bands
from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector, _rescaled
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.schema.refusal import Refusal

SHORT = {"window": 0.5, "least_window": 0.5, "hop": 0.25, "least_turns": 4.0}


def course(seconds: float = 1.5, *, frequency: float = 20.0, angle: Any = None, **parameters: Any) -> list[Diagnosis]:
    acceleration, turning = synthetic(seconds=seconds, frequency=frequency, outer=600.0)
    detector = FaultDetector(ORDERS, RATE, DetectorParameters(**{**SHORT, **parameters}))
    return diagnoses(detector, (acceleration, turning if angle is None else angle))


def test_the_bands_are_the_whole_its_halves_thirds_and_quarters_and_the_one_below() -> None:
    whole, high, bands = detector_bands(51200, 2000.0, 20000.0, divided=True)
    tree = band_tree(2000.0, 20000.0)
    assert (whole, high, bands) == (Band(2000.0, 20000.0), tree[-1], (*tree, Band(1000.0, 2000.0)))
    assert len(bands) == 11
    assert detector_bands(51200, 2000.0, 20000.0, divided=False)[2] == (Band(2000.0, 20000.0), Band(1000.0, 2000.0))


@pytest.mark.parametrize("rate", [12000, 25600])
def test_the_tree_divides_what_lies_below_0_45_of_the_sampling_rate(rate: int) -> None:
    whole, high, bands = detector_bands(rate, 2000.0, 20000.0, divided=True)
    assert whole == Band(2000.0, 0.45 * rate)
    assert high == band_tree(2000.0, 20000.0, (4,))[-1]
    assert bands == (*band_tree(2000.0, 0.45 * rate), Band(1000.0, 2000.0))


@pytest.mark.parametrize(("low", "refused"), [(9216.0, False), (9217.0, True)])
def test_a_band_is_at_least_a_quarter_wide(low: float, refused: bool) -> None:
    if not refused:
        assert detector_bands(25600, low, 20000.0, divided=True)[0] == Band(9216.0, 11520.0)
        return
    sentence = "band_low = 9217 Hz leaves no band below 11520 Hz, .* it must be at most 9216 Hz"
    with pytest.raises(Refusal, match=sentence):
        detector_bands(25600, low, 20000.0, divided=True)


@pytest.mark.parametrize(("hop", "refused"), [(0.2, False), (0.199, True)])
def test_a_hop_is_at_least_twenty_periods_of_the_lowest_frequency(hop: float, refused: bool) -> None:
    """The lowest frequency is half of the band's: 100 Hz. Ten periods on either side are 0.2 s."""
    parameters = DetectorParameters(hop=hop, band_low=200.0)
    if refused:
        with pytest.raises(Refusal, match=r"hop = 0.199 s is below 0.2 s, .*: make it longer"):
            FaultDetector(ORDERS, RATE, parameters)
    else:
        FaultDetector(ORDERS, RATE, parameters)


def test_a_window_may_be_one_hop() -> None:
    FaultDetector(ORDERS, RATE, DetectorParameters(window=0.5, least_window=0.5, hop=0.5))


@pytest.mark.parametrize(("rise", "refused"), [(48.9, False), (49.0, True)])
def test_a_healthy_rise_that_is_too_hot_is_refused(rise: float, refused: bool) -> None:
    parameters = DetectorParameters(heat_learn=0.0, heat_rise=rise, heat_rise_deviation=2.0)
    if refused:
        with pytest.raises(Refusal, match=r"heat_rise = 49 K .* is 45 K, not below heat_most = 45 K, .*: lower heat_rise or raise"):
            FaultDetector(ORDERS, RATE, parameters)
    else:
        FaultDetector(ORDERS, RATE, parameters)


@pytest.mark.parametrize(
    ("parameters", "waiting"),
    [
        ({}, 2),
        ({"window": 1.0, "least_window": 1.0}, 4),
        ({"window": 1.0}, 2),
        ({"confirm": 3}, 3),
        ({"window": 0.5, "least_window": 9.0}, 2),
    ],
)
def test_the_first_verdict_needs_its_window_and_its_confirmation(parameters: dict[str, Any], waiting: int) -> None:
    verdicts = [diagnosis.verdict for diagnosis in course(**parameters)]
    assert verdicts == ["waiting"] * waiting + ["outer_ring"] * (6 - waiting)


def test_what_is_missing_is_given_in_seconds_and_revolutions() -> None:
    first = course(window=1.0, least_window=1.0)[1]
    assert first.reason == "0.5 s of the 1 s that a verdict needs have arrived"
    slow = course(least_turns=30.0)[-1]
    assert slow.reason == "the shaft made 10 revolutions in 0.5 s, but a verdict needs 30"
    assert slow.verdict == "waiting"


@pytest.mark.parametrize(("share", "verdict"), [(0.15, "outer_ring"), (0.25, "waiting")])
def test_a_share_of_the_window_may_be_missing(share: float, verdict: str) -> None:
    data, block = synthetic(seconds=3.0, outer=600.0), round(5120 * (1.0 - share))
    last = diagnoses(FaultDetector(ORDERS, RATE), data, block=block, begins=range(0, len(data[1]), 5120))[-1]
    assert last.verdict == verdict
    if verdict == "waiting":
        missing, allowed = (int(number) for number in re.findall(r"(\d+) %", last.reason))
        assert missing == pytest.approx(100.0 * share + 11.0, abs=2)  # the filter rings beside each gap
        assert allowed == 30


def test_a_bearing_that_turns_too_slowly_for_the_window_is_not_judged_by_its_noise() -> None:
    """Twelve turns in four seconds are 3 Hz: below, a dead sensor may be a bearing at rest."""
    acceleration, _ = synthetic(seconds=2.0)
    acceleration[:] = 1.5
    for frequency, verdict in ((2.9, "waiting"), (3.1, "sensor")):
        angle = np.mod(TURN * frequency * np.arange(len(acceleration)) / RATE, TURN).astype(np.float32)
        assert {diagnosis.verdict for diagnosis in diagnoses(FaultDetector(ORDERS, RATE), (acceleration, angle))} == {verdict}


def test_severity_is_the_size_in_the_reason_and_the_spectrum() -> None:
    last = course(band="fixed", outer_limit=38.0)[-1]
    (size,) = re.findall(r"has ([\d.]+) m/s\^2 \(baseline 38 m/s\^2", last.reason)
    assert last.severity == pytest.approx(float(size), rel=0.01)
    assert course(seconds=0.75, band="fixed", outer_limit=38.0)[-1].severity in (0.0, pytest.approx(last.severity, rel=0.2))
    assert last.confidence == pytest.approx(min(0.99, 1.0 - 0.5 * 10.0 ** (-last.scores["outer_ring"] / 4.0)))
    assert last.shaft_frequency == pytest.approx(20.0, rel=1e-3)
    assert set(last.scores) == {"outer_ring", "inner_ring", "roller", "cage"}


@pytest.mark.parametrize("frequency", [20.0, 35.0])
def test_the_published_spectrum_ends_at_the_highest_order_and_has_the_present_level(frequency: float) -> None:
    """The highest order is 1.02 (3 max(2 BPFO, 2 BPFI, 2 BSF) + 2); the first point is the root of the mean squared envelope."""
    acceleration, angle = synthetic(seconds=1.5, frequency=frequency)
    acceleration += (30.0 * np.cos(TURN * 6000.0 * np.arange(len(angle)) / RATE))[:, None].astype(np.float32)
    last = diagnoses(FaultDetector(ORDERS, RATE, DetectorParameters(**SHORT, band="fixed")), (acceleration, angle))[-1]
    orders, amplitude = last.spectrum
    highest = 1.02 * (3.0 * max(2.0 * ORDERS.bpfo, 2.0 * ORDERS.bpfi, 2.0 * ORDERS.bsf) + 2.0)
    assert highest - 2.0 * orders[1] < orders[-1] <= highest
    assert amplitude[0] == pytest.approx(30.0 * math.sqrt(2.0), rel=0.03)  # two axes


def test_the_published_spectrum_has_the_present_level_at_a_slow_shaft() -> None:
    rate, seconds = 12000, 14.5
    acceleration, angle = synthetic(seconds=seconds, frequency=0.3, rate=rate)
    acceleration += (30.0 * np.cos(TURN * 4000.0 * np.arange(len(angle)) / rate))[:, None].astype(np.float32)
    parameters = DetectorParameters(window=14.0, least_window=14.0, least_turns=4.0, band="fixed")
    last = diagnoses(FaultDetector(ORDERS, rate, parameters), (acceleration, angle))[-1]
    assert last.spectrum[1][0] == pytest.approx(30.0 * math.sqrt(2.0), rel=0.03)


def test_a_spectrum_over_a_clock_is_rescaled_to_orders() -> None:
    found = _rescaled(OrderSpectrum(np.array([0.0, 1.0]), np.array([2.0, 4.0], np.float32), 6.0), 3.0, 2.0)
    assert (found.orders.tolist(), found.amplitude.tolist(), found.mean) == ([0.0, 3.0], [1.0, 2.0], 3.0)


def test_a_sensor_fault_lasts_until_its_samples_have_left_the_window() -> None:
    acceleration, angle = synthetic(seconds=2.5, outer=600.0)
    acceleration[13000:14000] = np.nan  # in the second hop
    detector = FaultDetector(ORDERS, RATE, DetectorParameters(**{**SHORT, "window": 0.75}))
    verdicts = [diagnosis.verdict for diagnosis in diagnoses(detector, (acceleration, angle))]
    assert verdicts == ["waiting", *["sensor"] * 3, "waiting", *["outer_ring"] * 5]


def test_remarks_count_irregularities() -> None:
    acceleration, angle = synthetic(seconds=1.5, outer=600.0)
    acceleration[20000:20003] = np.inf
    detector = FaultDetector(ORDERS, RATE, DetectorParameters(**SHORT))
    arriving = (k for k in sorted([*range(0, len(angle), 1024), 10240]) if k != 5120)
    found = diagnoses(detector, (acceleration, angle), begins=arriving)[-1]
    assert found.remarks[:3] == (
        "1024 samples lost in gaps",
        "1024 samples arrived twice or too late and were ignored",
        "3 samples are not finite numbers",
    )
    assert found.gaps == 1
    assert found.remarks[-1] == found.spectrum_remark
    assert found.spectrum_remark.startswith("the squared envelope spectrum is that of the band from ")


def test_a_shaft_too_fast_for_the_orders_is_answered_with_the_number_of_bins(monkeypatch: pytest.MonkeyPatch) -> None:
    limit = "dcrb_ros.diagnosis.window.MOST_BINS"
    most = course()[-1]
    bins = round(20.0 * 0.5 * math.ceil(3 * 1.02 * (3 * 2 * ORDERS.bpfi + 2)))  # turns of a window of 0.5 s, bins of a turn
    monkeypatch.setattr(limit, 1.01 * bins)
    assert course()[-1].reason == most.reason
    monkeypatch.setattr(limit, 0.99 * bins)
    last = course()[-1]
    assert last.verdict == "waiting"
    assert re.search(r"the lines up to order \d+ need \d+ bins in a window, more than", last.reason)


@pytest.mark.parametrize("slowest", [70.0, 90.0])
def test_the_speeds_to_be_estimated_are_a_range(slowest: float) -> None:
    with pytest.raises(Refusal, match=f"slowest = {slowest:g} Hz is not below fastest = 70 Hz: lower slowest or raise fastest"):
        FaultDetector(ORDERS, RATE, DetectorParameters(slowest=slowest))


@pytest.mark.parametrize("rate", [10**12, 0, 0.5, math.nan])
def test_a_detector_has_a_possible_sampling_rate(rate: Any) -> None:
    with pytest.raises(Refusal, match=r"the signal gives a sampling rate of .* Hz: it must be a whole number within 1 \.\. 10000000 Hz"):
        FaultDetector(ORDERS, rate)
