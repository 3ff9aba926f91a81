"""Detectors run on recordings, recordings kept in a folder, and recordings as scenarios."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import attacked_files
import numpy as np
import pytest
from full_disk import files_of_at_most
from made_up_blocks import BODIES, blocks, recorded
from ros2_bag_record import bag_of

from dcrb_ros.exam import evaluation, exam_scenarios, in_process, recording_cache
from dcrb_ros.exam.case import Case
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.detector_run import PythonDetector
from dcrb_ros.exam.evaluation import NoDiagnosis, Outcome, ScenarioSet, bearing_scenario, evaluate, named
from dcrb_ros.exam.exam_file import Exam, exam_of
from dcrb_ros.exam.exam_scenarios import scenarios_of
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.recorded_case import RecordedCase, RecordedDiagnoses, diagnosed_scenarios, read_recorded_case
from dcrb_ros.exam.recording_cache import (
    CONTENT,
    cache_path,
    cached_recording,
    checked_folder,
    is_recorded,
)
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.messages.statuses import Status, encode_diagnostics, encode_truth
from dcrb_ros.messages.topics import DIAGNOSIS, GROUND_TRUTH, Message, Topic
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.block import Truth
from dcrb_ros.text.temporary import temporary

EXAM = exam_of({"exam": "t", "scenarios": [{"name": f"Well {k}!", "verdict": "healthy"} for k in range(3)]}, "t")
CASES = EXAM.cases


class Echo:
    """Names the fault of every second block."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, int]] = []

    def update(self, index: int, acceleration: Any, shaft_angle: Any, /) -> str | None:
        self.seen.append((index, len(shaft_angle)))
        return "cage" if len(self.seen) % 2 else None


def test_a_verdict_is_dated_by_the_last_sample_of_its_block(tmp_path: Path) -> None:
    bag, detector = recorded(tmp_path / "bag", 4), Echo()
    found = PythonDetector("plain", lambda orders, rate: detector).diagnose(Recording(bag)).received
    assert [index for index, _ in detector.seen] == [0, 1024, 2048, 3072]
    assert found == [ReceivedDiagnosis(1023 / 51200, "cage"), ReceivedDiagnosis(3071 / 51200, "cage")]


def test_a_detector_that_asks_for_it_is_given_the_range_of_the_sensor(tmp_path: Path) -> None:
    detector = Echo()
    detector.sensor_range = -1.0  # type: ignore[attr-defined]
    PythonDetector("plain", lambda orders, rate: detector).diagnose(Recording(recorded(tmp_path / "bag", 2)))
    assert detector.sensor_range == 5000.0  # type: ignore[attr-defined]
    plain = Echo()
    PythonDetector("plain", lambda orders, rate: plain).diagnose(Recording(tmp_path / "bag"))
    assert not hasattr(plain, "sensor_range")


def test_an_unknown_verdict_of_a_detector_is_refused(tmp_path: Path) -> None:
    detector = SimpleNamespace(update=lambda *_: "cgae")
    with pytest.raises(Refusal, match=r"update returned 'cgae', which is not a verdict: .*did you mean 'cage'"):
        PythonDetector("plain", lambda orders, rate: detector).diagnose(Recording(recorded(tmp_path / "bag", 1)))


def test_the_path_of_a_recording_has_a_readable_name(tmp_path: Path) -> None:
    name = cache_path(CASES[0], tmp_path).name
    assert name.startswith("well-0-")
    assert len(name) == len("well-0-") + 16
    long = exam_of({"exam": "t", "scenarios": [{"name": "x" * 200, "verdict": "healthy"}]}, "t").cases[0]
    assert len(cache_path(long, tmp_path).name) == 60 + 1 + 16


def test_unfinished_recordings_of_killed_processes_are_deleted(tmp_path: Path) -> None:
    unfinished, other = tmp_path / ".writing-0123456789abcdef", tmp_path / "finished"
    for folder in (unfinished, other):
        folder.mkdir()
    with temporary(tmp_path) as running:
        with checked_folder(tmp_path) as kept:
            assert kept == tmp_path
            assert not unfinished.exists()
            unfinished.mkdir()
        assert running.is_dir()
    assert list(tmp_path.iterdir()) == [other]
    with checked_folder(tmp_path / "new" / "deep") as kept:
        assert kept.is_dir()


def test_unfinished_recordings_of_stopped_workers_are_deleted(tmp_path: Path) -> None:
    def stopped() -> None:
        with checked_folder(tmp_path):
            (tmp_path / ".writing-0123456789abcdef").mkdir()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert not list(tmp_path.iterdir())


def test_a_recording_that_another_process_finished_first_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = cache_path(CASES[0], tmp_path)

    def simulate(case: Any, target: Path) -> None:
        target.mkdir()
        path.mkdir(exist_ok=True)
        (path / "theirs").touch()
        recording_cache._write_content(case, path)

    monkeypatch.setattr(recording_cache, "_simulate", simulate)
    assert cached_recording(CASES[0], tmp_path) == path
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert sorted(file.name for file in path.iterdir()) == [CONTENT, "theirs"]


def file_of(path: Path) -> Path:
    return next(path.glob("*.mcap"))


def in_place(put: Callable[[Path, Path], object]) -> Callable[[Path, Path], object]:
    """Return what removes a recording and puts something else in its place, given the recording and another one."""

    def damage(path: Path, other: Path) -> None:
        shutil.rmtree(path)
        put(path, other)

    return damage


CHANGED, UNREADABLE, OTHER = "has been changed since it was recorded", "cannot be checked", "is the recording of another scenario"
DAMAGES: dict[str, tuple[Callable[[Path, Path], object], str]] = {
    "pipe as content": (lambda path, _: attacked_files.pipe(path / CONTENT), "is a named pipe"),
    "folder as file": (lambda path, _: attacked_files.folder(file_of(path)), "is a folder"),
    "link to another recording": (in_place(lambda path, other: path.symlink_to(other)), OTHER),
    "file": (in_place(lambda path, _: path.write_text("a file")), UNREADABLE),
    "pipe": (in_place(lambda path, _: os.mkfifo(path)), UNREADABLE),
    "broken link": (in_place(lambda path, _: path.symlink_to(path.with_name("missing"))), UNREADABLE),
    "truncated": (lambda path, _: attacked_files.CHANGES["truncated"](file_of(path)), CHANGED),
    "flipped": (lambda path, _: attacked_files.flip(file_of(path)), CHANGED),
    "samples of another one": (lambda path, other: shutil.copy(file_of(other), file_of(path)), CHANGED),
    "copy of another one": (in_place(lambda path, other: shutil.copytree(other, path)), OTHER),
    "without content": (lambda path, _: (path / CONTENT).unlink(), UNREADABLE),
    "a file more": (lambda path, other: shutil.copy(file_of(other), path / "another_1.mcap"), "has other files than were recorded"),
}
"""What may happen to a recording, and what is said of it."""


@pytest.fixture(scope="module")
def two_recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Case]]:
    """Return a folder with the recordings of two scenarios, and the scenarios."""
    settings = {"cage.joint": "revolute"}
    scenarios = [
        {"name": name, "verdict": "healthy", "set": settings, "duration": 0.1, "seeds": [k]} for k, name in enumerate(("mine", "other"), 1)
    ]
    folder, cases = tmp_path_factory.mktemp("recorded"), list(exam_of({"exam": "t", "scenarios": scenarios}, "t").cases)
    for case in cases:
        cached_recording(case, folder)
    return folder, cases


@pytest.mark.timeout(200)  # a pipe would be waited for
@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_or_swapped_recording_is_reported_and_simulated_again(
    name: str, two_recorded: tuple[Path, list[Case]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damage, sentence = DAMAGES[name]
    folder, (mine, other) = two_recorded
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    path = cached_recording(mine, tmp_path)
    files = {file.name for file in path.iterdir()}
    samples = Recording(path).waveform().acceleration
    others = cached_recording(other, tmp_path)
    damage(path, others)
    capsys.readouterr()  # kernels may have been compiled
    assert not is_recorded(mine, tmp_path)
    assert capsys.readouterr().err == ""
    assert cached_recording(mine, tmp_path) == path
    err = capsys.readouterr().err
    assert "scenario 'mine'" in err
    assert sentence in err
    assert is_recorded(mine, tmp_path)
    assert {file.name for file in path.iterdir()} == files
    assert np.array_equal(Recording(path).waveform().acceleration, samples)
    assert cached_recording(mine, tmp_path) == path
    assert not path.is_symlink()
    assert is_recorded(other, tmp_path)  # what a link leads to is not changed
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("law", "temperatures"), [("none", []), ("network", [0.0])])
def test_a_recording_has_temperatures_where_the_bench_has_them(law: str, temperatures: list[float], tmp_path: Path) -> None:
    scenarios = [{"name": "warm", "base": "healthy", "verdict": "healthy", "set": {"thermal.law": law}, "duration": 0.1}]
    case = exam_of({"exam": "t", "scenarios": scenarios}, "t").cases[0]
    recording = Recording(cached_recording(case, tmp_path))
    assert recording.temperatures().time.tolist() == temperatures
    own = {"outer_ring/vibration", "outer_ring/sensor", "ground_truth"}
    named = {message.topic.name for message in recording.messages()}
    assert named - own == ({"outer_ring/temperature", "box/temperature", "ambient/temperature"} if temperatures else set())


def test_a_recording_that_cannot_be_put_in_its_place_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def simulate(case: Any, target: Path) -> None:
        target.mkdir()

    def rename(source: object, target: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(recording_cache, "_simulate", simulate)
    monkeypatch.setattr(os, "rename", rename)
    with pytest.raises(Refusal, match=r"well-0.* cannot be written: Permission denied; make it writable or give another folder with --rec"):
        cached_recording(CASES[0], tmp_path)
    assert not list(tmp_path.glob(".writing-*"))


def test_a_folder_that_was_cleared_since_the_start_is_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording_cache, "_simulate", lambda case, target: target.mkdir())
    path = cached_recording(CASES[0], tmp_path / "dcrb_ros" / "exam")
    assert path.is_dir()


@pytest.mark.parametrize("size", [100, 5000])
def test_a_full_disk_names_the_recording_and_the_option(size: int, tmp_path: Path) -> None:
    with files_of_at_most(size), pytest.raises(Refusal) as refused:
        cached_recording(CASES[0], tmp_path)
    assert str(refused.value).endswith("File too large; free some space or give another folder with --recordings")
    assert str(cache_path(CASES[0], tmp_path)) in str(refused.value)
    assert not list(tmp_path.iterdir())


class Mute:
    """A candidate that answers nothing."""

    def __init__(self, *, parallel: bool = False, failure: str = "") -> None:
        self.name, self.parallel, self.failure = "mute", parallel, failure
        self.signals: list[Any] = []

    def diagnose(self, signal: Any) -> Outcome:
        self.signals.append(signal)
        return Outcome(failure=self.failure)


class Shown:
    """Notes which scenarios an activity has done."""

    def __init__(self) -> None:
        self.done: dict[str, list[str]] = {}

    def __call__(self, activity: str, total: int) -> Any:
        self.done[activity] = []
        return nullcontext(self.done[activity].append)


def test_only_missing_recordings_are_simulated_and_all_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    def recording(case: Case, folder: Path) -> Path:
        made.append(case.expectation.name)
        cache_path(case, folder).mkdir(exist_ok=True)
        return cache_path(case, folder)

    monkeypatch.setattr(recording_cache, "recording_flaw", lambda case, path: "")
    monkeypatch.setattr(exam_scenarios, "cached_recording", recording)
    monkeypatch.setattr(exam_scenarios, "Recording", Path)
    cache_path(CASES[1], tmp_path).mkdir()
    shown, mute = Shown(), Mute()
    evaluate(mute, scenarios_of(EXAM, tmp_path), progress=shown)
    assert made[:2] == ["Well 0!", "Well 2!"]
    assert mute.signals == [cache_path(case, tmp_path) for case in CASES]
    assert sorted(shown.done["simulated"]) == sorted(shown.done["evaluated"]) == ["Well 0!", "Well 1!", "Well 2!"]


def test_no_more_processes_are_started_than_there_are_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def in_this_process(calls: Any, workers: int) -> Any:
        asked.append(workers)
        return [(name, call()) for name, call in calls.items()]

    monkeypatch.setattr(evaluation, "in_processes", in_this_process)
    scenarios = [bearing_scenario(case.expectation, lambda: None, recorded=lambda: False) for case in CASES]
    for workers in (1, 2, 9):
        for parallel in (False, True):  # simulated apart, and evaluated apart
            evaluate(Mute(parallel=parallel), ScenarioSet("t", Criteria(), scenarios), workers=workers)
    assert asked == [1, 2, 2, 3, 3]


def test_the_scenarios_of_a_sealed_exam_are_evaluated_in_a_random_order_and_reported_in_theirs() -> None:
    ordered = [bearing_scenario(Expectation(str(k), "healthy", 5.0), partial(int, k)) for k in range(40)]
    scenarios = [replace(scenario, group=f"{k % 4}") for k, scenario in enumerate(ordered)]
    orders = []
    for seal in ("", "f" * 64, "e" * 64):
        mute = Mute()
        report = evaluate(mute, ScenarioSet("t", Criteria(), scenarios, seal=seal))
        assert [result.expectation.name for result in report.results] == [scenario.name for scenario in scenarios]
        orders.append(mute.signals)
    assert orders[0] == list(range(40))
    assert orders[0] != orders[1] != orders[2] != orders[0]
    for order in orders[1:]:
        assert sorted(order) == orders[0]
        groups = [number % 4 for number in order]
        assert sum(first != second for first, second in pairwise(groups)) == 3  # one group after another


def test_a_candidate_that_fails_at_first_is_not_tried_again() -> None:
    mute = Mute(failure="it ended")
    scenarios = [bearing_scenario(case.expectation, lambda: None) for case in CASES]
    with pytest.raises(NoDiagnosis, match=r"the detector 'mute' failed on the first scenario \(Well 0!\): it ended"):
        evaluate(mute, ScenarioSet("t", Criteria(), scenarios))
    assert len(mute.signals) == 1


def test_a_later_failure_leaves_the_other_scenarios(tmp_path: Path) -> None:
    class Tiring(Mute):
        def diagnose(self, signal: Any) -> Outcome:
            tired = super().diagnose(signal) and len(self.signals) == 2
            return Outcome([ReceivedDiagnosis(2.0 * k, "healthy") for k in range(6)], "it ended" if tired else "")

    scenarios = [bearing_scenario(case.expectation, lambda: None) for case in CASES]
    report = evaluate(Tiring(), ScenarioSet("t", Criteria(), scenarios))
    assert [result.flaw for result in report.results] == ["", "it ended", ""]


def test_an_error_names_its_scenario() -> None:
    def fail(error: Exception) -> None:
        raise error

    with pytest.raises(Refusal, match="scenario 'a': too short"):
        named("a", lambda: fail(Refusal("too short")))
    with pytest.raises(RuntimeError, match="scenario 'a' could not be evaluated: broken"):
        named("a", lambda: fail(ValueError("broken")))
    with pytest.raises(RuntimeError, match="could not be evaluated: ValueError"):
        named("a", lambda: fail(ValueError()))
    assert named("a", lambda: 3) == 3


def test_a_recording_without_diagnoses_is_not_scored() -> None:
    expectation = Expectation("bag", "healthy", 1.0)
    good = RecordedCase(Path("bag"), expectation, (ReceivedDiagnosis(0.5, "healthy"),), ())
    report = evaluate(RecordedDiagnoses(), diagnosed_scenarios([good]))
    assert (report.exam, report.detector, [result.passed for result in report.results]) == ("recordings", "the recorded diagnoses", [True])
    with pytest.raises(Refusal, match=r"^bag has no messages on diagnosis"):
        evaluate(RecordedDiagnoses(), diagnosed_scenarios([good, RecordedCase(Path("bag"), replace(expectation, name="b"), (), ())]))


@pytest.mark.parametrize("workers", [0, 257])
def test_from_one_to_256_processes_are_allowed(workers: int) -> None:
    with pytest.raises(Refusal, match=rf"workers = {workers} is outside 1 \.\. 256"):
        in_process.score(lambda orders, rate: Echo(), "smoke", workers=workers)


def test_processes_are_started_for_more_than_one_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "own.yaml"
    file.write_text("{exam: own, scenarios: [{name: well, verdict: healthy}]}", encoding="utf-8")
    asked: list[int] = []

    def in_this_process(calls: Any, workers: int) -> Any:
        asked.append(workers)
        return [(name, call()) for name, call in calls.items()]

    def scenarios(exam: Exam, folder: Path) -> ScenarioSet[None]:
        one = bearing_scenario(Expectation("well", "healthy", 5.0), lambda: None, recorded=lambda: False)
        two = bearing_scenario(Expectation("other", "healthy", 5.0), lambda: None, recorded=lambda: False)
        return ScenarioSet(exam.name, exam.criteria, [one, two])

    monkeypatch.setattr(evaluation, "in_processes", in_this_process)
    monkeypatch.setattr(in_process, "scenarios_of", scenarios)
    monkeypatch.setattr(PythonDetector, "diagnose", lambda self, signal: Outcome([ReceivedDiagnosis(5.0, "healthy")]))
    for workers in (1, 2, 256):
        report = in_process.score(Echo, file, recordings=tmp_path / "kept", workers=workers)  # type: ignore[arg-type]
        assert (report.passed, report.detector, report.exam) == (True, "Echo", "own")
    assert asked == [2, 2]


def truths(path: Path, *faults: dict[str, dict[str, float]], begin: float = 2.0) -> RecordedCase:
    """Record a ground truth every second and a diagnosis half a second later."""
    with Recorder(path, Configuration(), BODIES) as recorder:
        for number, present in enumerate(faults):
            stamp = round((begin + number) * 1e9)
            truth = Truth(stamp, 60.0, (300.0, -1e5), {}, present)
            recorder.write_messages([Message(GROUND_TRUTH, stamp, encode_truth(truth))])
            later = stamp + 500_000_000
            status = encode_diagnostics(later, [Status("mine", 0, "", {"verdict": "healthy"})])
            recorder.write_messages([Message(DIAGNOSIS, later, status)])
    return read_recorded_case(path, name="mine")


def test_the_expectation_of_a_recording_follows_from_its_ground_truth(tmp_path: Path) -> None:
    spalls = {"outer_1": {"width": 0.002, "onset": 3.0}, "inner_1": {"width": 0.001, "onset": 4.0}}
    recorded_case = truths(tmp_path / "bag", {}, {"outer_1": spalls["outer_1"]}, spalls)
    found = recorded_case.expectation
    assert (found.name, found.verdict, found.begin, found.duration) == ("mine", "compound", 2.0, 2.5)
    assert (found.onset, found.first_onset, found.bearing_onset) == (4.0, 3.0, 3.0)
    assert found.tags == {"speed": 60.0, "speed_rpm": 573.0, "load": 1e5, "width": 0.002}
    assert [diagnosis.time for diagnosis in recorded_case.diagnoses] == [2.5, 3.5, 4.5]
    assert recorded_case.damage == ()


def test_only_the_diagnoses_beside_the_truth_are_scored(tmp_path: Path) -> None:
    def elsewhere(topic: Topic) -> Topic:
        return replace(topic, name=f"/other/{topic.name}")

    truth = encode_truth(Truth(2_000_000_000, 60.0, (300.0, -1e5), {}, {}))
    ours, theirs = (encode_diagnostics(3_000_000_000, [Status("", 0, "", {"verdict": verdict})]) for verdict in ("healthy", "cage"))
    messages = [Message(elsewhere(DIAGNOSIS), 0, theirs), Message(GROUND_TRUTH, 0, truth), Message(DIAGNOSIS, 0, ours)]
    found = read_recorded_case(bag_of(tmp_path / "a", messages))
    assert [(diagnosis.time, diagnosis.verdict) for diagnosis in found.diagnoses] == [(3.0, "healthy")]
    with pytest.raises(Refusal, match="contains the truth of several benches, /dcrb/ground_truth, /other/ground_truth: record the topics"):
        read_recorded_case(bag_of(tmp_path / "b", [*messages, Message(elsewhere(GROUND_TRUTH), 0, truth)]))


def test_a_recording_with_its_truth_at_one_time_only_is_refused(tmp_path: Path) -> None:
    truth = encode_truth(Truth(2_000_000_000, 60.0, (300.0, -1e5), {}, {}))
    with pytest.raises(Refusal, match=r"has its truth at 2 s only.*give a recording of 0.2 s or more"):
        read_recorded_case(bag_of(tmp_path / "bag", [Message(GROUND_TRUTH, 0, truth)]))


def test_the_expectation_of_a_healthy_recording_has_no_onset(tmp_path: Path) -> None:
    found = truths(tmp_path / "bag", {}, {}).expectation
    assert (found.verdict, found.onset, found.first_onset, found.bearing_onset) == ("healthy", 0.0, 2.0, None)
    assert "width" not in found.tags


def test_a_sensor_fault_hides_no_bearing_fault_unless_there_is_one(tmp_path: Path) -> None:
    dead = {"sensor.dead": {"severity": 1.0, "axis": 0.0, "onset": 0.5}}
    found = truths(tmp_path / "bag", dead, dead).expectation
    assert (found.verdict, found.onset, found.bearing_onset) == ("sensor", 2.0, None)  # not before the recording begins


def test_made_up_blocks_are_read_back(tmp_path: Path) -> None:
    found = read_recorded_case(recorded(tmp_path / "bag", 3)).expectation
    assert (found.name, found.verdict) == ("bag", "healthy")
    assert sum(len(block.acceleration) for block in blocks(3)) == 3 * 1024
    assert np.isclose(found.duration, 2 * 1024 / 51200)
