"""Runs at the ring in the noise of the machine, with an arbitrary share of the bearing.

Each simulated machine gets Gaussian noise with the spectrum of the healthy recording, and its bearing a share of the power from 1 to 100 %.
"""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

import numpy as np
from scipy import signal
from sim_to_real_data import Measured, Windows, features, runs_of

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
    random, parts = np.random.default_rng(seed), []
    by_condition = groupby(sorted(runs_of(folder), key=lambda run: run.name), key=lambda run: run.name)
    for condition, group in by_condition:
        runs, share, recording = list(group), 10.0 ** random.uniform(*SHARES), healthy[random.integers(len(healthy))]
        gain = recording.values.std() / next(run.values.std() for run in runs if run.truth == "healthy")
        for run in runs:
            noise = surrogate(recording.values, len(run.values), run.rate, random)
            mixed = np.sqrt(share) * gain * run.values + np.sqrt(1.0 - share) * noise
            parts.append((features(mixed - mixed.mean(), run.rate, run.angle, run.orders), run.truth, condition))
    return Windows.of(parts)
