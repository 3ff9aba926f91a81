"""A loose cable: spikes of single samples that do not ring."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.order_spectrum import medians
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

BEFORE = 4
"""Samples before a spike that must be quiet."""
NO_PLACES = np.zeros(0, np.intp)


class SpikeParameters(Group):
    """Shape and number of spikes."""

    spike_height: float = quantity(
        25.0, "-", "Jump within one sample, relative to the median magnitude of the samples, that may be a spike", 5.0, 1e4
    )
    spike_quiet: float = quantity(0.12, "-", "Largest magnitude before a spike relative to its height; an impact has a rise", 0.0, 1.0)
    spike_front: float = quantity(0.9, "-", "Share of its height that a spike reaches within one sample; an impact takes several", 0.0, 1.0)
    spike_swing: float = quantity(
        0.15, "-", "Largest overshoot of a spike to the other side relative to its height; an impact rings", 0.0, 1.0
    )
    spike_time: float = quantity(0.001, "s", "Time within which an impact on the bearing overshoots and a spike does not", 1e-5, 0.1)
    most_spikes: int = quantity(3, "spikes", "Number of spikes in a window that indicates a loose cable", 1, 100000)


class Spikes(SampleRule[SpikeParameters]):
    """Spikes in the latest hops of a window."""

    parameters = SpikeParameters
    at_standstill = True

    def __init__(self, parameters: SpikeParameters) -> None:
        super().__init__(parameters)
        self._counts: list[Jumps] = []

    def restart(self) -> None:
        """Discard earlier hops."""
        self._counts = []

    def flaw(self, evidence: SampleEvidence) -> str:
        after = max(4, round(self.p.spike_time * evidence.rate))
        latest = count_jumps([column for _, column in evidence.axes], after, self.p)
        self._counts = [*self._counts, latest][-evidence.hops :]
        spikes, others = sum(jumps.spikes for jumps in self._counts), sum(jumps.others for jumps in self._counts)
        # Among the impacts of a defect a few look like spikes by chance; a loose plug makes nothing else.
        if spikes < self.p.most_spikes or others > spikes or not latest.spikes:
            return ""
        return f"{spikes} spikes without ringing in the window: a cable or its plug is loose"


class Jumps(NamedTuple):
    """Numbers of sudden changes."""

    spikes: int
    """Those that jump from quiet to their full height within one sample and do not swing back."""
    others: int
    """Others that are at least as high as the lowest spike."""


def count_jumps(columns: Sequence[Floats], after: int, p: SpikeParameters) -> Jumps:
    """Return the number of spikes, which do not swing back within ``after`` samples, and of other changes as sudden and as high.

    Those within ``after`` samples count once, in whichever axes: a loose cable disturbs all of them.
    """
    spikes, others = zip(*(find_jumps(column, after, p) for column in columns), strict=True)
    return Jumps(_separate(spikes, after), _separate(others, after))


def _separate(places: Iterable[npt.NDArray[np.intp]], after: int) -> int:
    """Return how many of the places in all axes are more than ``after`` samples behind the one before."""
    together = np.sort(np.concatenate(list(places)))
    return int(np.count_nonzero(np.diff(together) > after)) + bool(len(together))


def find_jumps(column: Floats, after: int, p: SpikeParameters) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the places of the spikes and of the other changes of an axis."""
    centred = column - medians(column)
    size, steps = np.abs(centred), np.abs(np.diff(centred))
    # If most samples are larger than this, so is their median, and no step is high enough: the median need not be computed.
    if 2 * np.count_nonzero(size > 1.001 * float(steps.max()) / p.spike_height) > len(column) + 1:
        return NO_PLACES, NO_PLACES
    least = p.spike_height * float(medians(size))
    jumps = np.flatnonzero(steps > least) + 1
    jumps = jumps[(jumps >= BEFORE) & (jumps < len(column) - after)]
    if not len(jumps) or least == 0.0:
        return NO_PLACES, NO_PLACES
    top = centred[jumps]
    before = np.abs(centred[jumps[:, None] - np.arange(1, BEFORE + 1)]).max(axis=1)
    course = np.sign(top)[:, None] * centred[jumps[:, None] + np.arange(after)]
    height, highest, swing = np.abs(top), course.max(axis=1), -course.min(axis=1)
    sharp = (before < p.spike_quiet * height) & (height > p.spike_front * highest) & (swing < p.spike_swing * height)
    sharp &= height > least
    if not sharp.any():
        return NO_PLACES, NO_PLACES
    spikes = jumps[sharp]
    # An impact may rise over several samples, and is as high all the same.
    as_high = np.flatnonzero(size >= height[sharp].min())
    first = as_high[np.concatenate([[True], np.diff(as_high) > after])]
    near = np.abs(first - spikes[np.clip(np.searchsorted(spikes, first), 0, len(spikes) - 1)]) <= after
    return spikes, first[~near]
