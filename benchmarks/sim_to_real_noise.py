"""Runs at the ring in the noise of the machine, with an arbitrary share of the bearing.

Each simulated machine gets Gaussian noise with the spectrum of the healthy recording, and its bearing a share of the power from 1 to 100 %.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy import signal
from sim_to_real_data import Measured, Windows, features

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.schema.arrays import Floats

SHARES = (-2.0, 0.0)
"""Range of the decimal logarithm of the bearing's share of the healthy power [-]."""
SEGMENT = 8192


def surrogate(healthy: Floats, count: int, rate: int, random: np.random.Generator) -> Floats:
    """Return Gaussian noise with the spectrum of a recording, shape (count,)."""
    frequency, density = signal.welch(healthy, rate, nperseg=SEGMENT)
    gain = np.sqrt(np.interp(np.fft.rfftfreq(count, 1.0 / rate), frequency, density) * 0.5 * rate)
    return np.asarray(np.fft.irfft(np.fft.rfft(random.standard_normal(count)) * gain, count))


def noisy_windows(folder: Path, healthy: list[Measured], seed: int = 1) -> Windows:
    """Return the windows of a data set in the noise of a machine; all runs of a simulated machine have the same noise level and gain."""
    table, random, parts = pd.read_parquet(folder / "labels.parquet"), np.random.default_rng(seed), []
    table = table[table["status"] == "done"]
    for condition, runs in table.groupby("condition", sort=True):
        share, one = 10.0 ** random.uniform(*SHARES), healthy[random.integers(len(healthy))]
        with np.load(folder / runs[runs["fault"] == "healthy"]["file"].iloc[0]) as content:
            gain = one.values.std() / content["ay"].astype(np.float64).std()
        for _, row in runs.iterrows():
            with np.load(folder / row["file"]) as content:
                values, angle, rate = content["ay"].astype(np.float64), content["shaft_angle"], int(content["sampling_rate"])
            mixed = np.sqrt(share) * gain * values + np.sqrt(1.0 - share) * surrogate(one.values, len(values), rate, random)
            shaft = abs(row["speed"]) / (2.0 * np.pi)
            orders = Orders(*(float(row[name]) / shaft for name in ("ftf", "bpfo", "bpfi", "bsf")))
            parts.append((features(mixed - mixed.mean(), rate, np.unwrap(angle), orders), str(row["fault"]), str(condition)))
    return Windows.of(parts)
