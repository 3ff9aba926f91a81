"""The page of results of the exam bogie: which box, false alarms and masked spalls, of three detectors.

    python benchmarks/bogie.py --recordings FOLDER [--kept] > table.md

The three are the comparing detector, the fault detector of each box by itself, and the loudest of the boxes that it names. With ``--kept``
only vehicles are diagnosed that are in the folder already.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dcrb_ros.diagnosis.vehicle.detector import VehicleDetector
from dcrb_ros.exam.statistics import share
from dcrb_ros.exam.vehicle.exam_file import VehicleCase, read_vehicle_exam
from dcrb_ros.exam.vehicle.signals import MotionMemory, VehicleSignal, kept_signal, signal_path
from dcrb_ros.schema.verdicts import BEARING_FAULTS

GROUPS = {
    "one damaged box, -10 dB": ("outer", "inner", "roller"),
    "two damaged boxes on an axle": ("two_outer_inner", "two_roller_outer"),
    "spall under a rough and corrugated rail": ("masked_outer", "masked_inner", "masked_roller"),
    "flats": ("flat",),
    "joints": ("joints",),
}
"""Kinds of scenarios by the row in which they are; every other kind has a row of its own."""
DETECTORS = ("comparing", "each box alone", "loudest")


def alarms(signal: VehicleSignal) -> dict[str, dict[str, str]]:
    """Return the bearing alarms that each detector raised at any time, by box."""
    detector = VehicleDetector(signal.description)
    found: dict[str, dict[str, str]] = {name: {} for name in DETECTORS}
    for blocks in signal.blocks():
        diagnosis = detector.add(blocks)
        if diagnosis is None:
            continue
        found["comparing"].update(diagnosis.damaged())
        found["each box alone"].update({name: d.verdict for name, d in diagnosis.boxes.items() if d.verdict in BEARING_FAULTS})
    named = found["each box alone"]
    if named:
        loudest = max(named, key=lambda name: float(np.square(signal.acceleration[name]).mean()))
        found["loudest"] = {loudest: named[loudest]}
    return found


def outcome(found: Mapping[str, str], case: VehicleCase) -> tuple[bool, bool]:
    """Return whether the alarms are on the damaged boxes and no other, and whether a healthy box has one."""
    damaged = {name.replace(".", "/") for name, verdict in case.damaged.items() if verdict in BEARING_FAULTS}
    return set(found) == damaged, bool(set(found) - damaged)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=Path, required=True)
    parser.add_argument("--kept", action="store_true")
    given = parser.parse_args()
    exam, memory = read_vehicle_exam("bogie"), MotionMemory()
    rows: dict[str, list[dict[str, tuple[bool, bool]]]] = defaultdict(list)
    for case in exam.cases:
        if given.kept and not signal_path(case.parameters, case.duration, given.recordings).is_file():
            continue
        found = alarms(kept_signal(case.parameters, case.duration, given.recordings, memory))
        row = next((name for name, kinds in GROUPS.items() if case.tags["kind"] in kinds), case.tags["kind"])
        if row.startswith("one"):
            row = f"one damaged box, -{case.tags['variant'].replace('dB', ' dB')}"
        rows[row].append({name: outcome(found[name], case) for name in DETECTORS})
    for number, title in enumerate(("vehicles with alarms on the damaged boxes and no other", "vehicles with an alarm on a healthy box")):
        print(f"\nNumber of {title}, with its interval of 95 %:\n")
        _print_table(rows, number)


def _print_table(rows: Mapping[str, list[dict[str, tuple[bool, bool]]]], number: int) -> None:
    """Print the counts of one kind of outcome by row and detector."""
    print(f"| scenario | vehicles | {' | '.join(DETECTORS)} |")
    print(f"|---|---|{'---|' * len(DETECTORS)}")
    for row, results in rows.items():
        counts = [sum(result[name][number] for result in results) for name in DETECTORS]
        intervals = [share(count, len(results)) for count in counts]
        cells = [f"{count} ({interval[1]:.0%} to {interval[2]:.0%})" for count, interval in zip(counts, intervals, strict=True)]
        print(f"| {row} | {len(results)} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
