"""The detector on synthetic bearings, on irregular signals and on the shipped recordings."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_bearing import ORDERS, RATE, TURN, Signal, diagnoses, synthetic

from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.diagnosis.detection import watch
from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import read_parameters

BAGS = Path(__file__).parents[2] / "bags"


def last(data: Signal, **parameters: Any) -> Diagnosis:
    """Return the last diagnosis of a stream."""
    return diagnoses(FaultDetector(ORDERS, RATE, DetectorParameters(**parameters)), data)[-1]


def comparable(diagnosis: Diagnosis) -> tuple[Any, ...]:
    """Return what must not depend on the size of the blocks."""
    return diagnosis.index, diagnosis.verdict, diagnosis.reason, diagnosis.levels, diagnosis.confidence, diagnosis.scores


@pytest.mark.parametrize(
    ("impacts", "verdict"),
    [
        ({}, "healthy"),
        ({"outer": 600.0}, "outer_ring"),
        ({"inner": 900.0}, "inner_ring"),
        ({"roller": 900.0}, "roller"),
        ({"cage": 300.0}, "cage"),
        ({"outer": 600.0, "inner": 1500.0}, "compound"),
    ],
)
def test_synthetic_defects_are_diagnosed(impacts: dict[str, float], verdict: str) -> None:
    diagnosis = last(synthetic(**impacts))
    assert diagnosis.verdict == verdict, diagnosis.reason
    assert 0.5 <= diagnosis.confidence <= 1.0


@pytest.mark.parametrize("name", ["outer", "inner", "roller", "cage"])
@pytest.mark.parametrize("frequency", [10.0, 30.0])
def test_the_verdict_does_not_depend_on_the_speed(name: str, frequency: float) -> None:
    verdict = {"outer": "outer_ring", "inner": "inner_ring"}.get(name, name)
    assert last(synthetic(frequency=frequency, **{name: 1500.0})).verdict == verdict


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("healthy", "healthy"),
        ("paper", "healthy"),
        ("outer_ring_defect", "outer_ring"),
        ("inner_ring_defect", "inner_ring"),
        ("cage_fracture", "cage"),
        ("compound", "compound"),
        ("run_up", "outer_ring"),
    ],
)
def test_shipped_recordings_are_diagnosed(name: str, verdict: str) -> None:
    recording = Recording(BAGS / name)
    detector = FaultDetector(recording.orders, recording.sampling_rate)
    detector.take_bearing(recording.bearing)
    blocks = recording.vibrations()
    found = [detector.update(block.first_index(RATE), block.acceleration, block.shaft_angle) for block in blocks]
    # Of two faults, the fainter one may be named half a second later.
    first = {"outer_ring"} if verdict == "compound" else set()
    assert {diagnosis.verdict for diagnosis in found if diagnosis is not None} - first == {"waiting", verdict}
    assert [diagnosis.verdict for diagnosis in found if diagnosis is not None][-1] == verdict


def test_a_fault_that_begins_later_is_diagnosed_within_five_seconds() -> None:
    before, after = synthetic(seconds=3.0), synthetic(inner=900.0, seconds=5.0, seed=2)
    detector = FaultDetector(ORDERS, RATE)
    assert diagnoses(detector, before)[-1].verdict == "healthy"
    found = [diagnosis.verdict for diagnosis in diagnoses(detector, after, first=len(before[1]))]
    assert set(found) == {"healthy", "inner_ring"}
    assert found.index("inner_ring") < 10


def test_a_shallow_bpfo_line_is_healthy_however_significant() -> None:
    diagnosis = last(synthetic(outer=1.0))
    assert diagnosis.levels["BPFO"] > 5.0
    assert diagnosis.verdict == "healthy"


@pytest.mark.parametrize(
    ("impacts", "parameters", "sentence"),
    [
        ({}, {}, "no lines exceed all limits for a defect; "),
        ({"outer": 600.0}, {"outer_limit": 1e3}, "no lines exceed all limits for a defect; "),
        (
            {"outer": 600.0},
            {"alarm_evidence": 20.0},
            "lines exceed all limits for a defect by {:.1f} dB, less than the 20.0 dB required; BPFO at",
        ),
    ],
)
def test_the_reason_of_a_healthy_diagnosis_agrees_with_its_evidence(
    impacts: dict[str, float], parameters: dict[str, float], sentence: str
) -> None:
    diagnosis = last(synthetic(**impacts), **parameters)
    assert diagnosis.verdict == "healthy"
    assert diagnosis.reason.startswith(sentence.format(max(diagnosis.scores.values())))


@pytest.mark.parametrize(("limit", "verdict"), [(1e3, "healthy"), (2.0, "outer_ring")])
def test_with_a_baseline_the_size_of_the_lines_counts(limit: float, verdict: str) -> None:
    diagnosis = last(synthetic(outer=600.0), outer_limit=limit)
    assert diagnosis.verdict == verdict
    assert "baseline" in "; ".join(diagnosis.remarks)


@pytest.mark.parametrize("gain", [0.01, 100.0])
@pytest.mark.parametrize("impacts", [{}, {"outer": 100.0}, {"inner": 200.0}, {"cage": 100.0}], ids=["healthy", "outer", "inner", "cage"])
def test_no_gain_changes_the_verdict(impacts: dict[str, float], gain: float) -> None:
    acceleration, angle = synthetic(seconds=2.6, **impacts)
    one, other = last((acceleration, angle)), last(((gain * acceleration).astype(np.float32), angle))
    assert (one.verdict, one.confidence) == (other.verdict, pytest.approx(other.confidence, abs=0.01))


def test_learned_lines_are_healthy_until_they_grow() -> None:
    detector = FaultDetector(ORDERS, RATE, DetectorParameters(learn=2.0))
    loud, worse = synthetic(outer=400.0, seconds=4.5), synthetic(outer=1600.0, seconds=4.0, seed=2)
    found = diagnoses(detector, loud)
    assert "learning" in "; ".join(found[5].remarks)
    assert found[-1].verdict == "healthy"
    assert diagnoses(detector, worse, first=len(loud[1]))[-1].verdict == "outer_ring"


def test_severity_is_proportional_to_the_impacts() -> None:
    weak, strong = last(synthetic(outer=400.0)), last(synthetic(outer=800.0))
    assert strong.severity == pytest.approx(2.0 * weak.severity, rel=0.1)


@pytest.mark.parametrize("seed", range(3))
def test_noise_alone_is_healthy(seed: int) -> None:
    assert last(synthetic(seed=seed)).verdict == "healthy"


def test_a_speed_ramp_does_not_hide_a_defect() -> None:
    diagnosis = last(synthetic(outer=600.0, frequency=12.0, ramp=8.0))
    assert diagnosis.verdict == "outer_ring"
    assert diagnosis.shaft_frequency == pytest.approx(24.0, rel=0.01)
    assert diagnosis.levels["BPFO"] > 15.0


def test_direction_of_rotation_does_not_matter() -> None:
    acceleration, angle = synthetic(inner=900.0)
    backward = np.mod(-angle.astype(np.float64), TURN).astype(np.float32)
    assert last((acceleration, backward)).levels["BPFI"] == pytest.approx(last((acceleration, angle)).levels["BPFI"], abs=0.3)


def test_spectrum_has_the_line_at_its_order() -> None:
    orders, amplitude = last(synthetic(outer=600.0)).spectrum
    near = np.abs(orders - ORDERS.bpfo) < 1.0
    assert orders[near][np.argmax(amplitude[near])] == pytest.approx(ORDERS.bpfo * 0.998, abs=0.02)


def test_of_a_whole_signal_the_last_verdict_alone_has_its_spectrum() -> None:
    """Also if nothing follows but hops without a verdict, as after a gap."""
    acceleration, angle = synthetic(outer=600.0, seconds=4.0)
    cut = np.r_[: round(3.1 * RATE), round(3.4 * RATE) : len(angle)]
    whole = Waveform.from_arrays(acceleration, RATE, shaft_angle=angle, bearing=ORDERS)
    parted = dataclasses.replace(whole, acceleration=acceleration[cut], shaft_angle=angle[cut], index=np.arange(len(angle))[cut])
    for signal, hops in ((whole, 8), (parted, 7)):
        found = watch(signal)
        assert [diagnosis for diagnosis in found.history if len(diagnosis.spectrum[0])] == [found.last]
        assert (found.last.verdict, len(found.history)) == ("outer_ring", hops)
    short = watch(whole.between(0.0, 2.1))
    assert [len(diagnosis.spectrum[0]) > 0 for diagnosis in short.history] == [False] * 3 + [True]


def test_there_is_a_diagnosis_per_hop_and_a_verdict_once_confirmed() -> None:
    found = diagnoses(FaultDetector(ORDERS, RATE), synthetic(outer=600.0))
    assert [diagnosis.verdict for diagnosis in found] == ["waiting"] * 4 + ["outer_ring"] * 2
    assert [diagnosis.index for diagnosis in found] == [k * RATE // 2 - 1 for k in range(1, 7)]
    assert "of the 2 s" in found[0].reason
    assert "to be confirmed" in found[3].reason
    assert found[-1].time == pytest.approx(found[-1].index / RATE)


@pytest.mark.parametrize("block", [64, 1000, 25600])
def test_verdicts_do_not_depend_on_the_block_size(block: int) -> None:
    data = synthetic(outer=600.0, seconds=2.6)
    expected, found = diagnoses(FaultDetector(ORDERS, RATE), data), diagnoses(FaultDetector(ORDERS, RATE), data, block=block)
    assert [comparable(one) for one in expected] == [comparable(other) for other in found]
    for one, other in zip(expected, found, strict=True):
        np.testing.assert_array_equal(one.spectrum, other.spectrum)


def test_a_long_block_gives_its_last_diagnosis() -> None:
    data = synthetic(outer=600.0, seconds=2.9)
    (found,) = diagnoses(FaultDetector(ORDERS, RATE), data, block=len(data[1]))
    assert comparable(found) == comparable(diagnoses(FaultDetector(ORDERS, RATE), data)[-1])


@pytest.mark.parametrize("rate", [12800, 25600, 102400])
@pytest.mark.parametrize(("outer", "verdict"), [(0.0, "healthy"), (2000.0, "outer_ring")])
def test_other_sampling_rates(rate: int, outer: float, verdict: str) -> None:
    assert diagnoses(FaultDetector(ORDERS, rate), synthetic(outer=outer, rate=rate))[-1].verdict == verdict


def test_short_gaps_are_bridged_and_reported() -> None:
    arriving = (k for k in range(0, 3 * RATE, 1024) if k // 1024 % 10 != 7)
    final = diagnoses(FaultDetector(ORDERS, RATE), synthetic(outer=600.0), begins=arriving)[-1]
    assert final.verdict == "outer_ring"
    assert final.gaps == 15
    assert "15360 samples lost in gaps" in final.remarks


def test_long_gap_starts_a_new_window() -> None:
    detector = FaultDetector(ORDERS, RATE)
    data = synthetic(outer=600.0)
    assert diagnoses(detector, data, first=5000)[-1].verdict == "outer_ring"
    after = diagnoses(detector, data, first=5000 + len(data[1]) + RATE)
    assert [diagnosis.verdict for diagnosis in after] == ["waiting"] * 4 + ["outer_ring"] * 2
    assert {diagnosis.gaps for diagnosis in after} == {1}


def test_a_standing_shaft_gives_no_verdict() -> None:
    acceleration, angle = synthetic()
    diagnosis = last((acceleration, np.zeros_like(angle)))
    assert diagnosis.verdict == "waiting"
    assert "revolutions" in diagnosis.reason
    assert diagnosis.shaft_frequency == 0.0


def test_a_reversing_shaft_gives_no_verdict() -> None:
    acceleration, _ = synthetic()
    time = np.arange(len(acceleration)) / RATE
    angle = TURN * (40.0 * time - 14.8 * time**2)
    diagnosis = diagnoses(FaultDetector(ORDERS, RATE), (acceleration, np.mod(angle, TURN).astype(np.float32)))[2]
    assert diagnosis.verdict == "waiting"
    assert "reversed" in diagnosis.reason


@pytest.mark.parametrize(("name", "verdict"), [("outer", "outer_ring"), ("inner", "inner_ring")])
@pytest.mark.parametrize("absent", [True, False])
def test_without_a_tachometer_the_speed_is_estimated(name: str, verdict: str, absent: bool) -> None:
    acceleration, angle = synthetic(**{name: 900.0}, frequency=23.0)
    found = diagnoses(FaultDetector(ORDERS, RATE), (acceleration, np.full_like(angle, np.nan)) if not absent else (acceleration, None))[-1]
    assert found.verdict == verdict
    assert found.shaft_frequency == pytest.approx(23.0, rel=0.005)
    assert "no shaft angle" in "; ".join(found.remarks)


def test_without_a_tachometer_noise_gives_no_speed() -> None:
    found = diagnoses(FaultDetector(ORDERS, RATE), (synthetic()[0], None))[-1]
    assert found.verdict == "waiting"
    assert "speed cannot be estimated" in found.reason


def test_without_a_tachometer_a_falling_level_is_not_a_sensor_fault() -> None:
    acceleration, angle = synthetic(outer=900.0, frequency=23.0, seconds=8.0)
    acceleration[len(angle) // 2 :] *= 0.3
    for tacho, verdicts in ((angle, {"sensor"}), (np.full_like(angle, np.nan), {"outer_ring", "waiting"})):
        assert {diagnosis.verdict for diagnosis in diagnoses(FaultDetector(ORDERS, RATE), (acceleration, tacho))[-4:]} <= verdicts


def test_extreme_levels_are_handled() -> None:
    acceleration, angle = synthetic()
    slow = np.linspace(0.0, 1.0, len(angle), dtype=np.float32)
    assert last((np.column_stack([slow, slow]), angle)).verdict == "sensor"
    assert math.isfinite(last((1e15 * acceleration, angle)).confidence)


def test_empty_block_changes_nothing() -> None:
    detector = FaultDetector(ORDERS, RATE)
    empty = np.zeros((0, 2), np.float32), np.zeros(0, np.float32)
    assert detector.update(0, *empty) is None
    assert diagnoses(detector, synthetic())[-1].verdict == "healthy"


@pytest.mark.parametrize(
    ("factor", "verdict", "words"),
    [
        (1e-8, "outer_ring", "BPFO"),
        (1e5, "outer_ring", "BPFO"),
        (1e-12, "sensor", "m/s^2 only, below 1e-09: check the unit"),
        (1e-30, "sensor", "m/s^2 only, below 1e-09: check the unit"),
        (1e16, "sensor", "m/s^2, above 1e+09: check the unit"),
        (1e25, "sensor", "m/s^2, above 1e+09: check the unit"),
        (1e36, "sensor", "are not finite numbers"),  # in single precision
    ],
)
def test_a_signal_of_a_magnitude_that_no_sensor_has_is_not_called_healthy(factor: float, verdict: str, words: str) -> None:
    acceleration, angle = synthetic(outer=600.0)
    with np.errstate(over="ignore"):
        diagnosis = diagnoses(FaultDetector(ORDERS, RATE), ((acceleration.astype(np.float64) * factor).astype(np.float32), angle))[-1]
    assert diagnosis.verdict == verdict
    assert words in diagnosis.reason


def test_sampling_rate_below_the_band_is_refused() -> None:
    with pytest.raises(Refusal, match="band_low = 2000 Hz"):
        FaultDetector(ORDERS, 4000)


piece = st.tuples(
    st.sampled_from(["next", "late", "twice", "gap", "far", "nan", "inf", "no angle", "huge", "zero", "shape", "reverse"]),
    st.integers(1, 40),
)


@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow])
@given(pieces=st.lists(piece, min_size=5, max_size=40))
def test_every_signal_gives_a_reason_or_a_refusal(pieces: list[tuple[str, int]]) -> None:
    detector = FaultDetector(ORDERS, 12800, DetectorParameters(window=1.0, least_window=0.5, hop=0.25))
    random, index = np.random.default_rng(1), 0
    for kind, size in pieces:
        samples = 128 * size
        acceleration = random.normal(size=(samples, 2)).astype(np.float32)
        angle: Any = np.mod(0.01 * np.arange(index, index + samples), TURN).astype(np.float32)
        index += {"late": -3000, "gap": 700, "far": 10**7}.get(kind, 0)
        acceleration *= {"nan": np.nan, "inf": np.inf, "huge": 1e30, "zero": 0.0}.get(kind, 1.0)
        angle = None if kind == "no angle" else -angle if kind == "reverse" else angle
        for _ in range(2 if kind == "twice" else 1):
            try:
                found = detector.update(index, acceleration[:, :1] if kind == "shape" else acceleration, angle)
            except Refusal as refusal:
                words = str(refusal)
            else:
                words = found.reason if found else "no verdict is due"
                assert math.isfinite(found.confidence if found else 0.0)
            assert words
        index += samples


def test_window_shorter_than_the_hop_is_refused() -> None:
    with pytest.raises(Refusal, match=r"window = 0.5 s is below hop = 1 s"):
        FaultDetector(ORDERS, RATE, DetectorParameters(window=0.5, least_window=0.5, hop=1.0))


def test_a_gap_that_is_not_bridged_keeps_the_shaft_angle() -> None:
    acceleration, angle = synthetic(outer=600.0, seconds=8.0)
    detector = FaultDetector(ORDERS, RATE, DetectorParameters(longest_gap=2.0))
    diagnoses(detector, (acceleration[: 3 * RATE], angle[: 3 * RATE]))
    after = diagnoses(detector, (acceleration[round(3.4 * RATE) :], angle[round(3.4 * RATE) :]), first=round(3.4 * RATE))
    assert not any("no shaft angle" in remark for diagnosis in after for remark in diagnosis.remarks)
    assert after[-1].verdict == "outer_ring"


def test_a_sensor_fault_before_a_restart_is_forgotten() -> None:
    acceleration, angle = synthetic(outer=600.0, seconds=6.0)
    acceleration[2 * RATE : 3 * RATE] = 0.0
    detector = FaultDetector(ORDERS, RATE)
    assert diagnoses(detector, (acceleration[: 3 * RATE], angle[: 3 * RATE]))[-1].verdict == "sensor"
    after = diagnoses(detector, (acceleration[3 * RATE :], angle[3 * RATE :]), first=9 * RATE)
    assert [diagnosis.verdict for diagnosis in after] == ["waiting"] * 4 + ["outer_ring"] * 2


def test_blocks_that_arrive_twice_in_pairs_are_no_restart() -> None:
    arriving = (first for k in range(0, 3 * RATE, 2048) for first in (k, k + 1024, k, k + 1024))
    final = diagnoses(FaultDetector(ORDERS, RATE), synthetic(outer=600.0), begins=arriving)[-1]
    assert final.verdict == "outer_ring"
    assert not any("restarts" in remark for remark in final.remarks)


@pytest.mark.parametrize("block", [1024, 2 * RATE])
def test_samples_that_are_not_finite_count_in_their_own_hop(block: int) -> None:
    acceleration, angle = synthetic(outer=600.0, seconds=4.0)
    acceleration[2 * RATE :][:: RATE // 100] = np.nan
    whole = diagnoses(FaultDetector(ORDERS, RATE), (acceleration, angle), block=1024)
    assert comparable(diagnoses(FaultDetector(ORDERS, RATE), (acceleration, angle), block=block)[-1]) == comparable(whole[-1])


def test_shipped_parameters_are_the_defaults() -> None:
    found = read_parameters(BAGS.parent / "config" / "detector.yaml", "fault_detector")
    assert found == DetectorParameters().model_dump()
