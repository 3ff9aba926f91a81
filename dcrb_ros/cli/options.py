"""Arguments, checks and messages shared by several commands."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli import completion
from dcrb_ros.schema.refusal import AlteredSamples, Refusal, repeated

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.recordings.reader import Recording

MOST_WORKERS = 256
"""Largest number of parallel runs that is accepted [-]."""
OF_NODES = {
    "time_scale": "the simulation runs as fast as it can",
    "publishing.clock": "nothing is published",
    "publishing.listeners": "nothing is published",
    "publishing.wait": "nothing is published",
    "recording.path": "and name the recording with -o",
    "recording.queue": "the simulation waits for the disk",
}
"""Parameters that only nodes use, each with what takes their place in a command without nodes."""

Bag = Annotated[Path, typer.Argument(help="Recording: its folder, or a single .mcap or .db3 file.")]
Config = Annotated[
    str,
    typer.Argument(
        help="Configuration: a YAML file or a shipped name, such as outer_ring_defect.", autocompletion=completion.configurations
    ),
]
OptionalConfig = Annotated[
    str | None,
    typer.Argument(help="Configuration: a YAML file or a shipped name, such as healthy.", autocompletion=completion.configurations),
]
Duration = Annotated[float, typer.Option(help="Simulated time [s], above 0 and up to 1e6.")]


def each_once(settings: list[str] | None) -> list[str] | None:
    """Return the values of --set, KEY=VALUE; of a key that is given twice, the last value would be taken without a word.

    Raises:
        Refusal: a key is given twice.
    """
    keys = [setting.partition("=")[0].strip() for setting in settings or ()]
    if (twice := repeated(keys)) is not None:
        values = " and ".join(setting.partition("=")[2] for setting, key in zip(settings or (), keys, strict=True) if key == twice)
        raise Refusal(f"--set {twice} is given more than once, as {values}: give it once")
    return settings


Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        callback=each_once,
        help="Override a parameter, KEY=VALUE, such as operating.speed=100.0 [rad/s]; may be repeated.",
        autocompletion=completion.settings,
    ),
]
Scenario = Annotated[
    Path | None,
    typer.Option(
        help="Scenario: a YAML file or a shipped name; a timeline of speed, load, faults and sensor in simulated time.",
        autocompletion=completion.scenarios,
    ),
]
DetectorFile = Annotated[
    Path | None,
    typer.Option(help="Parameters of the shipped detector: a YAML file, such as a copy of config/detector.yaml. Default: built-in values."),
]
JsonOutput = Annotated[bool, typer.Option("--json", help="Print JSON instead of text and tables.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print the result only: no progress and no notes.")]
Force = Annotated[bool, typer.Option("--force", "-f", help="Replace what exists under the name of the output.")]
Workers = Annotated[int, typer.Option(help=f"Number of parallel runs, 0 to {MOST_WORKERS}; 0 uses all cores.")]


def worker_count(workers: int) -> int:
    """Return the number of processes for the option --workers; 0 gives one per core.

    Raises:
        Refusal: the number is out of range.
    """
    if not 0 <= workers <= MOST_WORKERS:
        raise Refusal(f"--workers {workers} is outside 0 .. {MOST_WORKERS}: give the number of parallel runs, 0 for one per core")
    from dcrb_ros.runtime.processes import cores

    return workers or cores()


def detector_parameters(file: Path | None) -> DetectorParameters:
    """Return the fault detector's parameters from a ROS parameter file, or the defaults without a file.

    Raises:
        Refusal: see `read_parameters` and `validated`.
    """
    from dcrb_ros.diagnosis.parameters import DetectorParameters

    if file is None:
        return DetectorParameters()
    from dcrb_ros.settings.files import read_parameters, validated

    return validated(read_parameters(file, "fault_detector"), DetectorParameters, str(file))


def check_speed(speed: str) -> None:
    """Refuse a --speed that is no column of speeds in a table of measured recordings."""
    from dcrb_ros.exam.measured import SPEEDS

    if speed not in SPEEDS:
        raise Refusal(f"--speed {speed} is unknown: give {' or '.join(SPEEDS)}")


def refuse_given(context: typer.Context, reason: str, *names: str) -> None:
    """Refuse options that the command line has although they would have no effect.

    Args:
        context: the command line.
        reason: the rest of the sentence, such as ``applies to --node only``.
        names: parameters of the command, by their names in Python.
    """
    for parameter in context.command.params:
        source = context.get_parameter_source(str(parameter.name))
        if parameter.name in names and source is not None and source.name == "COMMANDLINE":
            raise Refusal(f"{max(parameter.opts, key=len)} {reason}")


def refuse_node_settings(settings: Sequence[str] | None) -> None:
    """Refuse settings that only the nodes use, in a command without nodes."""
    keys = [setting.partition("=")[0].strip() for setting in settings or ()]
    for key in keys:
        if key in OF_NODES:
            raise Refusal(f"--set {key} has no effect without nodes: leave it out, {OF_NODES[key]}")


def warn_of_digests(bag: Path, *opened: Recording, samples: bool = True) -> None:
    """Warn if the samples of a recording do not match the digest that it states, and note if it states none, or was recovered.

    The samples are read unless the waveform was; without ``samples``, they are not compared. A mismatch that was found while it was read is
    not printed a second time.

    Args:
        bag: the recording, or that of a vehicle.
        opened: the same recording, or the boxes of the vehicle; by default they are opened.
        samples: whether to compare the samples.
    """
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.recordings.vehicle_folder import vehicle_boxes
    from dcrb_ros.recordings.verification import digest_mismatch, recovered, unsigned

    recordings = opened or [Recording(path) for path in [bag / name for name in vehicle_boxes(bag)] or [bag]]
    for recording in recordings:
        if samples and (sentence := digest_mismatch(recording)):
            warnings.warn(f"{recording.path}: {sentence}", AlteredSamples, stacklevel=2)
        _note(recording.path, unsigned(recording))
    _note(bag, recovered(recordings[0].stored))


def _note(bag: Path, sentence: str) -> None:
    if sentence:
        typer.echo(f"note: {bag}: {sentence}", err=True)


def size_text(size: float) -> str:
    """Return a size [byte] as text in MB or GB."""
    return f"{size / 1e9:.3g} GB" if size >= 1e9 else f"{size / 1e6:.3g} MB"
