"""A recording as a scenario of the exam: its ground truth, and the diagnoses that it contains."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.evaluation import CandidateRefusal, Outcome, ScenarioSet, bearing_scenario
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import DIAGNOSIS, GROUND_TRUTH
from dcrb_ros.recordings.foreign_files import refuse_foreign
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.storage import valid_files
from dcrb_ros.recordings.vehicle_folder import box_of, vehicle_boxes
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import rpm
from dcrb_ros.stream.block import Truth


@dataclass(frozen=True)
class RecordedCase:
    """A recording with ground truth and, if a detector ran, its diagnoses."""

    path: Path
    expectation: Expectation
    diagnoses: tuple[ReceivedDiagnosis, ...]
    damage: tuple[str, ...]
    """Descriptions of what could not be read."""


def read_recorded_case(path: Path, *, name: str = "") -> RecordedCase:
    """Return the expectation that follows from a recording's ground truth, with its diagnoses.

    The recording may come from the bench or from `ros2 bag record`.

    Raises:
        Refusal: there is no recording, it has no ground truth, that of several benches or a file of another recording, or no single
            verdict describes it.
    """
    truths: dict[str, list[Truth]] = {}
    received: dict[str, list[bytes]] = {}
    whole, box = box_of(path)
    files, damage = valid_files(whole)
    refuse_foreign(whole, files)
    if vehicle_boxes(whole):
        what = "a box in the recording of a vehicle" if box else "the recording of a vehicle"
        raise Refusal(f"{path} is {what}, which cannot be scored: dcrb detect diagnoses it, and dcrb score bogie evaluates such a detector")
    for file in files:
        for stored in file.messages(damage):
            topic, data = stored.channel.topic, stored.message.data
            namespace, _, name_below = topic.rpartition("/")
            if name_below == GROUND_TRUTH.name:
                truths.setdefault(namespace, []).append(decode_truth(data))
            elif name_below == DIAGNOSIS.name:
                received.setdefault(namespace, []).append(data)
    if len(truths) > 1:
        topics = ", ".join(sorted(map(GROUND_TRUTH.resolved, truths)))
        raise Refusal(f"{path} contains the truth of several benches, {topics}: record the topics of one")
    if not truths:
        raise Refusal(
            f"{path} has no messages on {GROUND_TRUTH.name}, so the correct verdict is unknown: give a recording of the bench "
            "(dcrb simulate, dcrb bench --record, or ros2 bag record -a while the bench runs)"
            + (f"; not all of it could be read: {damage[0]}" if damage else "")
        )
    ((namespace, truth),) = truths.items()
    # A diagnosis received just after the recording started may judge signal from before its start.
    diagnoses = [d for d in map(decode_diagnosis, received.get(namespace, ())) if d.time >= truth[0].time_ns * 1e-9]
    return RecordedCase(path, _expectation(path, name or path.name, truth, diagnoses), tuple(diagnoses), tuple(damage))


@dataclass(frozen=True)
class RecordedDiagnoses:
    """The diagnoses that recordings contain as a candidate."""

    name: str = "the recorded diagnoses"
    parallel: bool = False

    def diagnose(self, recorded: RecordedCase) -> Outcome:
        """Return the diagnoses in a recording.

        Raises:
            CandidateRefusal: it contains none.
        """
        if not recorded.diagnoses:
            raise CandidateRefusal(
                f"{recorded.path} has no messages on diagnosis: record it while a detector runs (dcrb bench --record, or "
                "ros2 bag record -a), or run a detector on it with --reference, --python or --node"
            )
        return Outcome(list(recorded.diagnoses))


def recorded_scenarios(cases: Iterable[RecordedCase]) -> ScenarioSet[Recording]:
    """Return recordings as scenarios for a detector."""
    return ScenarioSet("recordings", Criteria(), [bearing_scenario(case.expectation, partial(Recording, case.path)) for case in cases])


def diagnosed_scenarios(cases: Iterable[RecordedCase]) -> ScenarioSet[RecordedCase]:
    """Return recordings as scenarios for the diagnoses that they contain."""
    return ScenarioSet("recordings", Criteria(), [bearing_scenario(case.expectation, partial(replace, case)) for case in cases])


def _expectation(path: Path, name: str, truths: Sequence[Truth], diagnoses: Sequence[ReceivedDiagnosis]) -> Expectation:
    present: Mapping[str, Mapping[str, Any]] = {}
    for truth in truths:
        removed = set(present) - set(truth.faults)
        if removed:
            raise Refusal(
                f"{path}: the fault {sorted(removed)[0]} ends at {truth.time_ns * 1e-9:g} s, but a scenario has one correct verdict from "
                "the onset on: cut the recording there"
            )
        present = truth.faults
    last = truths[-1]
    begin, end = truths[0].time_ns * 1e-9, max([last.time_ns * 1e-9, *(diagnosis.time for diagnosis in diagnoses)])
    if end <= begin:
        raise Refusal(f"{path} has its truth at {begin:g} s only, so there is no time in which to judge: give a recording of 0.2 s or more")
    # A fault that is older than the recording can be detected from the start of the recording on.
    onsets = {fault: max(begin, float(fields.get("onset", 0.0))) for fault, fields in present.items()}
    verdict = class_of(present)
    tags: dict[str, str | float] = {"speed": last.speed, "speed_rpm": round(rpm(last.speed), 1), "load": -last.load[1]}
    widths = [float(fault["width"]) for fault in present.values() if "width" in fault]
    tags |= {"width": max(widths)} if widths else {}
    return Expectation(
        name,
        verdict,
        end - begin,
        _onset(onsets, verdict),
        tags,
        first_onset=min(onsets.values(), default=begin),
        begin=begin,
        speeds=tuple((truth.time_ns * 1e-9, truth.speed) for truth in truths),
        bearing_onset=min((onset for fault, onset in onsets.items() if class_of([fault]) != "sensor"), default=None),
    )


def _onset(onsets: Mapping[str, float], verdict: str) -> float:
    """Return the time from which a verdict is correct [s]; a second defect of the same kind does not change the verdict."""
    times = sorted(set(onsets.values()))
    return next((now for now in times if class_of([f for f, onset in onsets.items() if onset <= now]) == verdict), 0.0)
