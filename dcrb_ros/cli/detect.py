"""`dcrb detect`: the fault detector applied to a recording."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from dcrb_ros.cli.options import Bag, DetectorFile, JsonOutput
from dcrb_ros.runtime.refusal import Refusal

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters


def detector_parameters(file: Path | None) -> DetectorParameters:
    """Return the fault detector's parameters from a ROS parameter file, or the defaults without a file.

    Raises:
        Refusal: see `read_parameters` and `validated`.
    """
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.settings.files import read_parameters, validated

    return DetectorParameters() if file is None else validated(read_parameters(file, "fault_detector"), DetectorParameters, str(file))


def detect(bag: Bag, as_json: JsonOutput = False, detector: DetectorFile = None) -> None:
    """Run the fault detector on a recording and print its verdict with the evidence.

    Example: dcrb detect bags/outer_ring_defect
    """
    from dcrb_ros.diagnosis.detector import FaultDetector
    from dcrb_ros.recordings.reader import Recording

    recording, parameters = Recording(bag), detector_parameters(detector)
    rate = recording.sampling_rate
    fault_detector = FaultDetector(recording.orders, rate, parameters)
    diagnoses, seconds = [], 0.0
    for vibration, sensor_range in recording.ranged_vibrations():
        fault_detector.sensor_range = sensor_range
        diagnosis = fault_detector.update(vibration.first_index(rate), vibration.acceleration, vibration.shaft_angle)
        seconds += len(vibration.shaft_angle) / rate
        if diagnosis is not None:
            diagnoses.append(diagnosis)
    verdicts = [diagnosis for diagnosis in diagnoses if diagnosis.verdict != "waiting"]
    if not verdicts:
        reason = diagnoses[-1].reason if diagnoses else f"the detector needs {parameters.window:g} s"
        raise Refusal(f"{bag} contains {seconds:.2f} s of waveform, too little for a verdict: {reason}")
    last = verdicts[-1]
    first = next(diagnosis for diagnosis in verdicts if diagnosis.verdict == last.verdict)
    if as_json:
        about = {
            "verdict": last.verdict,
            "confidence": last.confidence,
            "reason": last.reason,
            "time": last.time,
            "first_time": first.time,
            "levels": last.levels,
            "shaft_frequency": last.shaft_frequency,
            "scores": last.scores,
            "severity": last.severity,
            "trend": last.trend,
            "gaps": last.gaps,
            "clipped": last.clipped,
            "remarks": last.remarks,
            "complete": recording.complete,
            "history": [{"time": d.time, "verdict": d.verdict, "confidence": d.confidence} for d in diagnoses],
        }
        print(json.dumps(about, indent=2))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table("fault", "line", "level over background [dB]", "over threshold [dB]", title=f"{bag}: {last.verdict}")
    for (fault, score), (name, level) in zip(last.scores.items(), last.levels.items(), strict=False):
        table.add_row(fault, name, f"{level:.1f}", f"{score:.1f}")
    console = Console()
    console.print(table)
    console.print(
        f"{last.verdict}, confidence {last.confidence:.2f}, first at {first.time:.2f} s of {seconds:.2f} s: {last.reason}", highlight=False
    )
    for remark in last.remarks:
        console.print(remark, highlight=False)
    if not recording.complete:
        console.print("the recording is truncated; the verdict is based on its readable part")
