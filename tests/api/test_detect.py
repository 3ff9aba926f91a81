"""The detector over a signal in one call, and block by block."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from dry_benches import dry_bench

from dcrb_ros import DetectorParameters, FaultDetector, Recording, Refusal, SimulationResult, detect, simulate
from dcrb_ros.diagnosis.detection import watch

BAGS = Path(__file__).parents[2] / "bags"


@pytest.fixture(scope="module")
def run() -> SimulationResult:
    return simulate(dry_bench("outer_ring_defect"), 3.0)


def test_run_recording_and_arrays_give_the_same_verdicts(run: SimulationResult) -> None:
    of_run = detect(run)
    of_recording = detect(Recording(BAGS / "outer_ring_defect"))  # the same configuration, seed and duration
    of_arrays = detect(run.acceleration, run.sampling_rate, shaft_angle=run.shaft_angle, bearing=run.configuration)
    assert of_run.verdict == of_recording.verdict == of_arrays.verdict == "outer_ring"
    assert [d.levels for d in of_run.history] == [d.levels for d in of_recording.history] == [d.levels for d in of_arrays.history]


def test_one_call_says_what_the_blocks_say(run: SimulationResult) -> None:
    detector = FaultDetector(run.orders, run.sampling_rate, sensor_range=run.sensor_range)
    blocks = [slice(first, first + 1024) for first in range(0, len(run), 1024)]
    found = [detector.update(block.start, run.acceleration[block], run.shaft_angle[block]) for block in blocks]
    assert [d.verdict for d in found if d is not None] == [d.verdict for d in detect(run).history]


def test_the_result_says_since_when_and_why(run: SimulationResult) -> None:
    found = detect(run)
    assert found.last is found.history[-1]
    assert found.since == next(d.time for d in found.history if d.verdict == "outer_ring")
    assert found.duration == pytest.approx(3.0)
    assert repr(found).startswith("<DetectionResult: outer_ring with confidence 0.9")
    assert repr(found.last).startswith("<Diagnosis: outer_ring at 3.00 s, confidence 0.9")
    frame = found.to_pandas()
    assert frame["verdict"].iloc[-1] == "outer_ring"
    assert frame["BPFO"].to_numpy() == pytest.approx([d.levels["BPFO"] for d in found.history])


def test_without_a_shaft_angle_the_speed_is_estimated(run: SimulationResult) -> None:
    found = detect(run.acceleration, run.sampling_rate, bearing=run.configuration)
    assert found.verdict == "outer_ring"
    assert found.last.shaft_frequency == pytest.approx(20.0, rel=0.01)


def test_a_single_axis_is_enough(run: SimulationResult) -> None:
    assert detect(run.acceleration[:, 1], run.sampling_rate, shaft_angle=run.shaft_angle, bearing=run.orders).verdict == "outer_ring"


def test_parameters_change_the_detector(run: SimulationResult) -> None:
    deaf = DetectorParameters(outer_limit=1e5, outer_limit_high=1e5)
    assert detect(run, parameters=deaf).verdict == "healthy"


def test_a_second_is_enough_for_a_verdict(run: SimulationResult) -> None:
    assert detect(run.between(stop=1.2)).verdict == "outer_ring"


def test_watching_answers_without_a_verdict(run: SimulationResult) -> None:
    for seconds in (0.2, 0.8):
        found = watch(run.between(stop=seconds))
        assert found.verdict == "waiting"
        assert found.reason == f"{seconds:.2f} s have arrived, but a verdict needs 1 s"
        assert found.duration == pytest.approx(seconds, abs=1e-3)


def test_the_lines_of_every_component_are_given(run: SimulationResult) -> None:
    lines = detect(run).last.lines
    outer = lines["outer_ring"]
    assert outer.order == pytest.approx(run.orders.bpfo, rel=0.005)
    assert outer.departure == pytest.approx(outer.order / run.orders.bpfo - 1.0)
    assert outer.orders == pytest.approx([outer.order, 2.0 * outer.order, 3.0 * outer.order])
    assert outer.probability > 0.9 > lines["inner_ring"].probability
    assert (outer.size**2 > 0.0, outer.depth > 1.0, outer.significance > 4.0) == (True, True, True)


def test_refusals(run: SimulationResult) -> None:
    with pytest.raises(Refusal, match=r"the signal holds 0.80 s of waveform, too little for a verdict: give at least 1 s$"):
        detect(run.between(stop=0.8))
    noise = np.cumsum(np.random.default_rng(1).standard_normal(102400))
    remedy = re.escape("; give the speed (speed_rpm in the description, shaft_angle in Python)")
    with pytest.raises(Refusal, match=f"the signal has no verdict: there is no shaft angle, and the speed cannot be estimated .*{remedy}$"):
        detect(noise, 51200, bearing=run.orders)
    with pytest.raises(Refusal, match=r"the signal has no verdict: the shaft made 0 revolutions in [0-9.]+ s, but a verdict needs 4$"):
        detect(noise, 51200, bearing=run.orders, shaft_angle=np.zeros(102400))
    with pytest.raises(Refusal, match="the orders of the bearing are unknown"):
        detect(np.zeros(51200), 51200)
    with pytest.raises(Refusal, match=r"window = 1 s is below least_window = 2 s"):
        detect(run, parameters=DetectorParameters(window=1.0))
    with pytest.raises(Refusal, match=r"give DetectorParameters"):
        detect(run, parameters={"learn": 10})  # type: ignore[arg-type]
    with pytest.raises(Refusal, match="shaft_angle is given beside <SimulationResult"):
        detect(run, shaft_angle=run.shaft_angle)
