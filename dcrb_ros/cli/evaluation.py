"""The detector that the options of a command name, evaluated on an exam, on recordings or on measured signals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from dcrb_ros.cli.first_start import announce_compilation
from dcrb_ros.cli.options import detector_parameters, warn_of_digests
from dcrb_ros.schema.refusal import Refusal, repeated

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.exam.detector_run import Signal
    from dcrb_ros.exam.evaluation import Candidate
    from dcrb_ros.exam.kinds import AnyExam
    from dcrb_ros.exam.limits import Limits
    from dcrb_ros.exam.report import Report
    from dcrb_ros.exam.vehicle.signals import VehicleSignal
    from dcrb_ros.recordings.reader import Recording


class DetectorOptions(NamedTuple):
    """Options that name a detector: a node, a Python class, or by default the shipped detector."""

    node: str | None
    """Command that starts the node."""
    python: str | None
    """Class of a detector written in Python."""
    file: Path | None
    """Parameters of the shipped detector."""
    rate: float
    """Recorded over wall time; 0 for as fast as the node answers [-]."""
    patience: float
    """Wall time that the node may take to start [s]."""
    limits: Limits
    """Limits of a Python class in one scenario."""
    given_name: str
    """Name in the report; empty for its command, its class or its parameters."""

    @property
    def name(self) -> str:
        """Name in the report."""
        from dcrb_ros.exam.detector_run import SHIPPED

        shipped = SHIPPED if self.file is None else f"{SHIPPED} with {self.file.name}"
        return self.given_name or self.node or self.python or shipped

    @property
    def parameters(self) -> DetectorParameters:
        """Parameters of the shipped detector."""
        return detector_parameters(self.file)

    def candidate(self) -> Candidate[Recording]:
        """Return the detector for recordings of the bench."""
        if self.node is not None:
            from dcrb_ros.nodes.external_detector import ExternalDetector

            return ExternalDetector(self.node, name=self.name, rate=self.rate, patience=self.patience)
        return self.candidate_in_python()

    def candidate_in_python(self) -> Candidate[Signal]:
        """Return the detector for signals that are not published as messages.

        Raises:
            Refusal: it is a node.
        """
        if self.node is not None:
            raise Refusal(f"--node {self.node} cannot be evaluated by a replica, whose signals have one axis: give a class with --python")
        if self.python is not None:
            from dcrb_ros.exam.plugin_process import ProcessDetector

            return ProcessDetector(self.name, self.python, self.limits)
        from dcrb_ros.exam.detector_run import shipped_detector

        return shipped_detector(self.parameters, self.name)

    def vehicle_candidate(self) -> Candidate[VehicleSignal]:
        """Return the detector for the signals of a vehicle."""
        from dcrb_ros.exam.vehicle.evaluation import ProcessVehicleDetector, shipped_vehicle_detector

        if self.node is not None:
            from dcrb_ros.nodes.external_vehicle_detector import ExternalVehicleDetector

            return ExternalVehicleDetector(self.node, name=self.name, rate=self.rate, patience=self.patience)
        if self.python is not None:
            return ProcessVehicleDetector(self.name, self.python, self.limits)
        return shipped_vehicle_detector(self.parameters, self.name)


def evaluate_measured_folder(folder: Path, options: DetectorOptions, speed: str, longest: float, workers: int, *, quiet: bool) -> Report:
    """Return the report of measured recordings, of each at most ``longest`` [s]."""
    from dcrb_ros.exam.evaluation import evaluate
    from dcrb_ros.exam.measured import ShippedOnce, led_scenarios, read_measured, whole_scenarios
    from dcrb_ros.exam.plugin_process import ProcessDetector

    progress, recordings = partial(progress_of, quiet=quiet), read_measured(folder, speed)
    if options.python is not None:
        candidate = ProcessDetector(options.name, options.python, options.limits)
        return evaluate(candidate, led_scenarios(recordings, speed, longest), workers=workers, progress=progress)
    whole = whole_scenarios(recordings, speed, longest)
    return evaluate(ShippedOnce(options.name, options.parameters), whole, workers=workers, progress=progress)


def evaluate_exam(exam: AnyExam, options: DetectorOptions, recordings: Path | None, workers: int, *, quiet: bool) -> Report:
    """Return the report of an exam of a bearing or of a vehicle; ``recordings`` is the folder that keeps what is simulated."""
    from dcrb_ros.exam.evaluation import evaluate
    from dcrb_ros.exam.exam_file import Exam
    from dcrb_ros.exam.exam_scenarios import scenarios_of
    from dcrb_ros.exam.recording_cache import checked_folder, default_folder
    from dcrb_ros.exam.vehicle.evaluation import vehicle_scenarios

    with checked_folder(recordings or (default_folder() if isinstance(exam, Exam) else default_folder() / "vehicles")) as folder:
        candidate: Candidate[Any]
        scenarios: Any
        if isinstance(exam, Exam):
            candidate = options.candidate() if exam.replica is None else options.candidate_in_python()
            scenarios = scenarios_of(exam, folder)
        else:
            candidate, scenarios = options.vehicle_candidate(), vehicle_scenarios(exam, folder, workers)
        announce_compilation(quiet=quiet)
        return evaluate(candidate, scenarios, workers=workers, progress=partial(progress_of, quiet=quiet))


def evaluate_bags(bags: Sequence[Path], options: DetectorOptions, *, run_detector: bool, workers: int, quiet: bool) -> Report:
    """Return the report of recordings: of a detector if ``run_detector``, otherwise of the diagnoses in the recordings."""
    from dcrb_ros.exam.evaluation import evaluate
    from dcrb_ros.exam.recorded_case import RecordedDiagnoses, diagnosed_scenarios, read_recorded_case, recorded_scenarios
    from dcrb_ros.recordings.reader import Recording

    cases = [read_recorded_case(bag, name=name) for bag, name in zip(bags, _names(bags), strict=True)]
    for case in cases:
        for damage in case.damage:
            typer.echo(f"{case.path}: {damage}; the readable part is scored", err=True)
        with suppress(Refusal):  # recorded diagnoses are scored without reading the waveform
            warn_of_digests(case.path, Recording(case.path))
    if not run_detector:
        return evaluate(RecordedDiagnoses(), diagnosed_scenarios(cases))
    return evaluate(options.candidate(), recorded_scenarios(cases), workers=workers, progress=partial(progress_of, quiet=quiet))


def _names(bags: Sequence[Path]) -> list[str]:
    """Return a name for each recording: the name of its folder, or the whole path if two folders have the same name."""
    short = [bag.resolve().name for bag in bags]
    names = [name if short.count(name) == 1 else str(bag) for name, bag in zip(short, bags, strict=True)]
    if (twice := repeated(names)) is not None:
        raise Refusal(f"{twice} is given twice: give every recording once")
    return names


@contextmanager
def progress_of(activity: str, total: int, *, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Show a progress bar; yield the function to call with the name of each scenario that is done."""
    from rich.progress import MofNCompleteColumn, TextColumn, TimeElapsedColumn

    from dcrb_ros.runtime.terminal import progress

    columns = (MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.fields[last]}", markup=False))
    with progress(*columns, quiet=quiet) as bar:
        task = bar.add_task(f"scenarios {activity}", total=total, last="")
        yield lambda name: bar.update(task, advance=1, last=name)
