"""The scenarios of a replica: what precedes each recording, and what is expected of it."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from dcrb_ros.cli.score import print_scenarios
from dcrb_ros.exam import exam_scenarios
from dcrb_ros.exam.exam_file import Exam, exam_of
from dcrb_ros.exam.exam_scenarios import expectations, led_signals, simulated_recordings
from dcrb_ros.exam.expectation import repeated_time
from dcrb_ros.exam.kinds import matching
from dcrb_ros.exam.led_signal import LEAD
from dcrb_ros.exam.replica_priors import START, STARTS
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.refusal import Refusal

ORIGIN = {
    **{"table_sha256": "", "speed": "lines", "seed": 1, "machines": 2, "counterparts": 1, "longest": 2.0, "lead": LEAD, "without": []},
    "dcrb_ros": "0.1.0",
}


def scenario(name: str, machine: str, verdict: str = "healthy", rate: int = 10000, speed: float = 100.0, **changes: Any) -> dict[str, Any]:
    fault = {} if verdict == "healthy" else {"faults.outer_1.row": 1, "faults.outer_1.width": 0.001}
    of_bench = {"sensor.sampling_rate": rate, "simulation.step": 1.0 / rate / round(2e5 / rate), "publishing.preview_rate": 200}
    settings = {**of_bench, "operating.speed": speed, "bearing.rollers_per_row": 16, **fault}
    return {
        "name": name,
        "verdict": verdict,
        "duration": 2.0,
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


def test_a_healthy_run_of_the_same_machine_precedes_each() -> None:
    loaded = {**GIVEN[3], "set": {**GIVEN[3]["set"], "operating.load": 900.0}}
    signals = {signal.recording.name: signal for signal in led_signals(replica(*GIVEN[:3], loaded, GIVEN[4]), Path())}
    assert {name for name, signal in signals.items() if signal.lead is None} == {"outer/3"}
    for signal in signals.values():
        if signal.lead is None:
            continue
        ours, theirs = signal.recording.case.simulation.configuration, signal.lead.case.simulation.configuration
        # Nothing but the vibration tells the two apart.
        assert (theirs.operating, theirs.sensor, theirs.publishing) == (ours.operating, ours.sensor, ours.publishing)
        assert (signal.lead.rate, signal.lead.speed, signal.sampling_rate) == (
            ours.sensor.sampling_rate,
            signal.recording.speed,
            signal.lead.rate,
        )
        assert theirs.simulation.step == ours.simulation.step
        assert theirs.simulation.seed != ours.simulation.seed
        assert not theirs.faults.described()
        assert signal.lead.truth == "healthy"
        assert signal.lead.case.simulation.duration == pytest.approx(signal.lead.start + LEAD)
        assert len({one.name for one in simulated_recordings(signal)}) == 2
    faulty = signals["outer/1"].recording
    assert (faulty.rate, faulty.truth, faulty.rig, faulty.gain_known) == (10000, "outer_ring", "r", False)
    assert faulty.orders.bpfo + faulty.orders.bpfi == pytest.approx(16.0)


def test_the_healthy_run_is_of_the_bearing_at_the_nearest_speed() -> None:
    given = [{**one, "set": {**one["set"], "surfaces.seed": number}} for number, one in enumerate(GIVEN, 1)]
    leads = {signal.recording.name: signal.lead for signal in led_signals(replica(*given), Path())}
    seeds = {name: lead and lead.case.simulation.configuration.surfaces.seed for name, lead in leads.items()}
    # A healthy recording follows a run of its own bearing, and outer/1, at 190 rad/s, one of fast/1.
    assert seeds == {"calm/1": 1, "calm/2": 2, "fast/1": 3, "outer/1": 3, "outer/3": None}


def test_the_background_of_a_healthy_run_is_proportional_to_the_speed() -> None:
    background = {"structure.housing": "laboratory", "structure.healthy_level": 3.0}
    given = [{**one, "set": {**one["set"], **background}} for one in GIVEN]
    leads = {signal.recording.name: signal.lead for signal in led_signals(replica(*given), Path())}
    levels = {name: lead and lead.case.simulation.configuration.model_dump()["structure"]["healthy_level"] for name, lead in leads.items()}
    assert levels == {"calm/1": 3.0, "calm/2": 3.0, "fast/1": 3.0, "outer/1": pytest.approx(3.0 * 190.0 / 200.0), "outer/3": None}


def test_the_onset_is_the_end_of_the_healthy_run() -> None:
    found = {expectation.name: expectation for expectation in expectations(replica(*GIVEN))}
    assert {name: (one.onset, one.duration) for name, one in found.items()} == {
        **{"calm/1": (LEAD, LEAD + 2.0), "calm/2": (LEAD, LEAD + 2.0), "fast/1": (LEAD, LEAD + 1.0)},
        **{"outer/1": (LEAD, LEAD + 2.0), "outer/3": (0.0, 2.0)},
    }
    assert repeated_time(list(found.values())) == 0.0
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


def test_a_known_gain_is_part_of_the_signal_and_of_the_digest() -> None:
    known = [*GIVEN[:-1], {**GIVEN[-1], "tags": {**GIVEN[-1]["tags"], "gain": "known"}}]
    assert [signal.recording.gain_known for signal in led_signals(replica(*known), Path())] == [False, False, False, False, True]
    assert replica(*known).digest != replica(*GIVEN).digest


def test_a_recording_has_the_axis_of_the_load_and_its_run_a_start_that_is_cut_off(monkeypatch: pytest.MonkeyPatch) -> None:
    recording = led_signals(replica(*GIVEN), Path())[0].recording
    both = np.array([[1.0, 2.0]]).repeat(round(recording.case.simulation.duration * recording.rate), axis=0)
    monkeypatch.setattr(exam_scenarios, "cached_recording", lambda case, folder: folder / case.name)
    monkeypatch.setattr(exam_scenarios, "Recording", lambda path: SimpleNamespace(acceleration=both))
    samples = recording.samples()
    assert (samples.shape, set(samples)) == ((20000,), {2.0})


def test_a_healthy_run_and_the_recording_after_it_begin_at_different_angles() -> None:
    for signal in led_signals(replica(*GIVEN[:4]), Path()):
        starts = [run.start for run in simulated_recordings(signal)]
        assert len(set(starts)) == 2
        assert all(START <= start < START + STARTS for start in starts)


def test_a_scenario_without_a_machine_is_refused() -> None:
    with pytest.raises(Refusal, match=r"scenario 'alone' of the replica two machines has no tag machine: make it again"):
        expectations(replica(scenario("alone", "m1", tags={"rig": "r"}, base="healthy")))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"duration": 2.5}, "lasts 2.5 s, but replica.longest is 2 s"),
        ({"onset": 1.0}, "changes while it is recorded"),
        ({"speed": 0.0}, "is at rest, but a recording has a speed"),
        ({"timeline": [{"at": 1.0, "set": {"operating.speed": 50.0}}]}, "changes while it is recorded"),
    ],
)
def test_a_scenario_that_is_no_recording_is_refused(changes: dict[str, Any], sentence: str) -> None:
    given = [scenario("calm", "m1", base="healthy"), scenario("outer", "m1", "outer_ring", **changes)]
    with pytest.raises(Refusal, match=f"scenario 'outer' of the replica two machines {sentence}.*: make it again"):
        expectations(replica(*given))


def test_a_longest_part_that_is_no_time_is_refused() -> None:
    with pytest.raises(Refusal, match=r"lasts 2 s, but replica\.longest is -1 s"):
        expectations(replica(*GIVEN, replica={**ORIGIN, "longest": -1.0}))


def test_healthy_runs_of_another_length_are_refused() -> None:
    exam = replica(*GIVEN, replica={**ORIGIN, "lead": 5.0})
    with pytest.raises(
        Refusal, match=r"replica\.lead = 5 s in two machines, but a recording follows 2\.5 s of healthy signal: make it again"
    ):
        expectations(exam)
    assert exam.digest != replica(*GIVEN).digest


def test_a_replica_without_the_length_of_its_healthy_runs_is_refused() -> None:
    without = {key: value for key, value in ORIGIN.items() if key != "lead"}
    with pytest.raises(Refusal, match=r"replica\.lead = 0 s in two machines, .*: make it again"):
        expectations(replica(*GIVEN, replica=without))


def test_a_scenario_is_required_as_its_file_says() -> None:
    given = [*GIVEN, scenario("outer/4", "m4", "outer_ring", required=False)]
    assert [one.name for one in expectations(replica(*given)) if not one.required] == ["outer/4"]


def test_the_revolutions_are_counted_in_either_direction() -> None:
    found = {one.name: one for one in expectations(replica(*GIVEN))}["outer/1"]
    # Both at 190 rad/s.
    assert found.revolutions(0.0, found.onset) == pytest.approx(190.0 * LEAD / (2.0 * math.pi))
    assert found.revolutions(found.onset, found.end) == pytest.approx(380.0 / (2.0 * math.pi))


def test_the_last_verdict_counts_whenever_it_is_given() -> None:
    criteria = {"delay": dict.fromkeys(("outer_ring", "inner_ring", "roller"), 1e6), "smallest_width": 0.0, "silence": 1e6}
    exam = replica(*GIVEN, criteria=criteria)
    (late,) = [one for one in expectations(exam) if one.name == "outer/1"]
    given = [ReceivedDiagnosis(time, verdict) for time, verdict in ((0.5, "healthy"), (LEAD + 1.9, "outer_ring"))]
    assert score_scenario(late, given, exam.criteria).passed
    with pytest.raises(Refusal, match=r"but criteria.delay.outer_ring allows 1e\+06 s"):
        replica(*GIVEN, criteria=criteria, replica=None)


def test_the_list_has_the_onset_in_the_signal(capsys: pytest.CaptureFixture[str]) -> None:
    print_scenarios(replica(*GIVEN))
    *lines, total = capsys.readouterr().out.splitlines()
    rows = [[cell.strip() for cell in line.split("│")[1:5]] for line in lines if line.startswith("│")]
    assert next(cells for cells in rows if cells[0] == "outer/1") == ["outer/1", "outer_ring", "2.5", "4.5"]
    assert f", {sum(float(cells[3]) for cells in rows):.0f} s simulated, " in total


def test_a_selected_recording_keeps_what_precedes_it() -> None:
    exam = replica(*GIVEN)
    kept = matching(exam, "outer/1")
    assert [case.name for case in kept.cases] == ["calm/1", "fast/1", "outer/1"]
    whole, part = ({one.name: one for one in expectations(one)} for one in (exam, kept))
    assert part["outer/1"] == whole["outer/1"]
    assert [case.name for case in matching(dataclasses.replace(exam, replica=None), "outer/1").cases] == ["outer/1"]
