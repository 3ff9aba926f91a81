"""Statistics and pictures of simulated bearings beside measured ones, for docs/results/realism.md.

``python benchmarks/realism.py MEASURED`` prints the statistics; with ``--pictures DIRECTORY`` it draws the pictures instead. MEASURED is a
folder with ``recordings.csv``, which names rig, truth, sampling rate, unit, speed and orders of each recording, and ``recordings/NAME.npz``
with its samples as ``a``. Only statistics and pictures leave it.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy import signal
from signal_machines import DURATION, SETTLING, Case, case_of, recordings

from dcrb_ros.simulation.run import simulate
from dcrb_ros.validation.realism import Statistics, lines_of, squared_envelope, statistics

BENCHES = {"healthy": "healthy", "outer_ring": "outer_ring_defect"}
SEEDS = range(1, 9)
MODES = 6
"""Modes of each axle box: the accelerometers of the rigs are on housings that have some."""
SPEEDS = {"600 rpm": 62.832, "1800 rpm": 188.496}
"""Further speeds of healthy bearings [rad/s]."""
SHOWN = ("cw48_N_0", "hitself_Normal_1200", "mfpt_O3", "hitself_OR5_1200")
"""Measured recordings in the pictures: two of healthy bearings, two of outer-ring faults."""
ROW_NAMES = ("time [ms], acceleration over its rms [-]", "frequency [kHz], power density over the power [1/Hz]")
"""First axes of a row of a picture."""


def simulated(bench: str, seed: int, *settings: str) -> tuple[Case, Case]:
    """Return the acceleration in Y of an individual of a bench, behind the modes of its axle box and at the outer ring itself."""
    path = ("structure.housing=none", f"structure.modes={MODES}", f"structure.seed={seed}")
    given = (f"surfaces.seed={seed}", f"simulation.seed={seed}", *path, *settings)
    run = simulate(bench, SETTLING + DURATION, settings=given)
    return case_of(run, f"{bench} {seed}", ring=False), case_of(run, f"{bench} {seed}", ring=True)


def table(title: str, cases: dict[str, list[Case]]) -> None:
    """Print median and range of each statistic of groups of signals."""
    rows = {name: [statistics(case.values, case.rate, case.shaft, case.orders) for case in group] for name, group in cases.items()}
    print(f"\n| {title} | " + " | ".join(f"{name} ({len(group)})" for name, group in rows.items()) + " |")
    print("|---" * (1 + len(rows)) + "|")
    for field in (*(field for field in Statistics._fields if field != "harmonics"), "harmonic 1", "harmonic 8"):
        cells = []
        for group in rows.values():
            number = field.split()[-1]
            values = np.array([s.harmonics[int(number) // 8] if field.startswith("harmonic ") else getattr(s, field) for s in group])
            cells.append(f"{np.median(values):.3g} ({values.min():.3g} to {values.max():.3g})")
        print(f"| {field} | " + " | ".join(cells) + " |")


def draw_row(row: Sequence[Axes], case: Case, order: float) -> None:
    """Draw a signal, its power spectrum and its squared envelope spectrum over multiples of an order [-]."""
    rms = float(case.values.std())
    count = round(0.1 * case.rate)
    row[0].plot(np.arange(count) / case.rate * 1e3, case.values[:count] / rms, linewidth=0.5, color="#404040")
    row[0].set_title(f"{case.name}, rms {rms:.2g} m/s²", fontsize="small", loc="left")
    frequency, density = signal.welch(case.values / rms, case.rate, nperseg=4096)
    row[1].semilogy(frequency / 1e3, density, linewidth=0.7, color="#0072B2")
    row[1].set_xlim(0.0, 25.0)
    row[1].set_ylim(1e-9, 1e-2)
    squared, rate = squared_envelope(case.values, case.rate)
    lines = lines_of(squared, rate)
    orders = lines.spacing * np.arange(len(lines.depth)) / case.shaft
    shown = orders < 3.5 * order
    row[2].plot(orders[shown] / order, lines.depth[shown], linewidth=0.7, color="#D55E00")
    row[2].set_ylim(0.0, 1.8 if lines.depth[shown].max() > 0.35 else 0.4)
    for ax in row:
        ax.grid(alpha=0.25, linewidth=0.6)
        ax.tick_params(labelsize="x-small")


def draw(path: Path, cases: Sequence[Case], orders: Sequence[float], line: str = "BPFO") -> None:
    """Draw a row for each case, with the squared envelope spectrum over multiples of its order of a line [-]."""
    figure, axes = plt.subplots(len(cases), 3, figsize=(13.0, 2.1 * len(cases)), layout="constrained")
    for row, case, order in zip(axes, cases, orders, strict=True):
        draw_row(row, case, order)
    for ax, name in zip(axes[-1], (*ROW_NAMES, f"order over {line}, depth [-]"), strict=True):
        ax.set_xlabel(name, fontsize="small")
    figure.savefig(path, dpi=80)
    plt.close(figure)


def draw_pictures(folder: Path, pictures: Path) -> None:
    """Draw two simulated individuals beside two measured bearings, healthy and with a defect of the outer ring."""
    named = recordings(folder)
    shown = [named[name][0] for name in SHOWN]
    for truth, name, theirs in (("healthy", "realism-healthy.png", shown[:2]), ("outer_ring", "realism-outer.png", shown[2:])):
        cases = [*(simulated(BENCHES[truth], seed)[0] for seed in SEEDS[:2]), *theirs]
        draw(pictures / name, cases, [case.orders.bpfo for case in cases])


def print_tables(folder: Path) -> None:
    """Print the statistics of simulated and measured bearings."""
    ours, rings = {}, {}
    for truth, bench in BENCHES.items():
        ours[truth], rings[truth] = map(list, zip(*(simulated(bench, seed) for seed in SEEDS), strict=True))
    theirs = recordings(folder).values()
    for truth in BENCHES:
        groups = defaultdict(list, {"simulated": ours[truth], "simulated, rigid box": rings[truth]})
        for case, rig, its in theirs:
            if its == truth:
                groups[rig].append(case)
        table(truth, groups)
    at_speeds = {name: [simulated("healthy", seed, f"operating.speed={speed}")[1] for seed in SEEDS] for name, speed in SPEEDS.items()}
    table("healthy, rigid box", {"1200 rpm": rings["healthy"], **at_speeds})


def main() -> None:
    """Print the tables, or draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("measured", type=Path)
    parser.add_argument("--pictures", type=Path, help="folder of the pictures; then no tables are made")
    given = parser.parse_args()
    if given.pictures:
        draw_pictures(given.measured, given.pictures)
    else:
        print_tables(given.measured)


if __name__ == "__main__":
    main()
