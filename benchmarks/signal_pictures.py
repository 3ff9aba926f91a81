"""Pictures of simulated signals beside measured ones: waveform, power density and squared envelope spectrum, for docs/results/signals.md.

``python benchmarks/signal_pictures.py MEASURED -o FOLDER``. Of each rig the recording with the median R is shown, of the simulation the
first machines.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
from realism import ROW_NAMES, draw_row
from signal_machines import BENCHES, RIGS, TRUTHS, Case, case_of, order_of, recordings, run_of

SHOWN = {"outer": (("6205", 1), ("6205", 2), ("axle box", 1)), "inner": (("6205", 1), ("6205", 2))}
"""Bearing and seed of the simulated machines by kind of defect."""


def typical(folder: Path, rig: str, kind: str) -> Case:
    """Return the recording of a rig with a kind of defect whose R is the median, the lower one of two."""
    found = [case for case, its, truth in recordings(folder).values() if (its, truth) == (RIGS[rig][0], TRUTHS[kind])]
    ranked = sorted(found, key=lambda case: case.ratio(kind))
    return ranked[(len(ranked) - 1) // 2]


def draw(path: Path, cases: list[Case], kind: str) -> None:
    """Draw a row for each case."""
    figure, axes = plt.subplots(len(cases), 3, figsize=(13.0, 2.1 * len(cases)), layout="constrained")
    for row, case in zip(axes, cases, strict=True):
        draw_row(row, case, order_of(case.orders, kind))
    for ax, name in zip(axes[-1], (*ROW_NAMES[:2], f"order over {'BPFO' if kind == 'outer' else 'BPFI'}, depth [-]"), strict=True):
        ax.set_xlabel(name, fontsize="small")
    figure.savefig(path, dpi=80)
    plt.close(figure)


def main() -> None:
    """Draw a picture for each kind of defect."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path())
    parser.add_argument("--kinds", nargs="+", choices=list(SHOWN), default=list(SHOWN))
    given = parser.parse_args()
    for kind in given.kinds:
        cases = [typical(given.measured, rig, kind) for rig in RIGS]
        for bearing, seed in SHOWN[kind]:
            run = run_of(bearing, kind, seed, "drawn")
            cases.append(case_of(run, f"simulated: {bearing}, machine {seed}", BENCHES[bearing][2], ring=False))
        draw(given.output / f"signals-{kind}.png", cases, kind)


if __name__ == "__main__":
    main()
