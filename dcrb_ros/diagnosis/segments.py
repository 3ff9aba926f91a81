"""From blocks as they arrive to overlapping segments without gaps; repeated, late, lost and non-finite samples are handled and counted."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.order_tracking import unwrapped_turns
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.axes import AXES

RESTARTED = 3
"""Late blocks in a row that are a restart of the signal even if samples between them were lost [-]."""


class Segment(NamedTuple):
    """A hop of the signal with a margin on either side that overlaps its neighbours."""

    last: int
    """Index of its last sample."""
    acceleration: Floats
    """Shape (samples, axes), zero where missing [m/s^2]."""
    turns: Floats | None
    """Signed turns of the shaft since the first sample; None without a shaft angle."""
    missing: npt.NDArray[np.bool_]
    """Samples that were lost or are not finite."""
    not_finite: int
    """Samples of the hop that arrived but are not finite."""
    first: bool
    """Whether it is the first after the start or after a gap that was not bridged."""


class HeldSamples(NamedTuple):
    """Samples that do not fill a segment yet; NaN if they are missing, infinite if they arrived but were not finite."""

    acceleration: npt.NDArray[Any]
    angle: npt.NDArray[Any]


@dataclass
class Counts:
    """Irregularities of the signal so far."""

    gaps: int = 0
    """Gaps."""
    lost: int = 0
    """Samples that did not arrive."""
    repeated: int = 0
    """Samples that arrived twice or too late, and were ignored."""
    not_finite: int = 0
    """Samples that are not finite."""
    restarts: int = 0
    """Restarts of the signal."""


class Segmenter:
    """Cuts blocks into segments; the memory is bounded by one segment and the longest gap that is bridged."""

    def __init__(self, hop: int, margin: int, longest_gap: int) -> None:
        """Cut segments of ``hop`` samples plus twice the ``margin``; bridge gaps of up to ``longest_gap`` samples."""
        self.hop, self.margin, self._longest_gap = hop, margin, longest_gap
        self._origin: int | None = None
        self.counts = Counts()
        self._next: int | None = None
        self._late: range | None = None
        """Samples of the latest block, if its first ones are late."""
        self._rising = 0
        """Late blocks in a row, each with later samples than the one before."""
        self._axes = 0
        """Axes of the signal [-], 0 before the first block."""

    def align(self, origin: int) -> None:
        """Begin the hops of a signal that has not begun at whole hops from the sample ``origin``, not at the first sample."""
        self._origin = origin

    def _restart(self, index: int) -> None:
        """Discard the samples before ``index``; those before the first segment count as missing."""
        self._begin = index if self._origin is None else index + (self._origin - index) % self.hop
        self._pieces: list[HeldSamples] = []
        self._held = 0
        self._first = True
        self._append(_nothing(2 * self.margin, self._axes), counted=False)

    def add(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any] | None) -> Iterator[Segment]:
        """Take the block that begins with sample ``index``; yield the segments that it completes.

        ``acceleration`` has shape (samples, axes) [m/s^2], ``shaft_angle`` (samples,) [rad] or None without a tachometer.

        Raises:
            Refusal: arrays of another shape or type, or another number of axes than in the first block.
        """
        angle = np.full(acceleration.shape[:1], np.nan, np.float32) if shaft_angle is None else np.asanyarray(shaft_angle)
        _check(acceleration, angle, self._axes)
        samples = len(acceleration)
        if not samples:
            return
        if not self._axes:
            self._axes = acceleration.shape[1]
            self._restart(index)
        known = self._continued(index, samples)
        if known < samples:
            # Hop by hop: each segment copies all samples that are held.
            for first in range(max(known, self._begin - index), samples, self.hop):
                part = slice(first, first + self.hop)
                self._append(HeldSamples(acceleration[part], angle[part]), counted=True)
                self._next = index + min(first + self.hop, samples)
                while self._held >= self.hop + 2 * self.margin:
                    yield self._cut()
            self._next = index + samples

    def _continued(self, index: int, samples: int) -> int:
        """Bridge a gap before ``index``; return how many samples of the block are known already."""
        if self._next is None or index >= self._next:
            if self._next is not None and index > self._next:
                self._bridge(index, index - self._next)
            self._late = None
            return 0
        late, self._late = self._late, range(index, index + samples)
        self._rising = self._rising + 1 if late is not None and late.start < index else 1
        consecutive = late is not None and late.stop == index
        # Blocks may overtake each other, but not by this much: the source has restarted.
        if (consecutive or self._rising >= RESTARTED) and self._next - index > self.hop + self._longest_gap:
            self.counts.restarts += 1
            self._late = None
            self._restart(index)
            return 0
        known = min(samples, self._next - index)
        self.counts.repeated += known
        return known

    def _bridge(self, index: int, lost: int) -> None:
        self.counts.gaps += 1
        self.counts.lost += lost
        if lost > self._longest_gap:
            self._restart(index)
            return
        self._append(_nothing(min(lost, max(0, index - self._begin)), self._axes), counted=False)

    def _append(self, piece: HeldSamples, *, counted: bool) -> None:
        acceleration = piece.acceleration.astype(np.float32)
        if counted and not (known := _known(acceleration)).all():
            self.counts.not_finite += int(np.count_nonzero(~known))
            acceleration[~known] = np.inf
        self._pieces.append(HeldSamples(acceleration, _wrapped(piece.angle)))
        self._held += len(piece.angle)

    def _cut(self) -> Segment:
        acceleration, angle = (np.concatenate(arrays) for arrays in zip(*self._pieces, strict=True))
        length = self.hop + 2 * self.margin
        last = (self._next or 0) - (self._held - length) - 1
        self._pieces, self._held = [HeldSamples(acceleration[self.hop :], angle[self.hop :])], self._held - self.hop
        missing = ~_known(acceleration[:length])
        not_finite = int(np.count_nonzero(np.isinf(acceleration[self.margin : self.margin + self.hop, 0])))
        known = acceleration[:length].astype(np.float64)
        if missing.any():
            known[missing] = 0.0
        segment = Segment(last, known, bridged_turns(angle[:length]), missing, not_finite, self._first)
        self._first = False
        return segment


def _known(acceleration: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Return which samples are finite in all axes, shape (samples,); `numpy.all` along rows of two takes fifty times as long."""
    return np.asarray(functools.reduce(np.logical_and, np.isfinite(acceleration).T))


def _wrapped(angle: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Return angles in single precision [rad]; those beyond two turns, which it resolves ever less, within one turn."""
    beyond = np.abs(angle) > 4.0 * math.pi
    if beyond.any():
        with np.errstate(invalid="ignore"):  # of an infinite angle
            angle = np.where(beyond, np.mod(angle, np.float64(2.0 * math.pi)), angle)
    return angle.astype(np.float32)


def _nothing(samples: int, axes: int) -> HeldSamples:
    return HeldSamples(np.full((samples, axes), np.nan, np.float32), np.full(samples, np.nan, np.float32))


def bridged_turns(angle: npt.NDArray[Any]) -> Floats | None:
    """Return the turns of the shaft, interpolated over missing angles; None if too many are missing.

    Wrapped angles leave the number of whole turns within a gap open; the number nearest to the median speed is used.
    """
    finite = np.isfinite(angle)
    if len(angle) > 1 and finite.all():
        return unwrapped_turns(angle)
    known = np.flatnonzero(finite)
    if len(known) < max(2, len(angle) // 2):
        return None
    turns = unwrapped_turns(angle[known])
    steps = np.diff(known)
    ordinary = steps == 1
    speed = float(np.median(np.diff(turns)[ordinary])) if ordinary.any() else 0.0
    wide = np.where(ordinary, 0.0, np.round(speed * steps - np.diff(turns)))
    turns = turns + np.concatenate([[0.0], np.cumsum(wide)])
    indices = np.arange(len(angle), dtype=np.float64)
    bridged = np.interp(indices, known, turns)
    before, after = indices < known[0], indices > known[-1]
    bridged[before] = turns[0] + speed * (indices[before] - known[0])
    bridged[after] = turns[-1] + speed * (indices[after] - known[-1])
    return np.asarray(bridged - bridged[0], np.float64)


def _check(acceleration: npt.NDArray[Any], angle: npt.NDArray[Any], axes: int) -> None:
    """Refuse arrays of another shape or type, or of another number of ``axes`` than known, 0 for any."""
    allowed = (axes,) if axes else range(1, len(AXES) + 1)
    if acceleration.ndim != 2 or acceleration.shape[1] not in allowed or angle.shape != acceleration.shape[:1]:
        raise Refusal(
            f"a block with acceleration {acceleration.shape} and shaft_angle {angle.shape} is refused: "
            f"they must be (samples, {axes or 2}) and (samples,){'' if axes else ', with one to three axes'}; "
            "the detector continues with the next block"
        )
    if np.ma.is_masked(acceleration) or np.ma.is_masked(angle):
        raise Refusal("a block with masked values is refused: replace them by NaN; the detector continues with the next block")
    if acceleration.dtype.kind not in "iuf" or angle.dtype.kind not in "iuf":
        raise Refusal(
            f"a block of {acceleration.dtype} and {angle.dtype} is refused: accelerations [m/s^2] and angles [rad] must be real numbers; "
            "the detector continues with the next block"
        )
