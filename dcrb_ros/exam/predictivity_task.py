"""The task of both sides of a comparison: each recording, measured or simulated, after a healthy signal of its machine."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Generic

from dcrb_ros.exam.evaluation import Progress, simulate_missing
from dcrb_ros.exam.exam_file import Exam
from dcrb_ros.exam.exam_scenarios import SimulatedRecording, led_signals, simulated_recordings
from dcrb_ros.exam.led_signal import Judged, LedSignal
from dcrb_ros.exam.measured import MeasuredRecording, led_recordings
from dcrb_ros.exam.recording_cache import cached_recording, case_hash, is_recorded
from dcrb_ros.schema.refusal import Refusal

COMPARED = ("healthy", "outer_ring", "inner_ring")
"""Classes that are compared: envelope analysis cannot name most ball faults (Smith and Randall 2015)."""


@dataclass(frozen=True)
class Task(Generic[Judged]):
    """A recording to judge."""

    signal: LedSignal[Judged]
    original: MeasuredRecording
    """The measured recording, also that of a counterpart."""
    digest: str
    """Digest of everything on which the signal depends."""


def measured_tasks(recordings: Sequence[MeasuredRecording], longest: float) -> list[Task[MeasuredRecording]]:
    """Return the tasks of measured recordings, of each at most ``longest`` [s].

    Raises:
        Refusal: a recording is not there.
    """
    missing = next((recording for recording in recordings if not recording.file.is_file()), None)
    if missing is not None:
        raise Refusal(f"{missing.file} is not there: restore this recording, or leave {missing.name} out of the table")
    files = {recording.name: hashlib.sha256(recording.file.read_bytes()).hexdigest() for recording in recordings}
    signals = [signal for signal in led_recordings(recordings, longest) if signal.recording.truth in COMPARED]
    return [_task(signal, signal.recording, files) for signal in signals]


def simulated_tasks(exam: Exam, recordings: Sequence[MeasuredRecording], folder: Path) -> list[Task[SimulatedRecording]]:
    """Return the tasks of the scenarios of a replica, whose recordings are kept in a folder.

    Raises:
        Refusal: a scenario is no counterpart of a recording of the table.
    """
    known = {recording.name: recording for recording in recordings}
    tasks = []
    for signal in led_signals(exam, folder):
        simulated = signal.recording
        original = known.get(str(simulated.tags.get("recording")))
        if original is None or original.truth != simulated.truth:
            raise Refusal(
                f"scenario '{simulated.name}' of {exam.name} is no counterpart of a recording of the table: make the replica "
                "with dcrb exam replica"
            )
        if simulated.truth in COMPARED:
            hashes = {one.name: case_hash(one.case) for one in simulated_recordings(signal)}
            tasks.append(_task(signal, original, hashes))
    return tasks


def simulate_tasks(tasks: Sequence[Task[SimulatedRecording]], workers: int, progress: Progress) -> None:
    """Simulate the recordings of tasks and the healthy runs before them that are missing; see `simulate_missing`."""
    runs = {one.name: (one.case, one.folder) for task in tasks for one in simulated_recordings(task.signal)}
    signals = {name: (partial(is_recorded, *run), partial(cached_recording, *run)) for name, run in runs.items()}
    simulate_missing(signals, workers, progress)


def _task(signal: LedSignal[Judged], original: MeasuredRecording, digests: Mapping[str, str]) -> Task[Judged]:
    one, lead = signal.recording, signal.lead
    about = [
        digests[one.name],
        *([digests[lead.name], lead.speed, lead.rate] if lead else []),
        one.rate,
        dataclasses.astuple(signal.form),
        one.speed,
        one.orders.as_dict(),
        [getattr(each, "unit", "") for each in (one, lead or one)],
        one.gain_known,
    ]
    digest = hashlib.sha256(json.dumps(about).encode()).hexdigest()
    return Task(signal, original, digest)
