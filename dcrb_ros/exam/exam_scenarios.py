"""The scenarios of an exam of a bearing, as a detector receives them, and what is expected of each.

Each recording of a replica follows a healthy run of the same simulated machine at the same speed, load and rate.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.exam.case import Case, CaseSimulation, simulation_seeds
from dcrb_ros.exam.evaluation import Scenario, ScenarioSet, bearing_scenario
from dcrb_ros.exam.exam_file import GAIN_TAG, MACHINE_TAG, Exam, ReplicaOrigin
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.led_signal import LEAD, Form, JudgedRecording, LedSignal, healthy_recording
from dcrb_ros.exam.measured import KNOWN
from dcrb_ros.exam.recording_cache import cached_recording, is_recorded
from dcrb_ros.exam.replica_priors import SEEDS, START, STARTS, generator_of
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import changed

VERTICAL = 1
"""Axis of the bench that a recording of one axis has: Y, along the load."""


@dataclass(frozen=True, kw_only=True)
class SimulatedRecording(JudgedRecording):
    """A scenario of a replica as a recording of one axis."""

    case: Case
    """The run, whose first part is cut off."""
    folder: Path
    start: float
    """Length of that part [s]."""

    @property
    def tags(self) -> dict[str, str | float]:
        """Tags of the scenario."""
        return dict(self.case.expectation.tags)

    def samples(self) -> Floats:
        """Return the vertical acceleration [m/s^2], shape (samples,); it is simulated if it is missing."""
        recorded = Recording(cached_recording(self.case, self.folder)).acceleration
        return recorded[round(self.start * self.rate) :, VERTICAL].astype(float)


def _recording_of(case: Case, exam: Exam, origin: ReplicaOrigin, folder: Path) -> SimulatedRecording:
    expectation, configuration = case.expectation, case.simulation.configuration
    machine, duration = expectation.tags.get(MACHINE_TAG), case.simulation.duration
    flaw = ""
    if machine is None:
        flaw = f"has no tag {MACHINE_TAG}"
    elif case.simulation.scenario is not None or expectation.onset:
        flaw = "changes while it is recorded, but a recording has one speed and one truth"
    elif configuration.operating.speed == 0.0:
        flaw = "is at rest, but a recording has a speed"
    elif not duration <= origin.longest:
        flaw = f"lasts {duration:g} s, but replica.longest is {origin.longest:g} s"
    if flaw:
        raise Refusal(f"scenario '{case.name}' of the replica {exam.name} {flaw}: make it again with dcrb exam replica")
    start = _start_of(configuration)
    return SimulatedRecording(
        name=case.name,
        rig=str(expectation.tags.get("rig", machine)),
        machine=str(machine),
        truth=expectation.verdict,
        rate=configuration.sensor.sampling_rate,
        speed=abs(configuration.operating.speed) / (2.0 * math.pi),
        orders=characteristic_orders(configuration.bearing),
        gain_known=expectation.tags.get(GAIN_TAG) == KNOWN,
        case=replace(case, simulation=replace(case.simulation, duration=start + duration)),
        folder=folder,
        start=start,
    )


def _start_of(configuration: Configuration) -> float:
    """Return the length of the start of a run that is cut off [s].

    Every run begins at the angle 0. The random length keeps a healthy run and the recording after it from repeating each other.
    """
    return START + float(generator_of("start", configuration.simulation.seed).uniform(0.0, STARTS))


def led_signals(exam: Exam, folder: Path) -> list[LedSignal[SimulatedRecording]]:
    """Return the recordings of a replica, which are kept in a folder, each after a healthy run of its own if the machine has a healthy one.

    Raises:
        Refusal: the exam is no replica or has healthy runs of another length than `LEAD`, or one of its scenarios names no machine, is
            at rest, changes during the recording or is too long.
    """
    if exam.replica is None:
        raise Refusal(f"the exam '{exam.name}' is no replica: make one with dcrb exam replica")
    if exam.replica.lead != LEAD:
        raise Refusal(
            f"replica.lead = {exam.replica.lead:g} s in {exam.name}, but a recording follows {LEAD:g} s of healthy signal: make it again "
            "with dcrb exam replica"
        )
    recordings = [_recording_of(case, exam, exam.replica, folder) for case in exam.cases]
    signals = []
    for case, one in zip(exam.cases, recordings, strict=True):
        form = Form(rate=one.rate, judged=case.simulation.duration, lead=LEAD)
        signals.append(LedSignal(one, _lead_of(one, healthy_recording(one, recordings)), form))
    return signals


def _lead_of(recording: SimulatedRecording, healthy: SimulatedRecording | None) -> SimulatedRecording | None:
    """Return a run of a healthy bearing at speed, load and rate of a recording, with another seed."""
    if healthy is None:
        return None
    ours, theirs = recording.case.simulation.configuration, healthy.case.simulation.configuration
    speed, load, seed = ours.operating.speed, ours.operating.load, int(generator_of("lead", ours.simulation.seed).integers(1, SEEDS))
    # The level of the background is proportional to the speed.
    structure = theirs.model_dump()["structure"]
    level = structure["healthy_level"] * abs(speed) / (structure["healthy_speed"] or abs(theirs.operating.speed))
    run = {
        "operating.speed": speed,
        "operating.load": load,
        "sensor.sampling_rate": ours.sensor.sampling_rate,
        "simulation.step": ours.simulation.step,
        "simulation.seed": seed,
        "publishing.preview_rate": ours.publishing.preview_rate,
        "structure.healthy_level": level,
        "structure.healthy_speed": 0.0,
    }
    name = f"healthy run before {recording.name}"
    configuration = changed(theirs, run, name)
    start, expectation = _start_of(configuration), Expectation(name, "healthy", LEAD, tags=healthy.case.expectation.tags)
    case = Case(expectation, CaseSimulation(configuration, None, start + LEAD))
    return replace(healthy, name=name, rate=recording.rate, speed=recording.speed, case=case, start=start)


def simulated_recordings(signal: LedSignal[SimulatedRecording]) -> list[SimulatedRecording]:
    """Return the recording of a signal and the healthy run before it, if there is one."""
    return [signal.recording] if signal.lead is None else [signal.lead, signal.recording]


def expectations(exam: Exam) -> list[Expectation]:
    """Return what is expected of a detector in each scenario of an exam; nothing is simulated."""
    if exam.replica is None:
        return [case.expectation for case in exam.cases]
    return [_expectation(signal) for signal in led_signals(exam, Path())]


def _expectation(signal: LedSignal[SimulatedRecording]) -> Expectation:
    """Return what is expected of a simulated recording; it is required if the file says so."""
    return replace(signal.expectation(), required=signal.recording.case.expectation.required)


def scenarios_of(exam: Exam, folder: Path) -> ScenarioSet[Any]:
    """Return the scenarios of an exam, whose recordings are kept in a folder; nothing is simulated yet.

    Raises:
        Refusal: see `led_signals`.
    """
    scenarios: list[Scenario[Any]]
    if exam.replica is None:
        cases: Iterable[Case] = exam.cases
        scenarios = [bearing_scenario(c.expectation, partial(_recording, c, folder), partial(is_recorded, c, folder)) for c in exam.cases]
    else:
        signals = led_signals(exam, folder)
        cases = [run.case for signal in signals for run in simulated_recordings(signal)]
        scenarios = [bearing_scenario(_expectation(s), partial(_simulated, s), partial(_is_simulated, s)) for s in signals]
    return ScenarioSet(exam.name, exam.criteria, scenarios, exam.digest, exam.seal, simulation_seeds(cases))


def _recording(case: Case, folder: Path) -> Recording:
    return Recording(cached_recording(case, folder))


def _simulated(signal: LedSignal[SimulatedRecording]) -> LedSignal[SimulatedRecording]:
    """Return a signal after its recordings have been simulated."""
    for recording in simulated_recordings(signal):
        cached_recording(recording.case, recording.folder)
    return signal


def _is_simulated(signal: LedSignal[SimulatedRecording]) -> bool:
    return all(is_recorded(recording.case, recording.folder) for recording in simulated_recordings(signal))
