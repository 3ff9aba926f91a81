"""Rules for the sensor: faults of the sensor are found, and impacts of a defect are not mistaken for them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.signal import butter, sosfilt
from synthetic_bearing import ORDERS, RATE, diagnoses, synthetic

from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rules.spikes import count_jumps
from dcrb_ros.diagnosis.rules.stuck import runs_of_one_value

Samples = npt.NDArray[np.float32]
ONSET = round(2.5 * RATE)
RANGE = 5000.0
RANDOM = np.random.default_rng(5)


def judged(change: Callable[[Samples], Samples], *, seconds: float = 4.0, sensor_range: float = RANGE, **impacts: Any) -> list[Diagnosis]:
    """Return the diagnoses of a synthetic bearing whose samples are changed from the onset on."""
    acceleration, angle = synthetic(seconds=seconds, **impacts)
    acceleration[ONSET:] = change(acceleration[ONSET:].copy())
    return diagnoses(FaultDetector(ORDERS, RATE, sensor_range=sensor_range), (acceleration, angle))


@pytest.mark.parametrize(
    ("rate", "given", "why"),
    [
        (RATE, {}, ""),
        (44_445, {}, ""),
        (25_600, {}, "band_high = 20000 Hz is above 11520 Hz, 0.45 of the sampling rate: lower it for these verdicts"),
        (25_600, {"band_high": 11_520.0}, ""),
        (RATE, {"band": "fixed"}, "band = fixed is not divided: give band = kurtogram"),
    ],
)
def test_a_diagnosis_says_which_faults_of_the_sensor_cannot_be_detected(rate: int, given: dict[str, Any], why: str) -> None:
    detector = FaultDetector(ORDERS, rate, DetectorParameters(**given))
    noisy = np.random.default_rng(3).normal(0.0, 1.0, (3 * rate, 2)).astype(np.float32)
    last = diagnoses(detector, (noisy, np.mod(125.0 / rate * np.arange(len(noisy)), 2.0 * np.pi)))[-1]
    said = [remark for remark in last.remarks if "gain drift" in remark]
    assert said == ([f"no gain drift and no loss of high frequencies is detected: {why}"] if why else [])


@pytest.mark.parametrize(
    ("rate", "hop", "hidden"),
    [
        (RATE, 0.5, []),
        (6000, 0.5, []),
        (5000, 0.5, ["no dead sensor that leaves noise is detected: hop = 0.5 s is below 0.569 s, the least at 5000 Hz"]),
        (51_200, 0.05, ["hop = 0.05 s is below 0.051 s, the least at 51200 Hz"]),
        (12_000, 0.1, ["dead sensor that leaves noise", "mount that rattles"]),
    ],
)
def test_a_diagnosis_says_which_faults_of_the_sensor_are_not_found_in_short_hops(rate: int, hop: float, hidden: list[str]) -> None:
    detector = FaultDetector(ORDERS, rate, DetectorParameters(hop=hop, band_low=1000.0, band_high=2000.0))
    noisy = np.random.default_rng(3).normal(0.0, 1.0, (rate, 2)).astype(np.float32)
    last = diagnoses(detector, (noisy, np.mod(125.0 / rate * np.arange(len(noisy)), 2.0 * np.pi)))[-1]
    said = [remark for remark in last.remarks if "is detected: hop" in remark]
    assert len(said) == len(hidden)
    assert all(words in remark for words, remark in zip(hidden, said, strict=True))
    assert last.verdict == ("waiting" if hidden else "sensor")


def noise(samples: Samples, level: float) -> Samples:
    return np.random.default_rng(7).normal(0.0, level, samples.shape).astype(np.float32)


def dead(samples: Samples) -> Samples:
    return noise(samples, 0.3)


def constant(samples: Samples) -> Samples:
    return np.full_like(samples, 1.5)


def stuck(samples: Samples) -> Samples:
    place = np.arange(len(samples)) % 5000
    held: Samples = samples[np.where(place < 2000, np.arange(len(samples)) - place, np.arange(len(samples)))]
    return held


def saturated(samples: Samples) -> Samples:
    return np.clip(samples, -2.5, 2.5)


def not_finite(samples: Samples) -> Samples:
    samples[::30] = np.nan
    return samples


def spiking(samples: Samples) -> Samples:
    spike = 800.0 * np.exp(-np.arange(60) / 5.0)
    for k in range(3000, len(samples) - 100, 7000):
        samples[k : k + 60] += np.float32(RANDOM.choice([-1.0, 1.0])) * spike[:, None].astype(np.float32)
    return samples


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (dead, "white noise"),
        (constant, "does not change"),
        (stuck, "is stuck"),
        (saturated, "is saturated"),
        (not_finite, "not finite numbers"),
        (spiking, "cable"),
    ],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
@pytest.mark.parametrize("impacts", [{}, {"outer": 600.0}], ids=["healthy", "faulty"])
def test_a_sensor_fault_is_found_within_two_hops(change: Callable[[Samples], Samples], word: str, impacts: dict[str, float]) -> None:
    found = judged(change, **impacts)
    verdict = "outer_ring" if impacts else "healthy"
    verdicts = [diagnosis.verdict for diagnosis in found]
    assert verdicts[:5] == ["waiting"] * 4 + [verdict]
    assert verdicts[5] in ("sensor", verdict)  # its margin may still hold good samples
    assert verdicts[6:] == ["sensor"] * 2
    assert any(word in diagnosis.reason for diagnosis in found[5:]), found[-1].reason


def drifting(samples: Samples) -> Samples:
    gain = 1.0 - 0.6 * np.clip(np.arange(len(samples)) / (2.0 * RATE), 0.0, 1.0)
    return (samples * gain[:, None]).astype(np.float32)


def fallen(samples: Samples) -> Samples:
    """Let the gain fall to a tenth; the sensor's noise, which stays, then holds up the weaker bands."""
    gain = 1.0 - 0.9 * np.clip(np.arange(len(samples)) / (0.5 * RATE), 0.0, 1.0)
    return (samples * gain[:, None] + noise(samples, 1.5)).astype(np.float32)


def loose(samples: Samples) -> Samples:
    return np.asarray(8.0 * sosfilt(butter(2, [900.0, 1100.0], "bandpass", fs=RATE, output="sos"), samples, axis=0), np.float32)


@pytest.mark.parametrize(
    ("change", "word", "seconds"),
    [
        (drifting, "gain of the sensor drifts", 6.0),
        (fallen, "gain of the sensor drifts", 9.0),
        (loose, "mount of the sensor is loose", 6.0),
    ],
)
def test_a_slow_sensor_fault_is_found(change: Callable[[Samples], Samples], word: str, seconds: float) -> None:
    found = judged(change, seconds=seconds, outer=600.0)
    assert found[-1].verdict == "sensor"
    assert word in found[-1].reason


@pytest.mark.parametrize("impacts", [{"outer": 3000.0}, {"inner": 6000.0}, {"roller": 6000.0}])
def test_clipped_impacts_are_counted_and_still_diagnosed(impacts: dict[str, float]) -> None:
    name = next(iter(impacts))
    acceleration, angle = synthetic(**impacts)
    clipped = np.clip(acceleration, -490.0, 490.0)
    final = diagnoses(FaultDetector(ORDERS, RATE, sensor_range=490.0), (clipped, angle))[-1]
    assert final.verdict == {"outer": "outer_ring", "inner": "inner_ring"}.get(name, name)
    assert final.clipped > 0
    assert "clipped samples" in "; ".join(final.remarks)


def test_a_spike_is_distinguished_from_an_impact_that_rings() -> None:
    time = np.arange(400) / RATE
    quiet = RANDOM.normal(size=4000)
    spike, blow = quiet.copy(), quiet.copy()
    spike[2000:2400] += 500.0 * np.exp(-time / 1e-4)
    blow[2000:2400] += 500.0 * np.exp(-time / 5e-4) * np.sin(2.0 * math.pi * 7000.0 * time)
    assert [count_jumps([column], 51, DetectorParameters()).spikes for column in (quiet, spike, blow)] == [0, 1, 0]


def test_spikes_before_a_gap_do_not_add_to_those_after_it() -> None:
    acceleration, angle = synthetic(seconds=3.0)
    for place in (1.2, 1.4, 1.9):
        acceleration[round(place * RATE), 1] += 800.0
    whole, parted = (FaultDetector(ORDERS, RATE) for _ in range(2))
    assert "sensor" in {diagnosis.verdict for diagnosis in diagnoses(whole, (acceleration, angle))}
    before, after = slice(round(1.5 * RATE)), slice(round(1.8 * RATE), None)
    assert {diagnosis.verdict for diagnosis in diagnoses(parted, (acceleration[before], angle[before]))} == {"waiting"}
    found = diagnoses(parted, (acceleration[after], angle[after]), first=round(1.8 * RATE))
    assert {diagnosis.verdict for diagnosis in found} == {"waiting"}


def test_a_coarse_adc_is_not_saturated() -> None:
    found = judged(lambda samples: np.asarray(np.round(samples), np.float32))
    assert found[-1].verdict == "healthy"


@pytest.mark.parametrize("silence", [dead, constant])
def test_silence_of_a_standing_bearing_is_not_a_sensor_fault(silence: Callable[[Samples], Samples]) -> None:
    acceleration, angle = synthetic(seconds=5.0)
    acceleration[ONSET:], angle[ONSET:] = silence(acceleration[ONSET:]), angle[ONSET]
    found = diagnoses(FaultDetector(ORDERS, RATE, sensor_range=RANGE), (acceleration, angle))
    assert {diagnosis.verdict for diagnosis in found} <= {"waiting", "healthy"}


@pytest.mark.parametrize("frequency", [4.0, 5.5])
@pytest.mark.parametrize("silence", [dead, constant])
def test_a_slow_bearing_with_a_dead_sensor_gets_no_verdict(silence: Callable[[Samples], Samples], frequency: float) -> None:
    acceleration, angle = synthetic(seconds=6.0, frequency=frequency)
    found = diagnoses(FaultDetector(ORDERS, RATE, sensor_range=RANGE), (silence(acceleration), angle))
    assert {diagnosis.verdict for diagnosis in found} <= {"waiting", "sensor"}


@pytest.mark.parametrize(("share", "verdict"), [(0.0, "sensor"), (0.2, "sensor"), (0.4, "outer_ring")])
def test_a_gain_changes_all_bands_alike_and_a_load_does_not(share: float, verdict: str) -> None:
    """A load step at 1800 rpm changed the bands by 3.2 to 4.7 dB; a drifting gain changes them alike within 0.2 of the decrease."""
    fall = 10.0 ** (-4.0 * np.array([1.0 - 0.5 * share, 1.0 + 0.5 * share]) / 20.0)

    def change(samples: Samples) -> Samples:
        low = sosfilt(butter(1, 8000.0, fs=RATE, output="sos"), samples, axis=0)
        return (fall[0] * low + fall[1] * (samples - low)).astype(np.float32)

    assert judged(change, seconds=7.0, outer=600.0)[-1].verdict == verdict


def test_a_change_of_load_is_not_a_drift() -> None:
    assert "sensor" not in {diagnosis.verdict for diagnosis in judged(_unevenly, seconds=6.0)}


def _unevenly(samples: Samples) -> Samples:
    """Return samples whose lower bands decrease to 0.4 and whose upper bands stay, like those of a heavier load."""
    high = sosfilt(butter(4, 6000.0, "highpass", fs=RATE, output="sos"), samples, axis=0)
    return np.asarray(0.4 * (samples - high) + high, np.float32)


@pytest.mark.parametrize(
    ("column", "ends", "lengths"),
    [([1, 2, 3], [], []), ([1, 1, 2, 3, 3, 3], [1, 5], [2, 3]), ([4, 4, 4], [2], [3]), ([1, 2, 2, 3, 3, 1], [2, 4], [2, 2])],
)
def test_runs_of_one_value_are_found(column: list[float], ends: list[int], lengths: list[int]) -> None:
    assert [found.tolist() for found in runs_of_one_value(np.array(column, float))] == [ends, lengths]
