"""`dcrb calibrate` and `dcrb compare`: a bench like a machine, and the distances of two recordings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli import completion
from dcrb_ros.cli.first_start import announce_compilation
from dcrb_ros.cli.options import Bag, Force, JsonOutput, Quiet, Settings, warn_of_digests
from dcrb_ros.cli.output_file import PICTURES, check_file, check_force, check_output
from dcrb_ros.runtime.terminal import console, steps, table
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import json_text
from dcrb_ros.text.writing import whole_file

if TYPE_CHECKING:
    from dcrb_ros.calibration.calibration import Calibration
    from dcrb_ros.calibration.comparison import RecordingComparison

TWIN_SECONDS = 4.0
"""Simulated time of the calibrated bench that the figure compares with the recording [s]."""


def calibrate(
    recordings: Annotated[list[Path], typer.Argument(metavar="HEALTHY...", help="Recordings of the healthy machine: folders or files.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="New YAML file of the configuration; intervals and figure go beside it.")],
    base: Annotated[
        str | None,
        typer.Option(
            help="Bench with the machine's bearing: a YAML file or a shipped name. Default: the one that made the recording, or healthy "
            "with rollers that give the recording's orders.",
            autocompletion=completion.configurations,
        ),
    ] = None,
    settings: Settings = None,
    trust: Annotated[bool, typer.Option("--trust", help="Take the recordings as healthy although the detector finds a fault.")] = False,
    as_json: JsonOutput = False,
    quiet: Quiet = False,
    force: Force = False,
) -> None:
    """Fit a bench to healthy recordings of a machine, with an interval for each value and a figure.

    Example: dcrb calibrate bags/healthy -o my_machine.yaml
    """
    check_output("-o", output, (".yaml", ".yml"))
    from dcrb_ros.calibration.calibration import STEPS
    from dcrb_ros.calibration.calibration import calibrate as calibrated
    from dcrb_ros.calibration.comparison import compare as compared
    from dcrb_ros.calibration.files import intervals_beside, write_calibration
    from dcrb_ros.plots.comparison import comparison_figure
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.simulation.run import simulate

    if output.name != intervals_beside(output).name.replace(".intervals.yaml", output.suffix):
        raise Refusal(f"-o {output} has no name before its suffix: give one such as my_machine.yaml")
    figure = output.with_suffix(".png")
    opened = [Recording(path) for path in recordings]
    for path, recording in zip(recordings, opened, strict=True):
        warn_of_digests(path, recording)
    for file in (output, intervals_beside(output), figure):
        check_file("-o", file, force=force)
    announce_compilation(quiet=quiet)
    with steps(STEPS + 2, quiet=quiet) as begin:
        names = [str(path) for path in recordings]
        calibration = calibrated(opened, base=base, settings=settings or (), trust=trust, names=names, progress=begin)
        begin("simulating the calibrated bench")
        twin = simulate(calibration.configuration, 0.5 + TWIN_SECONDS).between(0.5)
        begin("comparing it with the recording")
        comparison = compared(calibration.measured, twin, names=("measured", "simulated"))
    title = f"{output.stem}: {recordings[0]} and the calibrated bench"
    # The figure is the largest file: if it does not fit on the disk, no file is written.
    with whole_file(figure) as drawn:
        comparison_figure(comparison, title=title, calibration=calibration).savefig(drawn)
        beside = write_calibration(calibration, output)
    if as_json:
        print(json_text(_described(calibration) | {"comparison": comparison.as_dict()}))
        return
    _print(calibration, quiet=quiet)
    apart = ", ".join(f"{axis.axis} {axis.level_distance:.1f} dB" for axis in comparison.axes)
    print(f"{output}: third octaves of a simulation are {apart} from the recording; intervals in {beside}, figure in {figure}")


def compare(
    first: Bag,
    second: Annotated[Path, typer.Argument(help="The recording that is compared with it.")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="New figure: .png, .svg or .pdf.")] = None,
    as_json: JsonOutput = False,
    quiet: Quiet = False,
    force: Force = False,
) -> None:
    """Compare two recordings: levels in third octaves, squared envelope spectra, kurtosis by band and features.

    Example: dcrb compare bags/healthy bags/outer_ring_defect -o difference.png
    """
    check_force("-o", output, force=force)
    if output is not None:
        check_file("-o", output, PICTURES, force=force)
    from dcrb_ros.calibration.comparison import STEPS
    from dcrb_ros.calibration.comparison import compare as compared
    from dcrb_ros.plots.comparison import comparison_figure
    from dcrb_ros.recordings.reader import Recording

    recordings = Recording(first), Recording(second)
    for path, recording in zip((first, second), recordings, strict=True):
        warn_of_digests(path, recording)
    with steps(STEPS, quiet=quiet) as begin:
        comparison = compared(*recordings, names=(str(first), str(second)), progress=begin)
    if output is not None:
        with whole_file(output) as drawn:
            comparison_figure(comparison).savefig(drawn)
    if as_json:
        print(json_text(comparison.as_dict()))
        return
    for axis in comparison.axes:
        envelope = "unknown" if not len(axis.orders) else f"{axis.envelope_distance:.2f}"
        kurtosis = "unknown" if math.isnan(axis.kurtosis_distance) else f"{axis.kurtosis_distance:.2f}"
        print(
            f"{axis.axis}: third octaves {axis.level_distance:.1f} dB apart, {axis.shape_distance:.1f} dB without the mean; "
            f"envelope spectra {envelope}; kurtosis by octave {kurtosis}"
        )
    _print_fault_lines(comparison)
    for remark in comparison.remarks:
        print(remark)
    if output is not None:
        print(f"figure in {output}")


def _print_fault_lines(comparison: RecordingComparison) -> None:
    """Print how deep the lines of each fault modulate the squared envelopes, if both recordings have a speed and a bearing."""
    if not comparison.features:
        return
    from dcrb_ros.diagnosis.features.envelope_lines import WIDE
    from dcrb_ros.diagnosis.features.family import FAULTS

    first, second = map(printable, comparison.names)
    title = f"modulation depth of the fault lines [-], {WIDE[0]:g} to {WIDE[1]:g} of each sampling rate"
    depths = comparison.features
    axes = [compared.axis for compared in comparison.axes]
    rows = [(line, axis, *(f"{depth:.3f}" for depth in depths[f"{axis}_wide_{line}_depth"])) for line in FAULTS for axis in axes]
    console().print(table(title, ("line", "axis", first, second), rows))


def _described(calibration: Calibration) -> dict[str, object]:
    return {
        "recordings": list(calibration.recordings),
        "level": calibration.level,
        "estimates": {
            estimate.key: {"value": estimate.value, "low": estimate.low, "high": estimate.high, "unit": estimate.unit}
            for estimate in calibration.estimates
        },
        "path": [level.__dict__ for level in calibration.path],
        "path_spread_db": calibration.path_spread,
        "unidentified": list(calibration.unidentified),
    }


def _print(calibration: Calibration, *, quiet: bool) -> None:
    """Print the estimates, and what could not be identified."""
    if quiet:
        return
    print(f"estimates with intervals of {100.0 * calibration.level:g} %:")
    for estimate in calibration.estimates:
        print(f"  {estimate}")
    print("not identified:")
    for sentence in calibration.unidentified:
        print(f"  {sentence}")
