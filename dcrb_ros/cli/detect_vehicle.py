"""`dcrb detect` on the recording of a vehicle: the comparing diagnosis, and that of each box by itself."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.diagnosis.vehicle.detection import VehicleDetectionResult

COLUMNS = ("part", "verdict", "confidence", "evidence")
CAPTION = "Alone: what the fault detector of each box names by itself, without the others."


def diagnosed_vehicle(bag: Path, parameters: DetectorParameters) -> VehicleDetectionResult:
    """Return the diagnoses of the recording of a vehicle.

    Raises:
        Refusal: it cannot be read, or is too short.
    """
    from dcrb_ros.cli.options import warn_of_digests
    from dcrb_ros.diagnosis.vehicle.detection import detect_vehicle
    from dcrb_ros.recordings.vehicle import VehicleRecording

    recording = VehicleRecording(bag)
    warn_of_digests(bag)
    return detect_vehicle(recording, box_parameters=parameters)


def vehicle_as_object(result: VehicleDetectionResult) -> dict[str, Any]:
    """Return the diagnosis of a vehicle for JSON."""
    last = result.last
    return {
        "time": last.time,
        "damaged": result.damaged,
        "statuses": {name: asdict(status) for name, status in result.statuses.items()},
        "indicators": dict(last.indicators),
        "alone": {name: {"verdict": d.verdict, "confidence": d.confidence, "reason": d.reason} for name, d in last.boxes.items()},
        "history": [{"time": d.time, "verdicts": {name: s.verdict for name, s in d.statuses.items()}} for d in result.history],
    }


def print_vehicle(bag: Path, result: VehicleDetectionResult) -> None:
    """Print the diagnosis of a vehicle as a table, and what each box names by itself."""
    from rich.table import Table

    from dcrb_ros.runtime.terminal import console

    damaged = ", ".join(f"{box} {verdict}" for box, verdict in result.damaged.items())
    table = Table(*COLUMNS, title=f"{bag}: {damaged or 'no bearing damaged'}", caption=CAPTION)
    for name, status in result.statuses.items():
        table.add_row(name, status.verdict, f"{status.confidence:.2f}" if status.confidence else "-", status.reason)
    shown = console()
    shown.print(table)
    alone = ", ".join(f"{name} {diagnosis.verdict}" for name, diagnosis in result.last.boxes.items())
    shown.print(f"alone: {alone}", soft_wrap=True)
