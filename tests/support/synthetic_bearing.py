"""Synthetic signals of a bearing, and the diagnoses of a detector."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector
from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.settings.parameters import Bearing

RATE = 51200
ORDERS = characteristic_orders(Bearing())
TURN = 2.0 * math.pi
Signal = tuple[Samples, Samples]


def bursts(turns: Floats, order: float, amplitude: float, *, modulation: Floats | None = None, rate: int = RATE) -> Floats:
    """Return impacts that ring at 7 kHz, ``order`` of them per revolution; ``modulation`` scales each of them."""
    samples = len(turns)
    if amplitude == 0.0:
        return np.zeros(samples)
    impacts = np.flatnonzero(np.diff(np.floor(turns * order)) != 0.0)
    pulses = np.zeros(samples)
    pulses[impacts] = amplitude if modulation is None else amplitude * modulation[impacts]
    time = np.arange(rate // 100) / rate
    ringing = np.exp(-time / 5e-4) * np.sin(TURN * min(7000.0, 0.3 * rate) * time)
    return np.convolve(pulses, ringing)[:samples]


def synthetic(
    *,
    outer: float = 0.0,
    inner: float = 0.0,
    roller: float = 0.0,
    cage: float = 0.0,
    frequency: float = 20.0,
    ramp: float = 0.0,
    seconds: float = 3.0,
    seed: int = 1,
    rate: int = RATE,
) -> Signal:
    """Return acceleration and shaft angle with impacts of given amplitudes [m/s^2] in noise of 1 m/s^2 and a tone at 300 Hz.

    A broken cage bar lets one roller strike as it passes the load line, which gives lines at k FTF. The cage is 0.2 % slower than the
    kinematic order, as in the simulation.
    """
    slip = 0.998
    time = np.arange(round(seconds * rate)) / rate
    turns = frequency * time + 0.5 * ramp * time**2
    noise = np.random.default_rng(seed).normal(size=(len(time), 2)) + 3.0 * np.sin(TURN * 300.0 * time)[:, None]
    ftf = ORDERS.ftf * slip
    bpfo = ORDERS.bpfo * slip
    in_load_zone, of_cage = (np.maximum(0.0, np.cos(TURN * phase)) ** 2 for phase in (turns, ftf * turns))
    excitation = bursts(turns, bpfo, outer, rate=rate)
    excitation = excitation + bursts(turns, ORDERS.bpfo + ORDERS.bpfi - bpfo, inner, modulation=in_load_zone, rate=rate)
    excitation = excitation + bursts(turns, 2.0 * ORDERS.bsf, roller, modulation=of_cage, rate=rate)
    excitation = excitation + bursts(turns, ftf, cage, rate=rate)
    acceleration = noise + np.column_stack([0.3 * excitation, excitation])
    return acceleration.astype(np.float32), np.mod(TURN * turns, TURN).astype(np.float32)


def diagnoses(
    detector: FaultDetector,
    data: Signal | tuple[Samples, None],
    *,
    block: int = 1024,
    first: int = 0,
    begins: Iterable[int] | None = None,
) -> list[Diagnosis]:
    """Return the diagnoses of a signal that is passed on in blocks: all of them, or those that begin at some samples, in that order."""
    acceleration, angle = data
    found = []
    for k in range(0, len(acceleration), block) if begins is None else begins:
        part = slice(k, k + block)
        found.append(detector.update(first + k, acceleration[part], None if angle is None else angle[part]))
    return [diagnosis for diagnosis in found if diagnosis is not None]
