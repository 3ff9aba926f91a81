"""The exam of a detector written in Python, in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy.typing as npt

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.diagnosis import Diagnosis
from dcrb_ros.exam.case import scenarios_hash
from dcrb_ros.exam.design import read_exam
from dcrb_ros.exam.library import checked_folder, default_folder, recorded
from dcrb_ros.exam.marking import mark
from dcrb_ros.exam.opinion import VERDICTS, WAITING, Opinion, opinion_of
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.sitting import record_all
from dcrb_ros.messages.verdicts import encode_diagnosis
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.refusal import Refusal, nearest

MOST_WORKERS = 256


class Detector(Protocol):
    """A fault detector that takes a signal block by block, as `dcrb_ros.FaultDetector` does."""

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any], /) -> Diagnosis | str | None:
        """Take a block; return a diagnosis or a verdict (``"healthy"``, ``"outer_ring"`` ...), or None where there is none yet."""


def score(
    detector: Callable[[Orders, int], Detector], exam: str | Path = "smoke", *, recordings: str | Path | None = None, workers: int = 1
) -> Report:
    """Evaluate a detector against the known faults of an exam, as ``dcrb score`` does with a node.

    Parameters
    ----------
    detector
        Called for every scenario with the characteristic orders of the bearing and the sampling rate [Hz]; returns the detector. Its
        ``update(index, acceleration, shaft_angle)`` gets the blocks: index of the first sample, acceleration of shape (samples, 2)
        [m/s^2] and shaft angle of shape (samples,) [rad]; it returns a `Diagnosis`, a verdict or None.
    exam
        A shipped exam (``"smoke"``, ``"standard"`` ...) or a YAML file.
    recordings
        Folder that keeps the simulated scenarios for the next call; by default the user's cache.
    workers
        Scenarios simulated at a time. With more than one, which start processes of their own, a script must call this below
        ``if __name__ == "__main__":``; a notebook may do so anywhere.

    Returns
    -------
    Report
        ``passed``, ``checks()``, ``delays()``, ``confusion()``, and ``marks``, one per scenario.

    Raises
    ------
    Refusal
        An unknown exam, workers outside 1 .. 256, a folder that cannot be written, or a verdict that the exam does not know.

    Examples
    --------
    >>> import dcrb_ros
    >>> report = dcrb_ros.score(dcrb_ros.FaultDetector, "smoke")
    >>> report.passed
    True
    """
    if not 1 <= workers <= MOST_WORKERS:
        raise Refusal(f"workers = {workers} is outside 1 .. {MOST_WORKERS}")
    chosen = read_exam(exam)
    folder = checked_folder(Path(recordings) if recordings is not None else default_folder())
    if workers > 1:
        made = record_all(chosen.cases, folder, workers, lambda _: None)
    else:
        made = {case.question.name: recorded(case, folder) for case in chosen.cases}
    name = getattr(detector, "__name__", type(detector).__name__)
    marks = [mark(case.question, _opinions(detector, made[case.question.name]), chosen.criteria) for case in chosen.cases]
    return Report(chosen.name, name, chosen.criteria, scenarios_hash(chosen.cases), tuple(marks))


def _opinions(detector: Callable[[Orders, int], Detector], bag: Path) -> list[Opinion]:
    """Return what a detector says of a recording."""
    recording = Recording(bag)
    rate = recording.sampling_rate
    candidate, found = detector(recording.orders, rate), []
    for piece in recording.pieces():
        if hasattr(candidate, "sensor_range"):
            candidate.sensor_range = piece.sensor_range
        said = candidate.update(piece.first_index, piece.acceleration, piece.shaft_angle)
        if said is not None:
            found.append(_opinion(said, (piece.first_index + len(piece.shaft_angle) - 1) / rate))
    return found


def _opinion(said: Diagnosis | str, time: float) -> Opinion:
    """Return a diagnosis, or a verdict at a time [s], as the exam takes it."""
    if isinstance(said, Diagnosis):
        return opinion_of(encode_diagnosis(said))
    known = (*VERDICTS, WAITING)
    if said not in known:
        raise Refusal(f"update returned {said!r}, which is not a verdict: return one of {', '.join(known)}{nearest(str(said), known)}")
    return Opinion(time, said)
