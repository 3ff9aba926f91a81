"""The value of simulation on measured bearings: a classifier trained on simulated windows alone, tested on the faults of measured rigs.

``python benchmarks/sim_to_real.py MEASURED -o FOLDER``; MEASURED is a folder with ``recordings.csv`` and ``recordings/NAME.npz``, as for
``benchmarks/realism.py``. The sweeps and a table are written to FOLDER; a second call of the same model continues.
``--machines 64 --seconds 8`` is the full size, hours of processor time. docs/explanation/sim-to-real.md states the protocol,
docs/results/sim-to-real.md the result.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sim_to_real_data import (
    CLASSES,
    RIGS,
    Measured,
    Rig,
    Windows,
    measured,
    measured_elsewhere,
    measured_windows,
    settings_of,
    simulated_windows,
    sweep_tree,
)
from sim_to_real_figure import write_figure, write_gaps
from sim_to_real_scores import Gap, Score, chosen, forest_scores, gain, gaps_of, left_out_scores, rule_scores, scored
from sim_to_real_trainings import drawn_windows, noisy_windows

from dcrb_ros.calibration.calibration import calibrate
from dcrb_ros.exam.statistics import Interval
from dcrb_ros.settings.files import load_configuration, to_yaml
from dcrb_ros.text.markdown import table

BENCH = "ball_bearing_6205"
SPEED = "operating.speed"
"""Beginning of the keys that the calibration estimates from the angle of the shaft."""
SHAPES = {"with band levels": (True, False), "without": (False, False), "that match": (True, True)}
"""Sets of features: with levels of bands, and only those that match the healthy machine."""
DRAWN, RIGID, CALIBRATED = "simulated, drawn laboratory", "simulated, rigid path", "simulated, calibrated"
"""Trainings: machines of a laboratory drawn from ranges, the bench at the ring, and machines like the calibrated one."""
OTHERS = "measured on the other rigs"
"""What a gap is compared with: the same for real rigs, resampled to one rate."""
OWN = "its own other bearings"
"""The training that shows what these features allow at most."""

Row = tuple[str, str, str, Score]
"""Rig, training, set of features and score."""


def calibrated(rig: Rig, healthy: list[Measured], folder: Path, machines: int, seconds: float, workers: int) -> Windows:
    """Return windows of the rig's bearing on a bench calibrated to healthy recordings, its machines drawn within the intervals."""
    found = calibrate([one.waveform() for one in healthy], base=load_configuration(BENCH, settings_of(rig)), trust=True)
    folder.mkdir(parents=True, exist_ok=True)
    base = folder / f"{rig.name}.yaml"
    base.write_text(to_yaml(found.configuration))
    vary: dict[str, Any] = {
        one.key: {"low": one.low, "high": one.high, "scale": "log" if one.log and one.low > 0.0 else "linear"}
        for one in found.estimates
        if one.low < one.high and not one.key.startswith(SPEED)  # the rigs have no tacho
    }
    vary["structure.seed"] = {"low": 1, "high": 2_000_000_000}
    tree = sweep_tree(rig, str(base), {"structure.path_spread": found.path_spread}, vary, machines, seconds)
    for line in (*map(str, found.estimates), *found.unidentified):
        print(f"  {line}")
    return simulated_windows(tree, folder / f"{rig.name}-calibrated", workers)


def rows_of(rig: Rig, trainings: Mapping[str, Windows], test: Windows, healthy: Windows | None) -> list[Row]:
    """Return the scores of a rig's recordings, by training and set of features."""
    found: list[Row] = [(rig.name, "envelope rules, no training", "-", scored(rule_scores(test), test))]
    for training, windows in trainings.items():
        for shape, (levels, matching) in SHAPES.items():
            if (levels and windows.names != test.names) or (matching and (healthy is None or "healthy" not in windows.truth)):
                continue  # another sampling rate has other bands
            given = chosen(windows, test, levels, healthy if matching else None)
            found.append((rig.name, training, f"{shape} ({given.test.shape[1]})", scored(forest_scores(windows.truth, given), test)))
    if healthy is not None:
        for shape, (levels, matching) in SHAPES.items():
            if not matching:
                found.append((rig.name, OWN, shape, scored(left_out_scores(test, healthy, levels), test)))
    return found


def gains_of(rig: Rig, trainings: Mapping[str, Windows], test: Windows, healthy: Windows) -> list[tuple[str, str, Interval]]:
    """Return how much better the calibrated training set is than that of the drawn laboratory, by set of features."""
    found, (ours, drawn) = [], (trainings[CALIBRATED], trainings[DRAWN])
    for shape, (levels, matching) in SHAPES.items():
        known = healthy if matching else None
        given = chosen(ours, test, levels, known), chosen(drawn, test, levels, known)
        found.append((rig.name, shape, gain(ours, drawn, given, test)))
    return found


def markdown(rows: list[Row]) -> str:
    """Return the scores as a table."""
    cells = []
    for rig, training, shape, score in rows:
        areas = (f"{score.classes[name]:.2f}" if name in score.classes else "" for name in CLASSES)
        cells.append((rig, training, shape, f"{score.macro:.2f} ({score.low:.2f} to {score.high:.2f})", *areas))
    return table(("rig", "training", "features", "macro AUROC (90 % bounds)", *CLASSES), cells)


def markdown_of_gains(gains: list[tuple[str, str, Interval]]) -> str:
    """Return the differences as a table."""
    rows = ((rig, shape, f"{gain.value:+.3f} ({gain.low:+.3f} to {gain.high:+.3f})") for rig, shape, gain in gains)
    return table(("rig", "features", "calibrated minus drawn laboratory (90 % bounds)"), rows)


def markdown_of_gaps(gaps: list[Gap]) -> str:
    """Return the gaps as a table."""
    rows = ((gap.rig, gap.training, gap.fault, f"{gap.shape:.2f}", f"{gap.level:.2f}") for gap in gaps)
    return table(("rig", "training", "class", "without band levels", "band levels"), rows)


def main() -> None:
    """Run the experiment and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("measured", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("sim_to_real"))
    parser.add_argument("--machines", type=int, default=32)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--rigs", nargs="+", default=[rig.name for rig in RIGS], choices=[rig.name for rig in RIGS])
    given = parser.parse_args()
    if not (given.measured / "recordings.csv").is_file():
        print(
            f"{given.measured} has no recordings.csv, so nothing is compared: the recordings are not part of the repository, whose "
            "licences differ; benchmarks/sim_to_real_data.py says what they are",
            file=sys.stderr,
        )
        return
    tests = {rig.name: measured_windows(measured(given.measured, rig)[1]) for rig in RIGS}
    rows: list[Row] = []
    gains: list[tuple[str, str, Interval]] = []
    gaps: list[Gap] = []
    for rig in (rig for rig in RIGS if rig.name in given.rigs):
        drawn = drawn_windows(rig, BENCH, given.output / f"{rig.name}-drawn", given.machines, given.seconds)
        tree = sweep_tree(rig, BENCH, settings_of(rig), {}, given.machines, given.seconds)
        rigid = given.output / f"{rig.name}-rigid"
        trainings = {DRAWN: drawn, RIGID: simulated_windows(tree, rigid, given.workers)}
        healthy, _ = measured(given.measured, rig)
        if healthy:
            trainings[CALIBRATED] = calibrated(rig, healthy, given.output, given.machines, given.seconds, given.workers)
            trainings["simulated, noise of the machine"] = noisy_windows(rigid, healthy)
        trainings |= {f"measured on {name}": windows for name, windows in tests.items() if name != rig.name}
        known = measured_windows(healthy) if healthy else None
        rows += rows_of(rig, trainings, tests[rig.name], known)
        if known is not None:
            gains += gains_of(rig, trainings, tests[rig.name], known)
            simulated = {name: trainings[name] for name in (DRAWN, RIGID, CALIBRATED)}
            gaps += gaps_of(rig.name, simulated | {OTHERS: measured_elsewhere(given.measured, rig)}, tests[rig.name], known)
    tables = "\n\n".join((markdown(rows), markdown_of_gains(gains), markdown_of_gaps(gaps)))
    (given.output / "table.md").write_text(tables)
    write_figure(rows, given.output / "scores.png")
    if gaps:  # MFPT has no healthy recording
        write_gaps(gaps, given.output / "gaps.png")
    print(tables)


if __name__ == "__main__":
    main()
