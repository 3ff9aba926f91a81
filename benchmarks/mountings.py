"""How much the spectra of the bearings of a rig differ, measured and in the replica, as a table in Markdown.

``python benchmarks/mountings.py MEASURED EXAM RECORDINGS`` compares all pairs of recordings of healthy bearings and ring defects of one
machine. RECORDINGS is a folder that keeps those of the replica EXAM; missing ones are simulated.

A spectrum is the power density over `LINES` lines, 100 Hz, in decibels, from 500 Hz to 0.42 of the sampling rate; recordings of 40 kHz and
above are decimated by four. The difference of two is its standard deviation, so that gains do not count. Their correlation is that of the
spectra minus means over `TREND` lines, 0.95 kHz, on the scale of single modes.
"""

from __future__ import annotations

import argparse
import itertools
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import signal

from dcrb_ros.exam.evaluation import no_progress
from dcrb_ros.exam.exam_file import MACHINE_TAG, read_exam
from dcrb_ros.exam.measured import read_table
from dcrb_ros.exam.predictivity_task import Task, measured_tasks, simulate_missing, simulated_tasks
from dcrb_ros.runtime.processes import cores
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.text.markdown import table

SECONDS = 3.0
"""Longest part of a recording [s]."""
LOWEST, HIGHEST_SHARE = 500.0, 0.42
"""Band [Hz, of the sampling rate]: above the harmonics of the shaft, and below the anti-alias filters of the recorders."""
SEGMENT, LINES, TREND = 1024, 9, 81
"""Samples of a window of Welch's method; lines over which spectra are averaged, and over which their trend is taken [-]."""


class Spectrum(NamedTuple):
    """The spectrum of a recording."""

    rig: str
    machine: str
    bearing: str
    truth: str
    level: Floats
    """Power density in the lines of the band [dB]."""


def smoothed(level: Floats, lines: int) -> Floats:
    """Return means over an odd number of lines."""
    return np.convolve(np.pad(level, lines // 2, "edge"), np.full(lines, 1.0 / lines), "valid")


def spectrum_of(task: Task[Any], machine: str) -> Spectrum:
    """Return the spectrum of a task's recording."""
    original, one = task.original, task.signal.recording
    samples, factor = one.samples()[: round(SECONDS * one.rate)], 4 if one.rate >= 40000 else 1
    rate = one.rate / factor
    frequency, density = signal.welch(signal.decimate(samples, factor) if factor > 1 else samples, rate, nperseg=SEGMENT)
    band = (frequency > LOWEST) & (frequency < HIGHEST_SHARE * rate)
    return Spectrum(original.rig, machine, original.bearing, original.truth, 10.0 * np.log10(np.asarray(density)[band]))


def pairs(spectra: Sequence[Spectrum]) -> Iterator[tuple[tuple[str, str], float, float]]:
    """Yield rig and kind of each pair of recordings of a machine, their difference [dB] and their correlation [-]."""
    for first, second in itertools.combinations(spectra, 2):
        if (first.rig, first.machine) != (second.rig, second.machine):
            continue
        kind = "one bearing" if first.bearing == second.bearing else "two bearings"
        if (first.truth == "healthy") != (second.truth == "healthy"):
            kind = "healthy and faulty bearing"
        fine = [smoothed(spectrum.level, LINES) - smoothed(spectrum.level, TREND) for spectrum in (first, second)]
        yield (first.rig, kind), float(smoothed(first.level - second.level, LINES).std()), float(np.asarray(np.corrcoef(fine))[0, 1])


def medians(spectra: Sequence[Spectrum]) -> dict[tuple[str, str], str]:
    """Return the median difference and correlation by rig and kind of pair."""
    by_kind = defaultdict(list)
    for key, *values in pairs(spectra):
        by_kind[key].append(values)
    return {key: "{:.1f} dB, {:.2f}".format(*np.median(values, axis=0)) for key, values in by_kind.items()}


def main() -> None:
    """Compare all recordings and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", type=Path)
    parser.add_argument("exam")
    parser.add_argument("recordings", type=Path)
    given = parser.parse_args()
    known = read_table(given.measured / "recordings.csv", "lines")
    field = measured_tasks(known, SECONDS)
    simulated = simulated_tasks(read_exam(given.exam), known, given.recordings)
    simulate_missing(simulated, cores(), no_progress("", 0))
    both = (
        medians([spectrum_of(task, task.original.machine) for task in field]),
        medians([spectrum_of(task, str(task.signal.recording.tags[MACHINE_TAG])) for task in simulated]),
    )
    rows = [(*key, *(values.get(key, "") for values in both)) for key in sorted(set(both[0]) | set(both[1]))]
    print(table(("rig", "recordings", "measured", "replica"), rows))


if __name__ == "__main__":
    main()
