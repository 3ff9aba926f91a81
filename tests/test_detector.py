"""The detector on synthetic bearings, on broken streams and on the simulated bench."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.configuration import Configuration
from dcrb_ros.configuration_file import read_parameters
from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.kinematics import characteristic_orders
from dcrb_ros.parameters import Bearing
from dcrb_ros.refusal import Refusal
from dcrb_ros.simulation import Simulation

RATE = 51200
ORDERS = characteristic_orders(Bearing())
Floats = npt.NDArray[np.float64]
Stream = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]


def bursts(angle: Floats, order: float, amplitude: float, *, seen: Floats | None = None) -> Floats:
    """Return ringing at 7 kHz struck ``order`` times a turn; ``seen`` scales each strike."""
    samples = len(angle)
    strikes = np.flatnonzero(np.diff(np.floor(angle * order / (2.0 * math.pi))) != 0.0)
    comb = np.zeros(samples)
    comb[strikes] = amplitude if seen is None else amplitude * seen[strikes]
    time = np.arange(512) / RATE
    ringing = np.exp(-time / 5e-4) * np.sin(2.0 * math.pi * 7000.0 * time)
    return np.convolve(comb, ringing)[:samples]


def stream(
    *, outer: float = 0.0, inner: float = 0.0, frequency: float = 20.0, ramp: float = 0.0, seconds: float = 2.0, seed: int = 1
) -> Stream:
    """Return a synthetic bearing: strikes of given amplitudes [m/s^2] in noise of 1 m/s^2.

    The cage runs 0.2 % behind the kinematic order, as on the simulated bench.
    """
    slip = -0.002
    time = np.arange(round(seconds * RATE)) / RATE
    angle = 2.0 * math.pi * (frequency * time + 0.5 * ramp * time**2)
    noise = np.random.default_rng(seed).normal(size=(len(time), 2))
    struck = bursts(angle, ORDERS.bpfo * (1.0 + slip), outer)
    loaded = np.maximum(0.0, np.cos(angle)) ** 2
    struck = struck + bursts(angle, ORDERS.bpfi * (1.0 - slip * ORDERS.bpfo / ORDERS.bpfi), inner, seen=loaded)
    acceleration = noise + np.column_stack([0.3 * struck, struck])
    return acceleration.astype(np.float32), np.mod(angle, 2.0 * math.pi).astype(np.float32)


def watch(detector: FaultDetector, data: Stream, *, block: int = 1024, first: int = 0) -> list[Diagnosis]:
    """Feed a stream in blocks and return the diagnoses."""
    acceleration, angle = data
    found = [detector.update(first + k, acceleration[k : k + block], angle[k : k + block]) for k in range(0, len(angle), block)]
    return [diagnosis for diagnosis in found if diagnosis is not None]


def last(data: Stream, **parameters: Any) -> Diagnosis:
    """Return the last diagnosis of a stream."""
    return watch(FaultDetector(ORDERS, RATE, DetectorParameters(**parameters)), data)[-1]


def on_the_bench(groups: dict[str, Any], seconds: float) -> list[str]:
    """Return the verdicts on a simulated bench."""
    configuration = Configuration.model_validate(groups)
    detector = FaultDetector(characteristic_orders(configuration.bearing), configuration.sensor.sampling_rate)
    blocks = Simulation(configuration).blocks(seconds)
    found = [detector.update(block.index, block.acceleration, block.shaft_angle) for block in blocks]
    return [diagnosis.verdict for diagnosis in found if diagnosis is not None]


@pytest.mark.parametrize(
    ("outer", "inner", "verdict"),
    [(0.0, 0.0, "healthy"), (600.0, 0.0, "outer_ring"), (0.0, 900.0, "inner_ring"), (600.0, 900.0, "compound")],
)
def test_synthetic_defects_are_named(outer: float, inner: float, verdict: str) -> None:
    assert last(stream(outer=outer, inner=inner)).verdict == verdict


def test_weak_bpfo_line_is_healthy_although_it_stands_out() -> None:
    diagnosis = last(stream(outer=30.0))
    assert diagnosis.levels["BPFO"] > 15.0
    assert diagnosis.verdict == "healthy"


def test_baseline_of_another_bearing_makes_the_same_line_a_defect() -> None:
    assert last(stream(outer=30.0), outer_baseline=1.0).verdict == "outer_ring"


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_is_healthy(seed: int) -> None:
    diagnosis = last(stream(seed=seed))
    assert diagnosis.verdict == "healthy"
    assert 0.5 <= diagnosis.confidence <= 1.0


def test_ramp_of_the_speed_does_not_hide_a_defect() -> None:
    diagnosis = last(stream(outer=600.0, frequency=12.0, ramp=12.0))
    assert diagnosis.verdict == "outer_ring"
    assert diagnosis.shaft_frequency == pytest.approx(24.0, rel=1e-3)
    assert diagnosis.levels["BPFO"] > 25.0


def test_direction_of_rotation_does_not_matter() -> None:
    acceleration, angle = stream(outer=600.0)
    backward = np.mod(-angle.astype(np.float64), 2.0 * math.pi).astype(np.float32)
    assert last((acceleration, backward)).levels["BPFO"] == pytest.approx(last((acceleration, angle)).levels["BPFO"], abs=0.1)


def test_spectrum_has_the_line_at_its_order() -> None:
    orders, amplitude = last(stream(outer=600.0)).spectrum
    near = np.abs(orders - ORDERS.bpfo) < 1.0
    assert orders[near][np.argmax(amplitude[near])] == pytest.approx(ORDERS.bpfo * 0.998, abs=0.02)


def test_verdicts_come_every_hop_and_wait_for_the_first_window() -> None:
    found = watch(FaultDetector(ORDERS, RATE), stream(outer=600.0, seconds=3.0))
    assert [diagnosis.verdict for diagnosis in found] == ["waiting"] * 3 + ["outer_ring"] * 3
    assert [diagnosis.index for diagnosis in found] == [k * RATE // 2 - 1 for k in range(1, 7)]
    assert found[-1].time == pytest.approx(found[-1].index / RATE)


@pytest.mark.parametrize("block", [16, 1000, 4096, 25600])
def test_verdicts_do_not_depend_on_the_block_size(block: int) -> None:
    data = stream(outer=600.0, seconds=2.5)
    expected, found = watch(FaultDetector(ORDERS, RATE), data), watch(FaultDetector(ORDERS, RATE), data, block=block)
    assert len(expected) == len(found) == 5
    for one, other in zip(expected, found, strict=True):
        assert (one.index, one.verdict, one.reason, one.levels, one.confidence) == (
            other.index,
            other.verdict,
            other.reason,
            other.levels,
            other.confidence,
        )
        np.testing.assert_array_equal(one.spectrum, other.spectrum)


def test_one_huge_block_gives_its_last_verdict() -> None:
    data = stream(outer=600.0, seconds=2.9)
    (found,) = watch(FaultDetector(ORDERS, RATE), data, block=len(data[1]))
    expected = watch(FaultDetector(ORDERS, RATE), data)[-1]
    assert (found.index, found.verdict, found.levels) == (expected.index, expected.verdict, expected.levels)


def test_gap_is_counted_and_starts_a_new_window() -> None:
    detector = FaultDetector(ORDERS, RATE)
    data = stream(outer=600.0)
    assert watch(detector, data, first=5000)[-1].verdict == "outer_ring"
    after = watch(detector, data, first=5000 + len(data[1]) + 1)
    assert [diagnosis.verdict for diagnosis in after] == ["waiting"] * 3 + ["outer_ring"]
    assert {diagnosis.gaps for diagnosis in after} == {1}


def test_repeated_block_is_a_gap() -> None:
    detector = FaultDetector(ORDERS, RATE)
    acceleration, angle = stream(seconds=0.5)
    detector.update(0, acceleration, angle)
    diagnosis = detector.update(0, acceleration, angle)
    assert diagnosis is not None
    assert diagnosis.gaps == 1


@pytest.mark.parametrize("poison", [math.nan, math.inf])
@pytest.mark.parametrize("channel", ["acceleration", "shaft_angle"])
def test_samples_that_are_no_numbers_accuse_the_sensor_until_they_have_left(poison: float, channel: str) -> None:
    acceleration, angle = stream(outer=600.0, seconds=4.5)
    (acceleration[:, 1] if channel == "acceleration" else angle)[1000] = poison
    found = watch(FaultDetector(ORDERS, RATE), (acceleration, angle))
    assert [diagnosis.verdict for diagnosis in found] == ["sensor"] * 4 + ["outer_ring"] * 5
    assert "1 of" in found[0].reason


def test_dead_sensor_is_named() -> None:
    acceleration, angle = stream()
    acceleration[:, 0] = 3.0
    diagnosis = last((acceleration, angle))
    assert diagnosis.verdict == "sensor"
    assert "in X does not change" in diagnosis.reason


def test_standing_shaft_waits() -> None:
    acceleration, angle = stream()
    diagnosis = last((acceleration, np.zeros_like(angle)))
    assert diagnosis.verdict == "waiting"
    assert "turns" in diagnosis.reason
    assert diagnosis.shaft_frequency == 0.0


def test_shaft_that_turns_back_waits() -> None:
    acceleration, _ = stream()
    time = np.arange(len(acceleration)) / RATE
    angle = 2.0 * math.pi * (40.0 * time - 14.0 * time**2)
    diagnosis = last((acceleration, np.mod(angle, 2.0 * math.pi).astype(np.float32)))
    assert diagnosis.verdict == "waiting"
    assert "turned back" in diagnosis.reason


def test_silence_between_the_axes_is_no_crash() -> None:
    acceleration, angle = stream()
    slow = np.linspace(0.0, 1.0, len(angle), dtype=np.float32)
    assert last((np.column_stack([slow, slow]), angle)).verdict == "healthy"
    assert math.isfinite(last((1e30 * acceleration, angle)).confidence)


def test_empty_block_changes_nothing() -> None:
    detector = FaultDetector(ORDERS, RATE)
    empty = np.zeros((0, 2), np.float32), np.zeros(0, np.float32)
    assert detector.update(0, *empty) is None
    assert watch(detector, stream())[-1].verdict == "healthy"


def test_misshapen_block_is_refused() -> None:
    detector = FaultDetector(ORDERS, RATE)
    with pytest.raises(Refusal, match=r"acceleration \(10, 3\)"):
        detector.update(0, np.zeros((10, 3), np.float32), np.zeros(10, np.float32))


def test_sampling_rate_below_the_band_is_refused() -> None:
    with pytest.raises(Refusal, match="band_low = 2000 Hz"):
        FaultDetector(ORDERS, 4000)


@pytest.mark.parametrize(
    ("faults", "verdict"),
    [
        ({}, "healthy"),
        ({"outer_1": {"width": 0.001, "row": 1}}, "outer_ring"),
        ({"inner_1": {"width": 0.001, "row": 1}}, "inner_ring"),
        ({"outer_1": {"width": 0.002}, "inner_1": {"width": 0.002}}, "compound"),
    ],
)
def test_verdict_on_the_simulated_bench(faults: dict[str, Any], verdict: str) -> None:
    assert on_the_bench({"faults": faults}, 3.0) == ["waiting"] * 3 + [verdict] * 3


@pytest.mark.parametrize(
    "faults",
    [{"broken_bars": "row1/bar15, row2/bar15"}, {"roller_1": {"width": 0.002}}],
    ids=["cage", "roller"],
)
def test_no_raceway_is_blamed_for_cage_or_roller(faults: dict[str, Any]) -> None:
    assert on_the_bench({"faults": faults}, 2.5) == ["waiting"] * 3 + ["healthy"] * 2


@pytest.mark.parametrize(("speed", "load"), [(60.0, 100e3), (190.0, 120e3), (250.0, 110e3)])
def test_healthy_bench_stays_quiet_at_other_speeds(speed: float, load: float) -> None:
    groups = {"operating": {"speed": speed, "load": load}, "simulation": {"seed": 7}}
    assert on_the_bench(groups, 2.5) == ["waiting"] * 3 + ["healthy"] * 2


def test_shipped_parameters_are_the_defaults() -> None:
    found = read_parameters(Path(__file__).parents[1] / "config" / "detector.yaml", "fault_detector")
    assert found == DetectorParameters().model_dump()
