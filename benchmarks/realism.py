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
from typing import NamedTuple, Protocol

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy import signal

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.bearing.payload import cage_speed
from dcrb_ros.core.laws.lubricants import lubricant_of
from dcrb_ros.core.laws.viscosity import kinematic_viscosity
from dcrb_ros.exam.measured import read_measured
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.validation.friction_moment import friction_moment
from dcrb_ros.validation.oiled_bench import BORE, OUTSIDE
from dcrb_ros.validation.realism import Statistics, lines_of, squared_envelope, statistics

BENCHES = {"healthy": "healthy", "outer_ring": "outer_ring_defect"}
SEEDS = range(1, 9)
MODES = 6
"""Modes of each axle box: the accelerometers of the rigs are on housings that have some."""
SPEEDS = {"600 rpm": 62.832, "1800 rpm": 188.496}
"""Further speeds of healthy bearings [rad/s]."""
SETTLING, DURATION = 0.2, 3.0
"""Simulated time before the statistics, and of them [s]."""
SHOWN = ("cw48_N_0", "hitself_Normal_1200", "mfpt_O3", "hitself_OR5_1200")
"""Measured recordings in the pictures: two of healthy bearings, two of outer-ring faults."""
ROW_NAMES = ("time [ms], acceleration over its rms [-]", "frequency [kHz], power density over the power [1/Hz]")
"""First axes of a row of a picture."""
POINTS = (
    *((speed, 100e3, 60.0) for speed in (31.416, 62.832, 125.664, 188.496)),
    *((125.664, load, 60.0) for load in (5e3, 20e3, 50e3, 200e3)),
    *((125.664, 100e3, temperature) for temperature in (40.0, 80.0)),
)
"""Speed [rad/s], load [N] and temperature [deg C]."""


class Case(NamedTuple):
    """A signal, and the orders and speeds that locate its lines."""

    name: str
    values: Floats
    rate: float
    shaft: float
    orders: Orders

    @property
    def statistics(self) -> Statistics:
        return statistics(self.values, self.rate, self.shaft, self.orders)


def simulated(bench: str, seed: int, *settings: str) -> tuple[Case, Case]:
    """Return the acceleration in Y of an individual of a bench, behind the modes of its axle box and at the outer ring itself."""
    path = ("structure.housing=none", f"structure.modes={MODES}", f"structure.seed={seed}")
    given = (f"surfaces.seed={seed}", f"simulation.seed={seed}", *path, *settings)
    configuration = load_configuration(bench, given)
    blocks = list(Simulation(configuration, waveform_only=True).blocks(SETTLING + DURATION))
    start, shaft = round(SETTLING * blocks[0].rate), configuration.operating.speed / (2.0 * np.pi)
    orders = characteristic_orders(configuration.bearing)
    box, ring = (
        Case(f"{bench} {seed}", np.concatenate(parts)[start:, 1].astype(np.float64), blocks[0].rate, shaft, orders)
        for parts in ([block.acceleration for block in blocks], [block.clean for block in blocks])
    )
    return box, ring


def measured(folder: Path) -> dict[tuple[str, str], list[Case]]:
    """Return the recordings of a folder by truth and rig."""
    cases: dict[tuple[str, str], list[Case]] = defaultdict(list)
    for recording in read_measured(folder):
        values = recording.samples()
        cases[recording.truth, recording.rig].append(
            Case(recording.name, values - values.mean(), float(recording.rate), recording.speed, recording.orders)
        )
    return cases


def table(title: str, cases: dict[str, list[Case]]) -> None:
    """Print median and range of each statistic of groups of signals."""
    rows = {name: [case.statistics for case in group] for name, group in cases.items()}
    print(f"\n| {title} | " + " | ".join(f"{name} ({len(group)})" for name, group in rows.items()) + " |")
    print("|---" * (1 + len(rows)) + "|")
    for field in (*(field for field in Statistics._fields if field != "harmonics"), "harmonic 1", "harmonic 8"):
        cells = []
        for group in rows.values():
            number = field.split()[-1]
            values = np.array([s.harmonics[int(number) // 8] if field.startswith("harmonic ") else getattr(s, field) for s in group])
            cells.append(f"{np.median(values):.3g} ({values.min():.3g} to {values.max():.3g})")
        print(f"| {field} | " + " | ".join(cells) + " |")


def operating_points() -> None:
    """Print cage slip and friction over speed, load and temperature, with the friction moment by SKF."""
    print("\n| speed rpm | load kN | temperature deg C | cage slip of both rows % | power lost W | by SKF W | ratio |")
    print("|---" * 7 + "|")
    for speed, load, temperature in POINTS:
        given = {"operating.speed": speed, "operating.load": load, "lubrication.temperature": temperature}
        still = ["operating.speed_fluctuation=0", "operating.speed_ripple=0"]
        configuration = load_configuration("healthy", [*(f"{key}={value}" for key, value in given.items()), *still])
        simulation = Simulation(configuration)
        list(simulation.blocks(0.5))
        before, angles = simulation.energy, simulation._state.cage_position[:, 2].copy()
        list(simulation.blocks(2.0))
        slip = 1.0 - (simulation._state.cage_position[:, 2] - angles) / 2.0 / cage_speed(configuration, speed)
        power = (simulation.energy.drive - before.drive) / 2.0
        viscosity = kinematic_viscosity(lubricant_of(dict(configuration.lubrication)), temperature)
        skf = 2.0 * speed * friction_moment(BORE, OUTSIDE, 0.5 * load, speed, viscosity)
        slips = ", ".join(f"{100.0 * share:.2f}" for share in slip)
        print(f"| {speed * 30 / np.pi:.0f} | {load / 1e3:g} | {temperature:g} | {slips} | {power:.0f} | {skf:.0f} | {power / skf:.2f} |")


class Signal(Protocol):
    """What a row of a picture needs of a signal."""

    @property
    def name(self) -> str: ...
    @property
    def values(self) -> Floats: ...
    @property
    def rate(self) -> float: ...
    @property
    def shaft(self) -> float: ...


def draw_row(row: Sequence[Axes], case: Signal, order: float) -> None:
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


def draw(path: Path, cases: Sequence[Signal], orders: Sequence[float], line: str = "BPFO") -> None:
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
    named = {case.name: case for cases in measured(folder).values() for case in cases}
    shown = [named[name] for name in SHOWN]
    for truth, name, theirs in (("healthy", "realism-healthy.png", shown[:2]), ("outer_ring", "realism-outer.png", shown[2:])):
        cases = [*(simulated(BENCHES[truth], seed)[0] for seed in SEEDS[:2]), *theirs]
        draw(pictures / name, cases, [case.orders.bpfo for case in cases])


def print_tables(folder: Path) -> None:
    """Print the statistics of simulated and measured bearings, and friction over the operating points."""
    ours, rings = {}, {}
    for truth, bench in BENCHES.items():
        ours[truth], rings[truth] = map(list, zip(*(simulated(bench, seed) for seed in SEEDS), strict=True))
    theirs = measured(folder)
    for truth in BENCHES:
        both = {"simulated": ours[truth], "simulated, rigid box": rings[truth]}
        table(truth, both | {rig: cases for (its, rig), cases in theirs.items() if its == truth})
    at_speeds = {name: [simulated("healthy", seed, f"operating.speed={speed}")[1] for seed in SEEDS] for name, speed in SPEEDS.items()}
    table("healthy, rigid box", {"1200 rpm": rings["healthy"], **at_speeds})
    operating_points()


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
