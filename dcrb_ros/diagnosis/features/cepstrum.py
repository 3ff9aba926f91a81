"""Peaks of the cepstrum of the signal over the angle of the shaft, at the periods of the faults.

The real cepstrum c = F^-1{ln |X|} gathers a family of equidistant lines in one peak at their common period (Randall 2017, "A history of
cepstrum analysis and its application to mechanical problems"). Over the angle of the shaft the period of a fault of order o is 1/o turns.
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.features.family import FAULTS, SLIP, FeatureFamily, Windows, fault_orders
from dcrb_ros.schema.arrays import Floats

NEIGHBOURHOOD = 0.15
"""Width of the quefrencies on either side, relative to the period, over which the noise of the cepstrum is taken [-]."""
HIGHEST = 20.0
"""Largest ratio of a peak to the noise [-]."""


def real_cepstrum(values: Floats) -> Floats:
    """Return the real cepstrum of each row, shape like ``values`` [-]."""
    spectrum = np.abs(np.fft.rfft(values * np.hanning(values.shape[-1] + 1)[:-1], axis=-1))
    floor = np.maximum(spectrum.max(axis=-1, keepdims=True) * 1e-9, np.finfo(np.float64).tiny)
    return np.fft.irfft(np.log(np.maximum(spectrum, floor)), values.shape[-1], axis=-1)


def compute(windows: Windows) -> Floats:
    """Return the largest value near the period of each fault over the standard deviation beside it, shape (windows, 4) [-]."""
    samples, peaks = windows.shape[1], np.zeros((windows.shape[0], len(FAULTS)))
    for k, (signal, turns) in enumerate(zip(windows.acceleration, windows.turns, strict=True)):
        even = np.interp(np.linspace(0.0, turns[-1], samples), turns, signal)
        cepstrum, per_turn = real_cepstrum(even), samples / float(turns[-1])
        for n, order in enumerate(fault_orders(windows.orders).values()):
            period = per_turn / order
            first, last = int(period * (1.0 - SLIP)), int(np.ceil(period * (1.0 + SLIP))) + 1
            beside = int(max(8.0, NEIGHBOURHOOD * period))
            if last + beside >= samples // 2:
                continue
            around = np.concatenate([cepstrum[max(1, first - beside) : first], cepstrum[last : last + beside]])
            peaks[k, n] = np.clip(cepstrum[first:last].max() / max(float(around.std()), 1e-12), 0.0, HIGHEST)
    return peaks


CEPSTRUM = FeatureFamily("cepstrum", lambda _: tuple(f"cepstrum_{fault}" for fault in FAULTS), compute)
