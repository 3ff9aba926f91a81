"""Comparisons of the lubricated benches with the aims of `docs/results/realism.md`: the ranges of measured bearings."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.validation.oiled_runs import OiledRun, OiledRuns
from dcrb_ros.validation.realism import Statistics, statistics
from dcrb_ros.validation.report_row import ReportRow, between

CHAPTER = "Realism"
HEALTHY_AIMS: dict[str, tuple[float, float, str]] = {
    "rms": (0.3, 3.0, "m/s^2"),
    "kurtosis": (2.5, 6.0, ""),
    "bpfo_depth": (0.0, 0.18, ""),
    "cage_depth": (0.0, 0.12, ""),
    "crest": (6.8, 9.6, "dB"),
}
SPALL_AIMS: dict[str, tuple[float, float, str]] = {
    "rms": (10.0, 60.0, "m/s^2"),
    "peak": (50.0, 500.0, "m/s^2"),
    "bpfo_depth": (0.47, 1.7, ""),
    "cage_depth": (0.008, 0.63, ""),
    "sidebands": (0.03, 1.03, ""),
    "wander": (1e-4, 3.5e-3, ""),
    "crest": (10.8, 30.1, "dB"),
}
"""The lines of the cage are weaker than those of measured bearings, 0.018 to 0.63: their lower limit is half of that."""
HARMONICS = 1.2, 20.0
"""Accepted depth of the first over the eighth harmonic of BPFO [-]."""
NAMES = {
    "rms": "RMS",
    "peak": "peak",
    "kurtosis": "kurtosis",
    "bpfo_depth": "depth of BPFO in the squared envelope",
    "cage_depth": "depth of the lines of the cage",
    "sidebands": "sidebands at the shaft frequency over BPFO",
    "wander": "wander of BPFO",
    "crest": "crest of the envelope",
}


def statistics_of(run: OiledRun) -> Statistics:
    """Return the statistics of the vertical acceleration at the sensor of a run."""
    configuration = run.configuration
    shaft = configuration.operating.speed / (2.0 * np.pi)
    return statistics(run.behind_box[:, 1], configuration.sensor.sampling_rate, shaft, characteristic_orders(configuration.bearing))


def realism_rows(runs: OiledRuns) -> Iterator[ReportRow]:
    """Yield the comparisons of a healthy bearing and of one with a spall with the aims."""
    for name, aims in (("healthy", HEALTHY_AIMS), ("spall", SPALL_AIMS)):
        values = statistics_of(runs[name])
        for field, (low, high, unit) in aims.items():
            yield between(CHAPTER, f"{name.capitalize()}: {NAMES[field]}", float(getattr(values, field)), low, high, unit)
        if name == "spall":
            yield between(CHAPTER, "Spall: first over eighth harmonic of BPFO", values.harmonics[0] / values.harmonics[1], *HARMONICS)
