"""`dcrb detect` on the recording of a vehicle: the comparing diagnosis, and that of each box by itself."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.diagnosis.vehicle.detection import VehicleDetectionResult
    from dcrb_ros.recordings.vehicle import VehicleRecording

COLUMNS = ("part", "verdict", "confidence", "evidence")
CAPTION = "Alone: what the fault detector of each box names by itself, without the others."


INCOMPLETE = "the recording is truncated or damaged; the verdict is based on its readable part"
"""Note on a recording that is not whole."""


def diagnosed_vehicle(bag: Path, parameters: DetectorParameters) -> tuple[VehicleRecording, VehicleDetectionResult]:
    """Return the recording of a vehicle and its diagnoses.

    Raises:
        Refusal: it cannot be read, or is too short.
    """
    from dcrb_ros.cli.options import warn_of_digests
    from dcrb_ros.diagnosis.vehicle.detection import detect_vehicle
    from dcrb_ros.recordings.vehicle import VehicleRecording

    recording = VehicleRecording(bag)
    result = detect_vehicle(recording, box_parameters=parameters)
    warn_of_digests(bag, *recording.boxes.values())
    return recording, result


def vehicle_as_object(recording: VehicleRecording, result: VehicleDetectionResult) -> dict[str, Any]:
    """Return the diagnosis of a vehicle for JSON."""
    from dcrb_ros.recordings.verification import digest_mismatch, recovered, unsigned

    last, boxes = result.last, recording.boxes.items()
    return {
        "time": last.time,
        "damaged": result.damaged,
        "statuses": {name: asdict(status) for name, status in result.statuses.items()},
        "indicators": dict(last.indicators),
        "alone": {name: {"verdict": d.verdict, "confidence": d.confidence, "reason": d.reason} for name, d in last.boxes.items()},
        "complete": not recording.damage,
        "mismatch": {name: sentence for name, box in boxes if (sentence := digest_mismatch(box))} or None,
        "unverified": {name: sentence for name, box in boxes if (sentence := unsigned(box))} or None,
        "recovered": recovered(recording.stored) or None,
        "history": [{"time": d.time, "verdicts": {name: s.verdict for name, s in d.statuses.items()}} for d in result.history],
    }


def print_vehicle(bag: Path, recording: VehicleRecording, result: VehicleDetectionResult) -> None:
    """Print the diagnosis of a vehicle as a table, and what each box names by itself."""
    from dcrb_ros.runtime.terminal import console, table

    each = result.statuses.items()
    rows = [(name, status.verdict, f"{status.confidence:.2f}" if status.confidence else "-", status.reason) for name, status in each]
    shown = console()
    shown.print(table(f"{bag}: {result.summary}", COLUMNS, rows, CAPTION))
    alone = ", ".join(f"{name} {diagnosis.verdict}" for name, diagnosis in result.last.boxes.items())
    shown.print(f"alone: {alone}", soft_wrap=True)
    if recording.damage:
        shown.print(INCOMPLETE)
