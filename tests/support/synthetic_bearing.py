"""A synthetic bearing and the detector fed with it."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.kinematics import characteristic_orders
from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector
from dcrb_ros.settings.parameters import Bearing

RATE = 51200


ORDERS = characteristic_orders(Bearing())


TURN = 2.0 * math.pi


Floats = npt.NDArray[np.float64]


Stream = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]


def bursts(turns: Floats, order: float, amplitude: float, *, seen: Floats | None = None, rate: int = RATE) -> Floats:
    """Return ringing at 7 kHz struck ``order`` times a turn; ``seen`` scales each strike."""
    samples = len(turns)
    strikes = np.flatnonzero(np.diff(np.floor(turns * order)) != 0.0)
    comb = np.zeros(samples)
    comb[strikes] = amplitude if seen is None else amplitude * seen[strikes]
    time = np.arange(rate // 100) / rate
    ringing = np.exp(-time / 5e-4) * np.sin(TURN * min(7000.0, 0.3 * rate) * time)
    return np.convolve(comb, ringing)[:samples]


def stream(
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
) -> Stream:
    """Return a synthetic bearing: strikes of given amplitudes [m/s^2] in noise of 1 m/s^2 and a rolling sound of 300 Hz.

    A missing bar lets one roller strike as it passes the load line, which is a comb at every k FTF. The cage runs 0.2 % behind the
    kinematic order, as on the simulated bench.
    """
    slip = 0.998
    time = np.arange(round(seconds * rate)) / rate
    turns = frequency * time + 0.5 * ramp * time**2
    noise = np.random.default_rng(seed).normal(size=(len(time), 2)) + 3.0 * np.sin(TURN * 300.0 * time)[:, None]
    ftf = ORDERS.ftf * slip
    bpfo = ORDERS.bpfo * slip
    loaded, carried = (np.maximum(0.0, np.cos(TURN * phase)) ** 2 for phase in (turns, ftf * turns))
    struck = bursts(turns, bpfo, outer, rate=rate)
    struck = struck + bursts(turns, ORDERS.bpfo + ORDERS.bpfi - bpfo, inner, seen=loaded, rate=rate)
    struck = struck + bursts(turns, 2.0 * ORDERS.bsf, roller, seen=carried, rate=rate)
    struck = struck + bursts(turns, ftf, cage, rate=rate)
    acceleration = noise + np.column_stack([0.3 * struck, struck])
    return acceleration.astype(np.float32), np.mod(TURN * turns, TURN).astype(np.float32)


def watch(detector: FaultDetector, data: Stream, *, block: int = 1024, first: int = 0) -> list[Diagnosis]:
    """Feed a stream in blocks and return the diagnoses."""
    acceleration, angle = data
    found = [detector.update(first + k, acceleration[k : k + block], angle[k : k + block]) for k in range(0, len(angle), block)]
    return [diagnosis for diagnosis in found if diagnosis is not None]
