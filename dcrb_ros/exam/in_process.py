"""The exam of a detector written in Python, in this process."""

from __future__ import annotations

from pathlib import Path

from dcrb_ros.exam.detector_run import PythonDetector
from dcrb_ros.exam.evaluation import evaluate
from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.exam_scenarios import scenarios_of
from dcrb_ros.exam.recording_cache import checked_folder, default_folder
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.running_detector import DetectorFactory
from dcrb_ros.schema.refusal import Refusal

MOST_WORKERS = 256


def score(detector: DetectorFactory, exam: str | Path = "smoke", *, recordings: str | Path | None = None, workers: int = 1) -> Report:
    """Evaluate a detector against the known faults of an exam, as ``dcrb score`` does with a node.

    Parameters
    ----------
    detector
        Called for every scenario with the characteristic orders of the bearing and the sampling rate [Hz]; returns the detector. Its
        ``update(index, acceleration, shaft_angle)`` receives the blocks: index of the first sample, acceleration of shape (samples, 2)
        [m/s^2] and shaft angle of shape (samples,) [rad]; it returns a `Diagnosis`, a verdict or None.
    exam
        A shipped exam (``"smoke"``, ``"standard"`` ...) or a YAML file.
    recordings
        Folder that keeps the simulated scenarios for later calls; by default a folder in the user's cache.
    workers
        Number of scenarios simulated in parallel. More than one start processes of their own; a script must then call this below
        ``if __name__ == "__main__":``, a notebook need not.

    Returns
    -------
    Report
        ``passed``, ``checks()``, ``delays()``, ``confusion()``, and ``results``, one per scenario.

    Raises
    ------
    Refusal
        The exam is unknown, workers is outside 1 .. 256, the folder cannot be written, the detector cannot be called,
        has no ``update``, or returns an unknown verdict, a score that is not finite or a stamp after the signal that it got.
    RuntimeError
        The detector raised an exception or called ``sys.exit``; the message names it, the scenario and the sample.

    Examples
    --------
    >>> import dcrb_ros
    >>> report = dcrb_ros.score(dcrb_ros.FaultDetector, "smoke")
    >>> report.passed
    True
    """
    if not callable(detector):
        raise Refusal(f"detector = {detector!r} cannot be called: give a class such as dcrb_ros.FaultDetector, or a function")
    if not 1 <= workers <= MOST_WORKERS:
        raise Refusal(f"workers = {workers} is outside 1 .. {MOST_WORKERS}: give the number of parallel simulations")
    candidate = PythonDetector(getattr(detector, "__name__", type(detector).__name__), detector, parallel=False)
    given = read_exam(exam)
    with checked_folder(Path(recordings) if recordings is not None else default_folder()) as folder:
        return evaluate(candidate, scenarios_of(given, folder), workers=workers)
