"""`dcrb detect`: the fault detector applied to a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dcrb_ros.cli.detect_vehicle import INCOMPLETE, diagnosed_vehicle, print_vehicle, vehicle_as_object
from dcrb_ros.cli.options import DetectorFile, Force, JsonOutput, detector_parameters, warn_of_digests
from dcrb_ros.cli.output_file import check_file, check_force
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted
from dcrb_ros.text.json import json_text
from dcrb_ros.text.writing import write_whole

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.detection import DetectionResult
    from dcrb_ros.diagnosis.healthy_baseline import HealthyBaseline
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.recordings.reader import Recording

DEPTHS = {"outer_ring": "outer_depth", "inner_ring": "inner_depth", "roller": "roller_depth", "cage": "cage_depth"}
"""Parameters with the least modulation depth of a fault's lines; a learned baseline may lower it."""
COLUMNS = ("component", "line", "level [dB]", "depth [-]", "threshold [-]", "excess [dB]")
CAPTION = (
    "Level: over the background. Threshold: of the depth. Excess: the smallest over the thresholds of depth, significance and the other "
    "limits of the rule; a fault is suspected from 0 dB on."
)


def detect(
    bags: Annotated[list[Path], typer.Argument(help="Recordings: folders, or single .mcap or .db3 files.", metavar="BAG ...")],
    as_json: JsonOutput = False,
    detector: DetectorFile = None,
    healthy: Annotated[
        Path | None, typer.Option(help="Recording of the same bearing and sensor while healthy, from which a baseline is learned.")
    ] = None,
    baseline: Annotated[Path | None, typer.Option(help="Saved baseline of the healthy bearing.")] = None,
    save_baseline: Annotated[Path | None, typer.Option(help="New YAML file for the baseline that --healthy gives.")] = None,
    report: Annotated[
        Path | None, typer.Option(help="New HTML file: one page to send, with verdicts, reasons, figures, conditions and limits.")
    ] = None,
    force: Force = False,
) -> None:
    """Run the fault detector on recordings and print its verdicts with the evidence.

    Example: dcrb detect bags/outer_ring_defect

    In the recording of a vehicle, the boxes are compared: dcrb detect bags/bogie

    A page to send, with the trend over the recordings: dcrb detect monday tuesday --report bearing.html
    """
    from dcrb_ros.diagnosis.detection import check_verdict, watch
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.recordings.vehicle_folder import vehicle_boxes

    check_force("--report or --save-baseline", report, save_baseline, force=force)
    if report is not None:
        check_file("--report", report, (".html", ".htm"), force=force)
    parameters = detector_parameters(detector)
    if baseline is not None:
        if parameters.baseline:
            raise Refusal(f"--baseline and the baseline {parameters.baseline} in --detector both give a baseline: leave out one of them")
        parameters = parameters.model_copy(update={"baseline": str(baseline)})
    vehicles = [bag for bag in bags if vehicle_boxes(bag)]
    if vehicles:
        given = {"--healthy": healthy, "--baseline": baseline, "--save-baseline": save_baseline, "--report": report}
        _check_vehicles(bags, vehicles, given)
        compared = [diagnosed_vehicle(bag, parameters) for bag in bags]
        if as_json:
            objects = [{"recording": str(bag), **vehicle_as_object(*vehicle)} for bag, vehicle in zip(bags, compared, strict=True)]
            print(json_text(objects[0] if len(objects) == 1 else objects))
        else:
            for bag, vehicle in zip(bags, compared, strict=True):
                print_vehicle(bag, *vehicle)
        return
    known = _learned(healthy, baseline, save_baseline, parameters, force=force)
    diagnosed = []
    for bag in bags:
        recording = Recording(bag)
        result = watch(recording, parameters=parameters, baseline=known)
        # A program gets an answer in any case, and a page has all recordings; otherwise the reason for no verdict is the error message.
        if report is None and not as_json:
            check_verdict(result, str(bag))
        warn_of_digests(bag, recording)
        diagnosed.append((bag, recording, result))
        if not as_json:
            _print_table(bag, recording, result, parameters, learned=known is not None or bool(parameters.baseline))
    if as_json:
        objects = [{"recording": str(bag), **_as_object(recording, result)} for bag, recording, result in diagnosed]
        print(json_text(objects[0] if len(objects) == 1 else objects))
    if report is not None:
        from dcrb_ros.plots.detection_report import DiagnosedRecording, detection_report

        page = detection_report([DiagnosedRecording(str(bag), recording, result, parameters) for bag, recording, result in diagnosed])
        write_whole(report, page)
        if not as_json:
            print(f"{report}: {counted(len(diagnosed), 'recording')}; a browser shows it, and prints it to PDF")


def _check_vehicles(bags: list[Path], vehicles: list[Path], given: Mapping[str, object]) -> None:
    """Refuse recordings of benches beside that of a vehicle, and options for a single bearing, which are None unless ``given``."""
    option = next((name for name, value in given.items() if value is not None), None)
    if option is not None:
        raise Refusal(f"{vehicles[0]} is the recording of a vehicle, to which {option} does not apply: give one of its boxes")
    bench = next((bag for bag in bags if bag not in vehicles), None)
    if bench is not None:
        raise Refusal(f"{vehicles[0]} is the recording of a vehicle and {bench} is not: diagnose them one after the other")


def _as_object(recording: Recording, result: DetectionResult) -> dict[str, Any]:
    """Return the last diagnosis and the history for JSON."""
    from dcrb_ros.recordings.verification import digest_mismatch, recovered, unsigned

    last = result.last
    return {
        "verdict": last.verdict,
        "confidence": last.confidence,
        "reason": last.reason,
        "time": last.time,
        "first_time": result.since,
        "duration": result.duration,
        "levels": last.levels,
        "lines": {component: asdict(lines) for component, lines in last.lines.items()},
        "shaft_frequency": last.shaft_frequency,
        "scores": last.scores,
        "severity": last.severity,
        "trend": last.trend,
        "gaps": last.gaps,
        "clipped": last.clipped,
        "baseline": last.baseline or None,
        "remarks": last.remarks,
        "complete": recording.complete,
        "mismatch": digest_mismatch(recording) or None,
        "unverified": unsigned(recording) or None,
        "recovered": recovered(recording.stored) or None,
        "history": [{"time": d.time, "verdict": d.verdict, "confidence": d.confidence} for d in result.history],
    }


def _print_table(bag: Path, recording: Recording, result: DetectionResult, parameters: DetectorParameters, *, learned: bool) -> None:
    """Print the last diagnosis as a table and sentences; a ``learned`` baseline lowers thresholds of depth."""
    from dcrb_ros.runtime.terminal import console, table
    from dcrb_ros.schema.printable import decimal
    from dcrb_ros.schema.verdicts import CHARACTERISTIC

    last = result.last
    title, rows = f"{bag}: {last.title}", []
    for fault, name in CHARACTERISTIC.items():
        if fault not in last.scores:
            continue
        line = "2 BSF" if name == "BSF" else name  # a roller defect strikes at twice BSF
        depth = decimal(last.lines[fault].depth, 3) if fault in last.lines else "-"
        threshold = f"{'up to ' if learned else ''}{getattr(parameters, DEPTHS[fault]):g}"
        rows.append((fault, line, decimal(last.levels[name], 1), depth, threshold, decimal(last.scores[fault], 1)))
    shown = console()
    shown.print(table(title, COLUMNS, rows, CAPTION) if rows else title)
    when = f"first at {result.since:.2f} s, in {result.duration:.2f} s of signal"
    for sentence in (f"{last.verdict}, confidence {last.confidence:.2f}, {when}: {last.reason}", *last.remarks):
        shown.print(sentence, soft_wrap=True)
    if not recording.complete:
        shown.print(INCOMPLETE)


def _learned(
    healthy: Path | None, baseline: Path | None, save: Path | None, parameters: DetectorParameters, *, force: bool
) -> HealthyBaseline | None:
    """Return the baseline that a healthy recording gives, and save it if asked; none without such a recording.

    Raises:
        Refusal: the options contradict each other, or the recording gives no baseline.
    """
    from dcrb_ros.diagnosis.detection import learn_baseline
    from dcrb_ros.recordings.reader import Recording

    if healthy is None:
        if save is not None:
            raise Refusal("--save-baseline needs --healthy, the recording from which the baseline is learned")
        return None
    if baseline is not None:
        raise Refusal("--healthy and --baseline both give a baseline: leave out one of them")
    if parameters.baseline:
        raise Refusal(f"--healthy and the baseline {parameters.baseline} in --detector both give a baseline: leave out one of them")
    if save is not None:
        check_file("--save-baseline", save, (".yaml", ".yml"), force=force)
    recording = Recording(healthy)
    learned = learn_baseline(recording, name=healthy.resolve().name, parameters=parameters)
    warn_of_digests(healthy, recording)
    if save is not None:
        learned.save(save)
    return learned
