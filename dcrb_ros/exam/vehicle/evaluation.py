"""Evaluation of detectors of a vehicle: every box of every vehicle is a scenario with its own correct verdict.

A box without damage is a healthy scenario, so that an alarm on the wrong box is a false alarm. Of the credit for a damaged box, the share
of the alarm is earned by an alarm on any box, half of the share of the name by an alarm on the damaged one, and half by its component on
any.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.detector import VehicleDetector
from dcrb_ros.exam.credit import vehicle_detection
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.detector_process import STATUSES, BeginVehicle
from dcrb_ros.exam.evaluation import CandidateRefusal, Scenario, ScenarioSet
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.plugin_process import DetectorFailure, running_process
from dcrb_ros.exam.running_detector import RunningVehicleDetector, VehicleDetectorFactory
from dcrb_ros.exam.scoring import ScenarioResult, score_scenario
from dcrb_ros.exam.vehicle.exam_file import VehicleCase, VehicleExam
from dcrb_ros.exam.vehicle.signals import VehicleSignal, kept_signal, signal_path
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.verdicts import VERDICTS
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.text.json import parsed_json
from dcrb_ros.vehicle.description import described

Statuses = Mapping[str, tuple[str, float | None]]
"""Verdict and score [dB] by status; the score is None if the detector gives none."""


@dataclass
class VehicleOutcome:
    """What a candidate did in one vehicle."""

    received: dict[str, list[ReceivedDiagnosis]] = field(default_factory=dict)
    """Its diagnoses by box."""
    failure: str = ""
    """Why it failed; empty if it did not."""

    def add(self, description: VehicleDescription, time: float, statuses: Statuses, signal_received: float | None = None) -> None:
        """Take the statuses at a time [s], which arrived when the signal had been received up to another one [s], if given."""
        for box in description.boxes:
            verdict, score = box_verdict(statuses, box.name)
            self.received.setdefault(box.name, []).append(ReceivedDiagnosis(time, verdict, score, signal_received=signal_received))


def box_verdict(statuses: Statuses, box: str) -> tuple[str, float | None]:
    """Return the verdict on a box, and its score [dB]: that of the bearing unless the sensor is faulty; ``waiting`` if it is undecided."""
    sensor, score = statuses.get(f"{box}/sensor", ("", None))
    if sensor == "sensor":
        return sensor, None if score is None else 0.0
    verdict, score = statuses.get(f"{box}/bearing", ("waiting", None))
    return verdict if verdict in VERDICTS else "waiting", score


@dataclass(frozen=True)
class PythonVehicleDetector:
    """A detector of a vehicle written in Python, in this process."""

    name: str
    factory: VehicleDetectorFactory
    parallel: bool = True

    def diagnose(self, signal: VehicleSignal) -> VehicleOutcome:
        """Return its diagnoses.

        Raises:
            Refusal: the detector has no ``add`` or returns something invalid.
            RuntimeError: it raised an exception.
        """
        outcome, detector = VehicleOutcome(), RunningVehicleDetector(self.factory, signal.description)
        for piece, _, end in signal.pieces():
            statuses = detector.take(piece)
            if statuses is not None:
                outcome.add(signal.description, (end - 1) / signal.description.sampling_rate, statuses)
        return outcome


def shipped_vehicle_detector(parameters: DetectorParameters, name: str) -> PythonVehicleDetector:
    """Return the shipped detector of a vehicle as a candidate."""
    return PythonVehicleDetector(name, partial(VehicleDetector, box_parameters=parameters))


@dataclass(frozen=True)
class ProcessVehicleDetector:
    """A detector of a vehicle written in Python, in a process of its own that never has the truth."""

    name: str
    given: str
    """``module:Class`` or ``file.py:Class``."""
    limits: Limits
    parallel: bool = True

    def diagnose(self, signal: VehicleSignal) -> VehicleOutcome:
        """Return its diagnoses; a failure is part of the outcome."""
        outcome, description = VehicleOutcome(), signal.description
        try:
            with running_process(self.given, self.limits) as process, process.guarded(outcome):
                begin = BeginVehicle(description.to_json())
                for kind, content, end in process.answers(begin, signal.pieces(), description.sampling_rate):
                    if kind == STATUSES:
                        outcome.add(description, (end - 1) / description.sampling_rate, _statuses(content))
        except CandidateRefusal as refusal:
            outcome.failure = str(refusal)
        return outcome


def vehicle_scenarios(exam: VehicleExam, folder: Path, workers: int = 1) -> ScenarioSet[VehicleSignal]:
    """Return the scenarios of the exam of a vehicle, whose signals are kept in a folder; more ``workers`` than one have a thread each."""
    # Vehicles at one operating point have bearings in common.
    cases = sorted(exam.cases, key=_point)
    scenarios = [_scenario(case, folder, None if workers == 1 else 1) for case in cases]
    return ScenarioSet(exam.name, exam.criteria, scenarios, exam.digest, exam.seal, exam.seeds)


def _scenario(case: VehicleCase, folder: Path, threads: int | None) -> Scenario[VehicleSignal]:
    """Return a vehicle with the correct verdict on each of its boxes; ``threads`` simulate it, None for one for each core."""
    return Scenario(
        case.name,
        partial(kept_signal, case.parameters, case.duration, folder, threads=threads),
        lambda outcome, criteria: scored_boxes(case, described(case.vehicle()), outcome, criteria),
        lambda: signal_path(case.parameters, case.duration, folder).is_file(),
        _point(case),
    )


def _point(case: VehicleCase) -> str:
    """Return the name of the operating point of a vehicle."""
    return case.tags.get("point", "")


def scored_boxes(case: VehicleCase, description: VehicleDescription, outcome: VehicleOutcome, criteria: Criteria) -> list[ScenarioResult]:
    """Return the result of every box of a vehicle."""
    speed = case.journey.speed_kmh / 3.6
    results = []
    for box in description.boxes:
        expectation = Expectation(
            f"{case.name}/{box.name}",
            case.damaged.get(box.name.replace("/", "."), "healthy"),
            case.duration,
            tags={**case.tags, "speed": speed / description.axle(box.axle).wheel_radius},
            required=case.required,
            last_verdict=True,
        )
        own = outcome.received.get(box.name, [])
        result = score_scenario(expectation, own, criteria, failure=outcome.failure)
        if expectation.faulty:
            detection = vehicle_detection(expectation, own, list(outcome.received.values()), criteria)
            result = replace(result, credit=replace(result.credit, detection=detection))
        results.append(result)
    return results


def _statuses(content: bytes) -> dict[str, tuple[str, float | None]]:
    """Return the statuses in an answer, which may come from a process that the detector controls.

    Raises:
        DetectorFailure: it is no such answer.
    """
    try:
        answer = parsed_json(content, "its answer").items()
        return {str(name): (str(verdict), None if score is None else float(score)) for name, (verdict, score) in answer}
    except (ValueError, TypeError, AttributeError):
        raise DetectorFailure("its process sent an invalid answer") from None
