"""Which of two boxes of a wheelset measures the impacts of a bearing first.

Sound needs at least 0.7 ms along the axle of 2 m from one box to the other, at 3000 m/s or less. Both boxes count the angle of one shaft,
and the phases of the lines in their squared envelopes are compared. The difference does not depend on gains or noise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.order_spectrum import hann
from dcrb_ros.schema.arrays import Complexes, Floats

LATEST = 3e-3
"""Largest difference that is searched [s]: resonances on the way delay the impacts further."""
STEP = 5e-5
"""Step of the search [s]."""
LEAST = 3e-4
"""Difference from which one box is earlier [s]: half of the time that sound needs."""
SLOWEST = 40.0
"""Frequency up to which lines are too slow [Hz]: at 40 Hz, `LEAST` is a phase of 4 degrees."""
AGREEMENT = 0.5
"""Share of the lines whose phases a difference must explain [-]."""


class TurnEnvelopes(NamedTuple):
    """Squared envelopes of the window over the angle of the shaft."""

    values: npt.NDArray[np.float32]
    """Shape (bands, bins) [unit^2]."""
    bins_per_turn: int
    begin: float
    """Angle at the begin of the first bin, from that of the shaft at the end of the window [turns]."""


def lead(own: TurnEnvelopes, other: TurnEnvelopes, orders: Floats, frequency: float) -> float:
    """Return by how much earlier the impacts with lines at ``orders`` [-] are in one box than in another one [s].

    ``frequency`` is that of the shaft [Hz]. It is 0 if no difference explains the phases, if the lines are too slow, as those of a cage
    are, or if the windows are not the same. After a gap or a late start of one box, the bins begin at different angles, and one
    window may have one bin more.
    """
    (bands, bins), (other_bands, other_bins) = own.values.shape, other.values.shape
    alike = bands == other_bands and abs(bins - other_bins) <= 1 and own.bins_per_turn == other.bins_per_turn
    if not alike or not frequency * float(orders.mean()) > SLOWEST:
        return 0.0
    cross = _lines(own, orders) * np.conj(_lines(other, orders))
    differences = np.arange(-LATEST, LATEST + 0.5 * STEP, STEP)
    rotated = np.exp(-2j * math.pi * frequency * np.outer(differences, orders)) @ cross.sum(axis=0)
    best = int(np.argmax(rotated.real))
    return float(differences[best]) if rotated.real[best] >= AGREEMENT * float(np.abs(cross).sum()) else 0.0


def _lines(envelopes: TurnEnvelopes, orders: Floats) -> Complexes:
    """Return the complex amplitudes of lines at ``orders`` [-], relative to the mean of each band, shape (bands, orders) [-]."""
    angles = envelopes.begin + np.arange(envelopes.values.shape[1]) / envelopes.bins_per_turn
    waves = np.exp(-2j * math.pi * np.outer(angles, orders))
    mean = np.maximum(envelopes.values.mean(axis=1, dtype=np.float64), 1e-30)
    relative = (envelopes.values / mean[:, None] - 1.0) * hann(len(waves))
    return np.asarray(relative @ waves, np.complex128)
