"""Reliability of the detector's confidence: how many verdicts are right of those said with a confidence, as a table and a figure.

``python benchmarks/reliability.py [MEASURED] -o FILE.png`` judges 500 signals of the independent generator (seed 7) and, if a folder of
measured recordings is given, its healthy ones and its faults of both rings: as a whole, and their first one and two seconds.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))

from jittered_impacts import Machine  # type: ignore[import-not-found]

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.measured import diagnose, diagnose_as_a_whole, read_measured
from dcrb_ros.stream.diagnosis import Diagnosis

SEED, SIGNALS = 7, 500
EDGES = (0.5, 0.6, 0.7, 0.8, 0.85, 0.95, 0.985, 1.0)
FAULTS = ("outer_ring", "inner_ring", "roller")


class Said(NamedTuple):
    """A verdict."""

    confidence: float
    right: bool
    weight: float
    """Healthy signals count three times, so that half of the bearings are healthy."""


def said(diagnosis: Diagnosis, truth: str, weight: float = 1.0) -> Iterator[Said]:
    """Yield the verdict of a diagnosis, if there is one on the bearing."""
    if diagnosis.verdict not in ("waiting", "sensor"):
        yield Said(diagnosis.confidence, diagnosis.verdict == truth, weight)


def generated() -> Iterator[Said]:
    """Yield verdicts on signals of random machines: 1 to 4 s, impacts of 0.08 to 1.6 times the noise."""
    random = np.random.default_rng(SEED)
    for _ in range(SIGNALS):
        machine = Machine(
            int(random.integers(1 << 30)),
            balls=int(random.integers(7, 17)),
            ratio=random.uniform(0.12, 0.3),
            rate=int(random.choice([12000, 25600])),
            speed=random.uniform(10.0, 50.0),
            departure=random.uniform(-0.015, 0.015),
            jitter=random.uniform(0.002, 0.015),
        )
        seconds, truth = float(random.choice([1.0, 2.0, 4.0])), str(random.choice(["healthy", *FAULTS]))
        coloured = bool(random.random() < 0.7)
        parts = {"shaft": random.uniform(0.0, 0.5), "gear": random.uniform(0.0, 1.0), "compliance": random.uniform(0.0, 0.12)}
        signal = machine.healthy(seconds, coloured=coloured, **parts)
        if truth != "healthy":
            signal = signal + 10.0 ** random.uniform(-1.1, 0.2) * machine.impacts(seconds, truth)
        diagnosis = diagnose_as_a_whole(signal, machine.rate, machine.speed, machine.orders, DetectorParameters())
        yield from said(diagnosis, truth, 3.0 if truth == "healthy" else 1.0)


def measured(folder: Path) -> Iterator[Said]:
    """Yield verdicts on measured recordings; envelope analysis cannot name ball faults, which are left out."""
    for recording in read_measured(folder):
        if recording.truth != "roller":
            for seconds in (1.0, 2.0, 60.0):
                yield from said(diagnose(recording, DetectorParameters(), seconds=seconds), recording.truth)


def table(verdicts: list[Said]) -> list[tuple[float, float, int]]:
    """Return mean confidence, share of right verdicts and their number for each interval of confidence that has any."""
    rows = []
    for low, high in itertools.pairwise(EDGES):
        inside = [verdict for verdict in verdicts if low <= verdict.confidence < high]
        if inside:
            weights = np.array([verdict.weight for verdict in inside])
            means = [float(np.average([getattr(verdict, name) for verdict in inside], weights=weights)) for name in ("confidence", "right")]
            rows.append((means[0], means[1], len(inside)))
    return rows


def main() -> None:
    """Print the tables and write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("measured", nargs="?", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    sets = {"generator": list(generated())}
    if options.measured is not None:
        sets["measured"] = list(measured(options.measured))
        sets["together"] = sets["generator"] + sets["measured"]
    import matplotlib as mpl

    mpl.use("agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.0, 4.5), layout="constrained")
    axes.plot([0.5, 1.0], [0.5, 1.0], "k:", label="right as often as said")
    for name, verdicts in sets.items():
        rows = table(verdicts)
        for confidence, right, count in rows:
            print(f"{name}: said with {confidence:.3f}, right {right:.3f} of {count}")
        axes.plot([row[0] for row in rows], [row[1] for row in rows], "o-", label=f"{name}, {len(verdicts)} verdicts")
    axes.set(xlabel="confidence [-]", ylabel="share of right verdicts [-]", xlim=(0.48, 1.02), ylim=(0.0, 1.05))
    axes.legend(loc="lower right")
    figure.savefig(options.output, dpi=110)


if __name__ == "__main__":
    main()
