"""A measured waveform as arrays: what a simulation returns, what a recording holds, what detectors and plots take."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar, runtime_checkable

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.fault_lines import UNKNOWN, BearingLike, orders_of
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.arguments import numbers
from dcrb_ros.schema.arrays import Floats, Integers, Samples
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    import pandas as pd

PIECE = 0.05
"""Longest piece that `Waveform.pieces` yields [s]: the shortest hop of a detector."""

Kind = TypeVar("Kind", bound="Waveform")


class Piece(NamedTuple):
    """Consecutive samples of a waveform."""

    first_index: int
    """Index of the first sample since the start; sample ``k`` is taken at ``k / sampling_rate``."""
    acceleration: Samples
    """Shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Shape (samples,) [rad]."""
    sensor_range: float
    """Range of the sensor [m/s^2]; 0 if unknown."""

    @property
    def end_index(self) -> int:
        """Index after the last sample."""
        return self.first_index + len(self.shaft_angle)


def stretch(rate: int, start: float | None, stop: float | None) -> tuple[float, float]:
    """Return the index of the first sample with ``start <= time`` and of the first with ``stop <= time``; infinite where not given.

    A time within rounding of a sample counts as the time of that sample, so that 1.1 s at 51200 Hz is sample 56320.

    Raises:
        Refusal: a time is not a finite number, or ``start`` is not below ``stop``.
    """
    begin = -math.inf if start is None else _index_at(finite_number("start =", start, "s"), rate)
    end = math.inf if stop is None else _index_at(finite_number("stop =", stop, "s"), rate)
    if start is not None and stop is not None and not start < stop:
        raise Refusal(f"start = {start:g} s is not below stop = {stop:g} s: give the earlier time first")
    return begin, end


def described_stretch(start: float | None, stop: float | None) -> str:
    """Return a stretch of time as text."""
    if start is None:
        return "at all" if stop is None else f"before {stop:g} s"
    return f"from {start:g} s on" if stop is None else f"from {start:g} to {stop:g} s"


def _index_at(time: float, rate: int) -> float:
    """Return the index of the first sample at or after a time [s]."""
    index = time * rate
    return float(round(index) if math.isclose(index, round(index), rel_tol=1e-12, abs_tol=1e-6) else math.ceil(index))


@runtime_checkable
class Signal(Protocol):
    """A waveform, or a recording that has one."""

    @property
    def sampling_rate(self) -> int:
        """Sampling rate [Hz]."""

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""

    def pieces(self) -> Iterator[Piece]:
        """Yield the samples in the order of time."""

    def waveform(self) -> Waveform:
        """Return all samples."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Waveform:
    """Acceleration of the outer ring and angle of the shaft, sample by sample.

    `dcrb_ros.simulate` and `Recording.waveform` return one; `Waveform.from_arrays` makes one of other data.
    """

    acceleration: Samples
    """Acceleration in X and Y, shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Rotation of the inner ring, wrapped to [0, 2 pi), shape (samples,) [rad]; NaN without a tacho."""
    sampling_rate: int
    """Sampling rate [Hz]."""
    index: Integers
    """Index of each sample since the start, shape (samples,); it jumps where samples were lost."""
    orders: Orders
    """Characteristic orders of the bearing; NaN where it is unknown."""
    sensor_range: float = 0.0
    """Range of the sensor [m/s^2]; 0 if unknown."""

    @staticmethod
    def from_arrays(
        acceleration: npt.ArrayLike, sampling_rate: float, *, bearing: BearingLike | None = None, shaft_angle: npt.ArrayLike | None = None
    ) -> Waveform:
        """Return the waveform of measured arrays.

        Parameters
        ----------
        acceleration
            Shape (samples, 2), or (samples,) for a single axis, which then serves as both [m/s^2].
        sampling_rate
            A whole number [Hz].
        bearing
            Geometry of the bearing (`dcrb_ros.Bearing`), a configuration or orders (`dcrb_ros.Orders`); without it no fault lines
            are known.
        shaft_angle
            Rotation of the inner ring, wrapped or not, shape (samples,) [rad]. Without it detectors estimate the speed from the signal.

        Raises
        ------
        Refusal
            Arrays of another shape or kind, or a sampling rate that is not a whole number of at least 1 Hz.

        Examples
        --------
        >>> import numpy as np
        >>> from dcrb_ros import Bearing, Waveform
        >>> noise = np.random.default_rng(1).standard_normal(25600)
        >>> Waveform.from_arrays(noise, 25600, bearing=Bearing(rollers_per_row=14))
        <Waveform: 1 s at 25.6 kHz (25600 samples), no shaft angle>
        """
        try:
            values = np.asarray(acceleration)
        except ValueError:
            raise Refusal("the acceleration has rows of different lengths: give an array of shape (samples, 2) or (samples,)") from None
        if np.ma.is_masked(acceleration):
            raise Refusal(
                "the acceleration has masked samples, which have no value: leave them out, and give the stretch before or after them"
            )
        columns = np.column_stack([values, values]) if values.ndim == 1 else values
        samples = len(columns) if columns.ndim else 0
        if shaft_angle is not None:
            numbers("shaft_angle", shaft_angle)
        angle = np.full(samples, np.nan) if shaft_angle is None else np.asarray(shaft_angle)
        if columns.shape != (samples, 2) or angle.shape != (samples,) or not samples:
            beside = "" if shaft_angle is None else f" with a shaft angle of shape {angle.shape}"
            angles = "" if shaft_angle is None else ", and a shaft angle of shape (samples,)"
            turned = values.ndim == 2 and values.shape[0] in (1, 2, 3) and values.shape[1] > values.shape[0]
            raise Refusal(
                f"acceleration of shape {values.shape}{beside} is not a waveform: give (samples, 2), or (samples,) for one axis{angles}, "
                f"with at least one sample{'; transpose the array and take two axes' if turned else ''}"
            )
        if not (np.isrealobj(columns) and np.issubdtype(columns.dtype, np.number) and np.issubdtype(angle.dtype, np.number)):
            raise Refusal(f"arrays of {columns.dtype} and {angle.dtype} are not a waveform: give real numbers in m/s^2 and rad")
        rate = finite_number("sampling_rate =", sampling_rate, "Hz")
        if not (rate >= 1.0 and rate.is_integer()):
            raise Refusal(f"sampling_rate = {sampling_rate!r} Hz is not a whole number of at least 1 Hz: resample the signal")
        return Waveform(
            acceleration=columns.astype(np.float32),
            shaft_angle=np.mod(angle, 2.0 * np.pi).astype(np.float32),
            sampling_rate=int(rate),
            index=np.arange(samples, dtype=np.int64),
            orders=UNKNOWN if bearing is None else orders_of(bearing),
        )

    def __len__(self) -> int:
        return len(self.index)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self._described()}>"

    def _described(self) -> str:
        """Return duration, rate and speed as text."""
        about = f"{self.duration:.4g} s at {self.sampling_rate / 1e3:g} kHz ({len(self)} samples)"
        lost = int(self.index[-1] - self.index[0]) + 1 - len(self) if len(self) else 0
        about += f", {lost} samples lost" if lost else ""
        return f"{about}, shaft at {self.shaft_frequency:.2f} Hz" if self.tracked else f"{about}, no shaft angle"

    @property
    def time(self) -> Floats:
        """Time of each sample since the start of the run, shape (samples,) [s]."""
        return self.index / float(self.sampling_rate)

    @property
    def duration(self) -> float:
        """Time from the first sample to the end of the last [s]."""
        return float(self.index[-1] - self.index[0] + 1) / self.sampling_rate if len(self) else 0.0

    @property
    def tracked(self) -> bool:
        """Whether every sample has a shaft angle."""
        return bool(len(self) and np.isfinite(self.shaft_angle).all())

    @property
    def turns(self) -> Floats:
        """Turns of the shaft since the first sample, signed, shape (samples,) [-]; meaningless across lost samples."""
        return np.unwrap(self.shaft_angle.astype(np.float64) - float(self.shaft_angle[0])) / (2.0 * np.pi)

    @property
    def shaft_frequency(self) -> float:
        """Mean frequency of the shaft [Hz], 0 for a single sample; NaN without a shaft angle."""
        steps = np.diff(self.shaft_angle.astype(np.float64))[np.diff(self.index) == 1] / (2.0 * np.pi)
        return float(abs(np.mean(steps - np.round(steps)))) * self.sampling_rate if len(steps) else 0.0

    def between(self: Kind, start: float | None = None, stop: float | None = None) -> Kind:
        """Return the samples with ``start <= time < stop`` [s].

        Raises
        ------
        Refusal
            There are none, or ``start`` is not below ``stop``.
        """
        first, last = stretch(self.sampling_rate, start, stop)
        begin, end = np.searchsorted(self.index, [first, last]).tolist()
        if begin >= end:
            about = f"it has samples from {self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "it is empty"
            raise Refusal(f"the waveform has no sample {described_stretch(start, stop)}: {about}")
        return self._cut(slice(begin, end))

    def _cut(self: Kind, samples: slice) -> Kind:
        return replace(self, acceleration=self.acceleration[samples], shaft_angle=self.shaft_angle[samples], index=self.index[samples])

    def pieces(self) -> Iterator[Piece]:
        """Yield pieces of at most 0.05 s, none of them across lost samples, as a detector takes them."""
        length = max(1, int(PIECE * self.sampling_rate))
        gaps = np.flatnonzero(np.diff(self.index) != 1) + 1
        for first, last in pairwise([0, *gaps.tolist(), len(self)]):
            for start in range(first, last, length):
                stop = min(start + length, last)
                yield Piece(int(self.index[start]), self.acceleration[start:stop], self.shaft_angle[start:stop], self.sensor_range)

    def waveform(self) -> Waveform:
        """Return itself, as `Recording.waveform` returns the waveform of a recording."""
        return self

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame over time [s] with the columns ax, ay [m/s^2] and shaft_angle [rad].

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        return pandas().DataFrame(self._columns(), index=pandas().Index(self.time, name="time"))

    def _columns(self) -> dict[str, npt.NDArray[Any]]:
        return {"ax": self.acceleration[:, 0], "ay": self.acceleration[:, 1], "shaft_angle": self.shaft_angle}


def signal_of(
    signal: Signal | npt.ArrayLike,
    sampling_rate: float | None = None,
    *,
    shaft_angle: npt.ArrayLike | None = None,
    bearing: BearingLike | None = None,
) -> Signal:
    """Return a run or a recording as it is, plain arrays as a `Waveform`.

    Raises:
        Refusal: arrays without a sampling rate, or a run or recording with arguments that it has itself.
    """
    if isinstance(signal, Signal):
        given = {"sampling_rate": sampling_rate, "shaft_angle": shaft_angle, "bearing": bearing}
        double = next((name for name, value in given.items() if value is not None), None)
        if double is not None:
            raise Refusal(f"{double} is given beside {signal!r}, which has its own: leave it out, or give plain arrays")
        return signal
    if isinstance(signal, (str, Path)):
        raise Refusal(f"{str(signal)!r} is a text, not a signal: use dcrb_ros.Recording({str(signal)!r}) for a recording")
    if sampling_rate is None:
        raise Refusal("sampling_rate is missing: give it in Hz with plain arrays")
    return Waveform.from_arrays(signal, sampling_rate, bearing=bearing, shaft_angle=shaft_angle)
