"""The scenarios of an exam of a bearing, as a detector receives them, and what is expected of each.

Each recording of a replica follows a healthy one of the same simulated machine, as a measured one does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.exam.case import Case, simulation_seeds
from dcrb_ros.exam.evaluation import ScenarioSet, bearing_scenario
from dcrb_ros.exam.exam_file import GAIN_TAG, MACHINE_TAG, Exam, ReplicaOrigin
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.led_signal import JudgedRecording, LedSignal, healthy_lead
from dcrb_ros.exam.measured import KNOWN
from dcrb_ros.exam.recording_cache import cached_recording, is_recorded
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

VERTICAL = 1
"""Axis of the bench that a recording of one axis has: Y, along the load."""


@dataclass(frozen=True, kw_only=True)
class SimulatedRecording(JudgedRecording):
    """A scenario of a replica as a recording of one axis."""

    case: Case
    folder: Path

    @property
    def tags(self) -> dict[str, str | float]:
        """Tags of the scenario."""
        return dict(self.case.expectation.tags)

    def longest_part(self, seconds: float) -> Floats:
        """Return the vertical acceleration of the first ``seconds`` [m/s^2], shape (samples,); it is simulated if it is missing."""
        recorded = Recording(cached_recording(self.case, self.folder)).acceleration
        return recorded[: round(seconds * self.rate), VERTICAL].astype(float)

    def samples_within(self, seconds: float) -> int:
        """Return the number of samples of that part; nothing is simulated."""
        return round(min(seconds, self.case.simulation.duration) * self.rate)


def _recording_of(case: Case, exam: Exam, origin: ReplicaOrigin, folder: Path) -> SimulatedRecording:
    expectation, configuration = case.expectation, case.simulation.configuration
    machine, duration = expectation.tags.get(MACHINE_TAG), case.simulation.duration
    flaw = ""
    if machine is None:
        flaw = f"has no tag {MACHINE_TAG}"
    elif case.simulation.scenario is not None or expectation.onset:
        flaw = "changes while it is recorded, but a recording has one speed and one truth"
    elif not duration <= origin.longest:
        flaw = f"lasts {duration:g} s, but replica.longest is {origin.longest:g} s"
    if flaw:
        raise Refusal(f"scenario '{case.name}' of the replica {exam.name} {flaw}: make it again with dcrb exam replica")
    return SimulatedRecording(
        name=case.name,
        rig=str(expectation.tags.get("rig", machine)),
        machine=str(machine),
        truth=expectation.verdict,
        rate=configuration.sensor.sampling_rate,
        speed=abs(configuration.operating.speed) / (2.0 * math.pi),
        orders=characteristic_orders(configuration.bearing),
        gain_known=expectation.tags.get(GAIN_TAG) == KNOWN,
        case=case,
        folder=folder,
    )


def led_signals(exam: Exam, folder: Path) -> list[LedSignal[SimulatedRecording]]:
    """Return the recordings of a replica, which are kept in a folder, each after a healthy one of its machine if there is one.

    Raises:
        Refusal: the exam is no replica, or one of its scenarios names no machine, changes during the recording or is too long.
    """
    if exam.replica is None:
        raise Refusal(f"the exam '{exam.name}' is no replica: make one with dcrb exam replica")
    recordings, longest = [_recording_of(case, exam, exam.replica, folder) for case in exam.cases], exam.replica.longest
    return [LedSignal(recording, healthy_lead(recording, recordings), longest, longest) for recording in recordings]


def expectations(exam: Exam) -> list[Expectation]:
    """Return what is expected of a detector in each scenario of an exam; nothing is simulated."""
    if exam.replica is None:
        return [case.expectation for case in exam.cases]
    return [_expectation(signal) for signal in led_signals(exam, Path())]


def _expectation(signal: LedSignal[SimulatedRecording]) -> Expectation:
    """Return what is expected of a simulated recording; it is required if the file says so, and each part has its own speed."""
    expected, recording = signal.expectation(), signal.recording
    speed = 2.0 * math.pi * recording.speed
    before = 2.0 * math.pi * signal.lead.speed if signal.lead else speed
    knots = ((expected.onset, before), (math.nextafter(expected.onset, math.inf), speed))
    return replace(expected, required=recording.case.expectation.required, speeds=knots)


def simulated_scenarios(exam: Exam, folder: Path) -> ScenarioSet[Recording]:
    """Return the scenarios of an exam that is no replica, whose recordings are kept in a folder."""
    scenarios = [
        bearing_scenario(case.expectation, partial(_recording, case, folder), recorded=partial(is_recorded, case, folder))
        for case in exam.cases
    ]
    return ScenarioSet(exam.name, exam.criteria, scenarios, exam.digest, exam.seal, simulation_seeds(exam.cases))


def replica_scenarios(exam: Exam, folder: Path) -> ScenarioSet[LedSignal[SimulatedRecording]]:
    """Return the scenarios of a replica; see `led_signals`."""
    scenarios = [
        bearing_scenario(_expectation(signal), partial(_simulated, signal), recorded=partial(_is_simulated, signal))
        for signal in led_signals(exam, folder)
    ]
    return ScenarioSet(exam.name, exam.criteria, scenarios, exam.digest, exam.seal, simulation_seeds(exam.cases))


def _recording(case: Case, folder: Path) -> Recording:
    return Recording(cached_recording(case, folder))


def _simulated(signal: LedSignal[SimulatedRecording]) -> LedSignal[SimulatedRecording]:
    """Return a signal after its recordings have been simulated."""
    for recording in signal.recordings:
        cached_recording(recording.case, recording.folder)
    return signal


def _is_simulated(signal: LedSignal[SimulatedRecording]) -> bool:
    return all(is_recorded(recording.case, recording.folder) for recording in signal.recordings)
