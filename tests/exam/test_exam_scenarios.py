"""The scenarios of a replica: what precedes each recording, and what is expected of it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest
import yaml

from dcrb_ros.exam.exam_file import Exam, exam_of
from dcrb_ros.exam.exam_scenarios import expectations, led_signals
from dcrb_ros.exam.kinds import matching
from dcrb_ros.schema.refusal import Refusal

ORIGIN = {
    **{"table_sha256": "", "speed": "lines", "seed": 1, "machines": 2, "counterparts": 1, "longest": 2.0, "without": []},
    "dcrb_ros": "0.1.0",
}


def scenario(name: str, machine: str, verdict: str = "healthy", rate: int = 10000, speed: float = 100.0, **changes: Any) -> dict[str, Any]:
    fault = {} if verdict == "healthy" else {"faults.outer_1.row": 1, "faults.outer_1.width": 0.001}
    of_bench = {"sensor.sampling_rate": rate, "simulation.step": 1.0 / rate / round(2e5 / rate), "publishing.preview_rate": 200}
    settings = {**of_bench, "operating.speed": speed, "bearing.rollers_per_row": 16, **fault}
    return {
        "name": name,
        "verdict": verdict,
        "duration": 3.0,
        "twin": False,
        "tags": {"machine": machine, "rig": "r"},
        "set": settings,
    } | changes


def replica(*scenarios: dict[str, Any], **changes: Any) -> Exam:
    tree = {"exam": "two machines", "base": "outer_ring_defect", "onset": 0.0, "replica": ORIGIN, "scenarios": list(scenarios)}
    criteria = {"delay": dict.fromkeys(("outer_ring", "inner_ring", "roller"), 2.0), "smallest_width": 0.0, "silence": 1e6}
    return exam_of({**tree, "criteria": criteria, **changes}, "replica")


GIVEN = (
    scenario("calm/1", "m1", speed=90.0, base="healthy"),
    scenario("calm/2", "m2", base="healthy"),
    scenario("fast/1", "m1", speed=200.0, base="healthy", rate=20000, duration=1.0),
    scenario("outer/1", "m1", "outer_ring", speed=-190.0, rate=10000),
    scenario("outer/3", "m3", "outer_ring"),
)


def test_a_healthy_recording_of_the_same_machine_at_the_nearest_speed_precedes_each() -> None:
    signals = {signal.recording.name: signal for signal in led_signals(replica(*GIVEN), Path())}
    leads = {name: signal.lead.name if signal.lead else "" for name, signal in signals.items()}
    assert leads == {"calm/1": "fast/1", "calm/2": "", "fast/1": "", "outer/1": "fast/1", "outer/3": ""}
    faulty = signals["outer/1"].recording
    assert (faulty.rate, faulty.truth, faulty.rig, faulty.gain_known) == (10000, "outer_ring", "r", False)
    assert faulty.orders.bpfo + faulty.orders.bpfi == pytest.approx(16.0)


def test_the_onset_is_the_end_of_the_healthy_recording() -> None:
    found = {expectation.name: expectation for expectation in expectations(replica(*GIVEN))}
    # At most 2 s of each count; the healthy one of 1 s at 20 kHz is reduced to 10 kHz.
    assert {name: (one.onset, one.duration) for name, one in found.items()} == {
        **{"calm/1": (1.0, 3.0), "calm/2": (0.0, 2.0), "fast/1": (0.0, 1.0)},
        **{"outer/1": (1.0, 3.0), "outer/3": (0.0, 2.0)},
    }
    assert all(one.last_verdict and one.required for one in found.values())
    assert found["outer/1"].tags["width"] == 0.001


def test_an_exam_that_is_no_replica_has_the_onsets_of_its_file() -> None:
    exam = replica(*GIVEN, replica=None)
    assert expectations(exam) == [case.expectation for case in exam.cases]
    with pytest.raises(Refusal, match="'two machines' is no replica: make one with dcrb exam replica"):
        led_signals(exam, Path())


def test_the_digest_contains_the_machines() -> None:
    exam = replica(*GIVEN)
    others = [yaml.safe_load(yaml.safe_dump(one)) for one in GIVEN]
    assert replica(*others).digest == exam.digest
    others[3]["tags"]["machine"] = "m2"
    assert replica(*others).digest != exam.digest
    assert replica(*others, replica=None).digest == replica(*GIVEN, replica=None).digest


def test_a_scenario_without_a_machine_is_refused() -> None:
    with pytest.raises(Refusal, match=r"scenario 'alone' of the replica two machines has no tag machine: make it again"):
        expectations(replica(scenario("alone", "m1", tags={"rig": "r"}, base="healthy")))


def test_a_selected_recording_keeps_what_precedes_it() -> None:
    exam = replica(*GIVEN)
    kept = matching(exam, "outer/1")
    assert [case.name for case in kept.cases] == ["calm/1", "fast/1", "outer/1"]
    whole, part = ({one.name: one for one in expectations(one)} for one in (exam, kept))
    assert part["outer/1"] == whole["outer/1"]
    assert [case.name for case in matching(dataclasses.replace(exam, replica=None), "outer/1").cases] == ["outer/1"]
