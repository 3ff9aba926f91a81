"""The page of results of the exam bogie: which box, false alarms and masked spalls, of three detectors, and the causes that are named.

    python benchmarks/bogie.py --recordings FOLDER [--kept] > table.md

The three are the comparing detector, the fault detector of each box by itself, and the loudest of the boxes that it names. With ``--kept``
only vehicles are diagnosed that are in the folder already.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dcrb_ros.diagnosis.vehicle.detector import VehicleDetector
from dcrb_ros.exam.statistics import share
from dcrb_ros.exam.vehicle.exam_file import VehicleCase, read_vehicle_exam
from dcrb_ros.exam.vehicle.signals import VehicleSignal, kept_signal, signal_path
from dcrb_ros.schema.verdicts import BEARING_FAULTS
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, VEHICLE_VERDICTS, kind_of
from dcrb_ros.text.markdown import table

GROUPS = {
    "one damaged box": ("outer", "inner", "roller"),
    "one damaged box, rough rails": ("rough_outer", "rough_inner", "rough_roller"),
    "two damaged boxes on an axle": ("two_outer_inner", "two_roller_outer"),
    "flats": ("flat",),
    "joints": ("joints",),
}
"""Kinds of scenarios by the row in which they are; every other kind has a row of its own."""
CAUSES = {verdict for kind in ("wheel", "sensor", "gear", "track") for verdict in VEHICLE_VERDICTS[kind]} | {UNDECIDED}
"""Verdicts of the comparing detector besides those on bearings; ``undecided`` bearings are counted, too."""
DETECTORS = ("comparing", "each box alone", "loudest")
TITLES = "with alarms on the damaged boxes and no other", "with an alarm on a healthy box", "whose damaged box has the most evidence"
SUSPECTED = 2
"""Number of the outcome that needs one damaged box: without a threshold, there is always a box with the most evidence."""


@dataclass(frozen=True)
class Answers:
    """What the detectors say about a vehicle."""

    alarms: Mapping[str, Mapping[str, str]]
    """Bearing alarms by detector and box, raised at any time."""
    evidence: Mapping[str, Mapping[str, float]]
    """The largest evidence of a bearing fault by detector and box: the score, or the rms for the loudest box."""
    causes: set[str]
    """The other causes that the comparing detector named."""

    def suspects(self, detector: str) -> set[str]:
        """Return the box with the most evidence, or all that have as much."""
        evidence = self.evidence[detector]
        return {name for name, value in evidence.items() if value == max(evidence.values())}


def answers(signal: VehicleSignal) -> Answers:
    """Return what the detectors say about a vehicle."""
    detector = VehicleDetector(signal.description)
    found: dict[str, dict[str, str]] = {name: {} for name in DETECTORS}
    evidence: dict[str, dict[str, float]] = {name: dict.fromkeys(signal.acceleration, -math.inf) for name in DETECTORS}
    evidence["loudest"] = {name: float(np.square(values).mean()) for name, values in signal.acceleration.items()}
    causes: set[str] = set()
    for blocks, _, _ in signal.pieces():
        diagnosis = detector.add(blocks)
        for name, block in blocks.items():
            for reading in block.temperatures:
                detector.take_temperature(name, *reading)
        if diagnosis is None:
            continue
        found["comparing"].update(diagnosis.damaged())
        found["each box alone"].update({name: d.verdict for name, d in diagnosis.boxes.items() if d.verdict in BEARING_FAULTS})
        for name, alone in diagnosis.boxes.items():
            if alone.scores:
                evidence["each box alone"][name] = max(evidence["each box alone"][name], *alone.scores.values())
                evidence["comparing"][name] = max(evidence["comparing"][name], diagnosis.statuses[f"{name}/bearing"].score)
        causes |= {f"{kind_of(name)} {status.verdict}" for name, status in diagnosis.statuses.items() if status.verdict in CAUSES}
    named = found["each box alone"]
    if named:
        loudest = max(named, key=evidence["loudest"].__getitem__)
        found["loudest"] = {loudest: named[loudest]}
    return Answers(found, evidence, causes)


def row_of(case: VehicleCase) -> str:
    """Return the row of the tables in which a vehicle is counted."""
    kind, level = case.tags["kind"], case.tags.get("variant", "").replace("dB", " dB")
    if kind.startswith("masked"):
        return f"masked spall, {case.parameters['track.roughness']:g} dB at {case.parameters['vehicle.speed_kmh']:g} km/h"
    row = next((name for name, kinds in GROUPS.items() if kind in kinds), kind)
    return f"{row}, -{level}" if row.startswith("one") else row


def damaged_boxes(case: VehicleCase) -> dict[str, str]:
    """Return the damaged component by box."""
    return {name.replace(".", "/"): verdict for name, verdict in case.damaged.items() if verdict in BEARING_FAULTS}


def outcome(found: Answers, detector: str, case: VehicleCase) -> tuple[bool, bool, bool]:
    """Return whether the alarms are on the damaged boxes only, whether a healthy box has one, and whether the suspect is damaged."""
    damaged, alarms = set(damaged_boxes(case)), set(found.alarms[detector])
    return alarms == damaged, bool(alarms - damaged), found.suspects(detector) == damaged


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=Path, required=True)
    parser.add_argument("--kept", action="store_true")
    given = parser.parse_args()
    exam = read_vehicle_exam("bogie")
    rows: dict[str, list[dict[str, tuple[bool, bool, bool]]]] = defaultdict(list)
    causes: dict[str, list[set[str]]] = defaultdict(list)
    names: Counter[tuple[str, str]] = Counter()
    for case in exam.cases:
        if given.kept and not signal_path(case.parameters, case.duration, given.recordings).is_file():
            continue
        found = answers(kept_signal(case.parameters, case.duration, given.recordings))
        rows[row_of(case)].append({name: outcome(found, name, case) for name in DETECTORS})
        causes[row_of(case)].append(found.causes)
        names.update((verdict, found.alarms["comparing"].get(name, "none")) for name, verdict in damaged_boxes(case).items())
    print_tables(rows, causes)
    print("\nNumber of damaged boxes by the last component that the comparing detector named:\n")
    print(table(("damaged", "named", "boxes"), ((*pair, count) for pair, count in sorted(names.items()))))


def print_tables(rows: Mapping[str, list[dict[str, tuple[bool, bool, bool]]]], causes: Mapping[str, list[set[str]]]) -> None:
    """Print right boxes, wrong boxes, and the other causes that the comparing detector named."""
    for number, title in enumerate(TITLES):
        counted = (_counted(row, results, number) for row, results in rows.items() if number != SUSPECTED or row.startswith("one "))
        print(f"\nNumber of vehicles {title}, with its interval of 95 %:\n")
        print(table(("scenario", "vehicles", *DETECTORS), counted))
    columns = sorted({cause for vehicles in causes.values() for named in vehicles for cause in named})
    print("\nNumber of vehicles in which the comparing detector named a cause at any time:\n")
    cells = ((row, len(its), *(sum(cause in named for named in its) for cause in columns)) for row, its in causes.items())
    print(table(("scenario", "vehicles", *columns), cells))


def _counted(row: str, results: list[dict[str, tuple[bool, bool, bool]]], number: int) -> tuple[object, ...]:
    """Return the cells of a row: the vehicles, and how many have one kind of outcome with each detector."""
    counts = [sum(result[name][number] for result in results) for name in DETECTORS]
    intervals = [share(count, len(results)) for count in counts]
    return row, len(results), *(f"{count} ({at.low:.0%} to {at.high:.0%})" for count, at in zip(counts, intervals, strict=True))


if __name__ == "__main__":
    main()
