"""Fault lines in the order-tracked squared envelope spectrum, of a wide band and of the most impulsive one.

Randall and Antoni 2011, "Rolling element bearing diagnostics - A tutorial". The squared envelope is resampled over the angle of the shaft,
and each family of lines is searched within 2 % of its kinematic order, as the fault detector does (`dcrb_ros.diagnosis.line_search`).
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.demodulation import Band, Demodulator
from dcrb_ros.diagnosis.features.family import FAULTS, SLIP, FeatureFamily, Windows, fault_orders
from dcrb_ros.diagnosis.features.kurtogram import ImpulsiveBand, impulsive_band
from dcrb_ros.diagnosis.line_search import Comb, LineSearch
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, order_spectra
from dcrb_ros.diagnosis.order_tracking import bin_edges, bin_means
from dcrb_ros.schema.arrays import Floats

WIDE = (0.04, 0.4)
"""Edges of the wide band over the sampling rate [-]: 2 to 20 kHz at 51.2 kHz."""
BANDS = ("wide", "impulsive")
SHAFT = "1x"
"""Modulation at the shaft frequency, from an inner ring that turns through the load zone."""
LEAST = np.finfo(np.float64).tiny
MOST = 300.0
"""Largest significance [-]."""
BINS = 128
"""Bins per turn: lines up to 64 orders."""


def names(rate: int) -> tuple[str, ...]:
    """Return the names of the features, such as ``wide_BPFO_depth``."""
    return tuple(f"{band}_{line}_{kind}" for band in BANDS for line in (*FAULTS, SHAFT) for kind in ("depth", "significance"))


def envelope_order_spectrum(signal: Floats, turns: Floats, rate: int, low: float, high: float) -> OrderSpectrum:
    """Return the squared envelope spectrum over orders of one window in the band from ``low`` to ``high`` [Hz]."""
    ((positions, squared),) = Demodulator((Band(low, high),), rate, len(signal)).squared_envelopes(signal[:, None])
    edges = np.interp(bin_edges(0.0, float(turns[-1]), BINS), turns, np.arange(len(turns), dtype=np.float64))
    binned = bin_means(positions, squared, edges)
    return order_spectra(binned[None, :], np.zeros(len(binned), np.bool_), BINS)[0]


def compute(windows: Windows) -> Floats:
    """Return modulation depth [-] and significance, -lg of the probability in noise [-], of each family, shape (windows, 20)."""
    impulsive = windows.shared.get("impulsive_band")
    if not isinstance(impulsive, ImpulsiveBand):
        impulsive = impulsive_band(windows.acceleration, windows.rate)
    combs = [Comb(order) for order in fault_orders(windows.orders).values()]
    rows = []
    for k, (signal, turns) in enumerate(zip(windows.acceleration, windows.turns, strict=True)):
        row: list[float] = []
        edges = ((WIDE[0] * windows.rate, WIDE[1] * windows.rate), (max(1.0, float(impulsive.low[k])), float(impulsive.high[k])))
        if edges[1][1] <= edges[1][0]:  # a constant has no impulsive band
            edges = (edges[0], edges[0])
        for low, high in edges:
            spectrum = envelope_order_spectrum(signal, turns, windows.rate, low, high)
            search = LineSearch(spectrum)
            for comb in combs:
                family = search.best(comb, SLIP)
                row += [family.depth, max(family.significance, 0.0)]
            shaft = float(spectrum.lines(np.array([1.0]))[0]) / max(spectrum.mean, LEAST)
            noise = float(search.local_mean[0, min(len(search.orders) - 1, round(1.0 / search.step))])
            row += [shaft, min(shaft**2 / max(noise, LEAST) / np.log(10.0), MOST)]
        rows.append(row)
    return np.array(rows).reshape(windows.shape[0], -1)


ENVELOPE_LINES = FeatureFamily("envelope_lines", names, compute)
