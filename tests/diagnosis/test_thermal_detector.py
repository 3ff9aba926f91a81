"""The shipped detector with temperatures: the same as without them if there are none, two more verdicts if there are."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np
import pytest
from synthetic_bearing import ORDERS, RATE, Signal, diagnoses, synthetic

from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import ThermalFaultDetector
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics.diagnosis import decode_scores, encode_diagnosis
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.diagnosis import Diagnosis

HOT = 170.0
"""[deg C]"""
WARM = 45.0
"""[deg C]"""


def detector(**parameters: Any) -> ThermalFaultDetector:
    return ThermalFaultDetector(ORDERS, RATE, DetectorParameters(**parameters))


@cache
def healthy() -> Signal:
    return synthetic(seconds=3.0)


@cache
def damaged() -> Signal:
    return synthetic(outer=300.0, seconds=4.0)


def heated(data: Signal, temperature: float, watching: ThermalFaultDetector | None = None) -> list[Diagnosis]:
    """Return the diagnoses of a signal with a reading every fifth of a second."""
    one, (acceleration, angle) = watching or detector(), data
    found = []
    for k in range(0, len(angle), RATE // 5):
        found.append(one.update(k, acceleration[k : k + RATE // 5], angle[k : k + RATE // 5]))
        one.take_temperature(k / RATE, temperature, 20.0)
    return [diagnosis for diagnosis in found if diagnosis is not None]


@pytest.mark.parametrize("signal", [healthy, damaged])
def test_without_temperatures_the_diagnoses_are_the_same(signal: Any) -> None:
    plain, thermal = diagnoses(FaultDetector(ORDERS, RATE), signal()), diagnoses(detector(), signal())
    assert len(plain) == len(thermal) > 4
    for one, other in zip(plain, thermal, strict=True):
        for field in dataclasses.fields(Diagnosis):
            if field.name != "spectrum":
                assert getattr(one, field.name) == getattr(other, field.name)
        assert np.array_equal(one.spectrum[1], other.spectrum[1])


def test_a_warm_bearing_stays_healthy_and_the_rise_is_remarked() -> None:
    last = heated(healthy(), WARM)[-1]
    assert last.verdict == "healthy"
    assert last.remarks[-1].startswith("the bearing is 25.0 K above ambient, ")
    assert last.scores["overheating"] < 0.0


def test_a_hot_bearing_overheats() -> None:
    last = heated(healthy(), HOT)[-1]
    assert last.verdict == "overheating"
    assert "150.0 K above ambient" in last.reason
    assert last.confidence > 0.9
    assert last.scores["overheating"] > 0.0


def test_a_hot_bearing_with_a_defect_has_several_faults() -> None:
    last = heated(damaged(), HOT)[-1]
    assert last.verdict == "compound"
    assert last.faults == ("outer_ring", "overheating")
    assert last.title == "several faults: outer ring defect, overheating"
    assert "BPFO" in last.reason
    assert "it overheats" in last.reason


def test_a_faulty_accelerometer_does_not_hide_a_hot_bearing() -> None:
    acceleration, angle = healthy()
    dead = np.zeros_like(acceleration), angle
    assert heated(dead, WARM)[-1].verdict == "sensor"
    assert heated(dead, HOT)[-1].verdict == "overheating"


@pytest.mark.parametrize(("pause", "verdict"), [(599.0, "overheating"), (602.0, "healthy")])
def test_a_reading_counts_for_ten_minutes(pause: float, verdict: str) -> None:
    one, (acceleration, angle) = detector(), healthy()
    for k in range(20):
        one.update(k * 1024, acceleration[k * 1024 : (k + 1) * 1024], angle[k * 1024 : (k + 1) * 1024])
        one.take_temperature(0.02 * k, HOT, 20.0)
    assert diagnoses(one, (acceleration, angle), first=round((pause - 2.5) * RATE))[-1].verdict == verdict


def test_after_a_pause_of_the_readings_the_last_one_before_it_does_not_count() -> None:
    judge = ThermalFaultDetector(ORDERS, RATE)._monitor
    for time in (0.0, 1.0, 2.0, 3.0):
        judge.update(time, 20.0, HOT, 20.0)
    assert judge.judgement_at(603.0) is not None
    assert judge.judgement_at(603.1) is None
    assert judge.update(700.0, 20.0, HOT, 20.0) is None
    assert judge.judgement_at(700.0) is None


def test_readings_that_are_not_judged_after_a_pause_are_remarked() -> None:
    one, (acceleration, angle) = detector(), healthy()
    for k, number in enumerate(range(0, len(angle), RATE // 5)):
        last = one.update(number, acceleration[number : number + RATE // 5], angle[number : number + RATE // 5])
        one.take_temperature((k - 20) * 900.0, HOT, 20.0)
    assert last is not None
    assert last.remarks[-1] == "13 temperatures followed more than 600 s after the one before, and were not judged"


def test_a_bearing_that_cools_at_an_unknown_speed_is_not_starved() -> None:
    one = detector(heat_rise_deviation=1.0, heat_time_lapse=600.0)
    signal, found = np.concatenate([damaged()[0], synthetic(seconds=4.0)[0]]), list[Diagnosis]()
    for k in range(0, len(signal), RATE // 5):
        diagnosis = one.update(k, signal[k : k + RATE // 5])
        found += [diagnosis] if diagnosis is not None else []
        one.take_temperature(k / RATE, 54.0 if k < RATE or found[-1].shaft_frequency else 21.0, 20.0)
    assert max(diagnosis.shaft_frequency for diagnosis in found) == pytest.approx(20.0, rel=0.01)
    assert {diagnosis.verdict for diagnosis in found if diagnosis.time > 7.0} == {"waiting"}  # no line has a speed


def test_a_hot_bearing_overheats_at_an_unknown_speed() -> None:
    """A dead accelerometer without a shaft angle says nothing of the speed."""
    one = detector(heat_rise_deviation=1.0, heat_time_lapse=600.0)
    signal, found = np.concatenate([damaged()[0], np.zeros_like(damaged()[0])]), list[Diagnosis]()
    for k in range(0, len(signal), RATE // 5):
        diagnosis = one.update(k, signal[k : k + RATE // 5])
        found += [diagnosis] if diagnosis is not None else []
        one.take_temperature(k / RATE, 54.0 if k < len(signal) // 2 else 200.0, 20.0)
    assert found[-1].verdict == "overheating"


def test_a_verdict_on_heat_ends_with_the_reset_of_a_short_run() -> None:
    one = detector()
    heated(healthy(), HOT, one)
    assert diagnoses(one, healthy())[-1].verdict == "healthy"  # from index 0 again, without thermometers


def test_a_bearing_that_cools_while_no_signal_arrives_is_not_starved() -> None:
    one, (acceleration, angle) = detector(heat_rise_deviation=1.0), healthy()
    diagnoses(one, (acceleration, angle))
    for minute in range(60, 180):  # the thermometers go on
        one.take_temperature(60.0 * minute, 21.0, 20.0)
    assert diagnoses(one, (acceleration, angle), first=180 * 60 * RATE)[-1].verdict == "healthy"


def test_readings_that_are_no_temperatures_are_remarked() -> None:
    last = heated(healthy(), float("nan"))[-1]
    assert last.verdict == "healthy"
    assert any("readings were no temperatures" in remark for remark in last.remarks)


def test_the_scores_of_temperatures_are_published() -> None:
    last = heated(healthy(), HOT)[-1]
    _, (status,) = decode_diagnostics(encode_diagnosis(last))
    assert decode_scores(status.values)["overheating"] == pytest.approx(last.scores["overheating"], abs=0.01)
    assert status.level == 2


def louder(factor: float) -> Signal:
    """Return a signal whose noise is louder after 4 s, without lines."""
    acceleration, angle = synthetic(seconds=11.0)
    louder = acceleration.copy()
    louder[4 * RATE :] *= factor
    return louder, angle


def test_a_loss_of_films_is_heard_if_asked_for() -> None:
    signal = louder(2.0)
    assert {one.verdict for one in diagnoses(detector(), signal)} == {"waiting", "healthy"}
    found = diagnoses(detector(starved_noise=4.0), signal)
    assert found[-1].verdict == "lubrication"
    assert "risen by 6.1 dB" in found[-1].reason
    first = next(one.time for one in found if one.verdict == "lubrication")
    assert 4.0 + 4.0 <= first <= 4.0 + 6.5


def test_the_loss_of_films_is_not_judged_while_the_shaft_does_not_turn() -> None:
    acceleration, angle = louder(2.0)
    angle[round(9.5 * RATE) :] = angle[round(9.5 * RATE)]
    found = diagnoses(detector(starved_noise=4.0), (acceleration, angle))
    assert "lubrication" in {one.verdict for one in found if one.time < 9.5}
    assert "lubrication" not in {one.verdict for one in found if one.time > 10.1}


def test_less_noise_than_the_threshold_is_no_loss() -> None:
    assert {one.verdict for one in diagnoses(detector(starved_noise=4.0), louder(1.5))} == {"waiting", "healthy"}


@pytest.mark.parametrize(("rate", "parameters"), [(25600, {}), (RATE, {"band": "fixed"})])
def test_the_level_of_vibration_needs_the_quarters_of_the_band(rate: int, parameters: dict[str, Any]) -> None:
    with pytest.raises(Refusal, match=r"starved_noise = 4 dB compares the quarters of the band from 2000 to 20000 Hz"):
        ThermalFaultDetector(ORDERS, rate, DetectorParameters(starved_noise=4.0, **parameters))
    ThermalFaultDetector(ORDERS, 25600, DetectorParameters(starved_noise=4.0, band_high=11520.0))  # 0.45 of the sampling rate


def test_speeds_are_learned_one_by_one() -> None:
    """The level grows with the speed of a healthy bearing; at another speed it is learned anew."""
    slow, fast = synthetic(seconds=4.0), synthetic(seconds=6.0, frequency=30.0)
    angle = np.concatenate([slow[1], np.mod(slow[1][-1] + fast[1], 2.0 * np.pi)]).astype(np.float32)
    signal = np.concatenate([slow[0], 3.0 * fast[0]]), angle
    assert "lubrication" not in {one.verdict for one in diagnoses(detector(starved_noise=4.0), signal)}
