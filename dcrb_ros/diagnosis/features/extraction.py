"""Features of a signal, window by window: of a whole signal at once, or block by block as a node receives it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.fault_lines import BearingLike
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.waveform import Signal, signal_of
from dcrb_ros.diagnosis.features.family import FeatureFamily, Windows
from dcrb_ros.diagnosis.features.registry import FAMILIES
from dcrb_ros.diagnosis.order_tracking import LEAST_TURNS, forward_turns, reverses, unwrapped_turns
from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.arguments import checked_arguments, number, numbers, of_type, optional, texts
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal, nearest

if TYPE_CHECKING:
    import pandas as pd

SHORTEST, LONGEST = 0.2, 60.0
"""Range of the length of a window [s]."""
AXES = ("x", "y")


@dataclass(frozen=True, eq=False, repr=False)
class FeatureTable:
    """Features of windows of a signal."""

    names: tuple[str, ...]
    """Name of each feature, such as ``y_wide_BPFO_depth``."""
    time: Floats
    """End of each window since the start of the run, shape (windows,) [s]."""
    values: Floats
    """Shape (windows, features); a window in which the shaft is at rest, turns back or turns too little has NaN."""

    def __repr__(self) -> str:
        return f"<FeatureTable: {len(self.time)} windows of {len(self.names)} features>"

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, name: str) -> Floats:
        """Return one feature, shape (windows,).

        Raises
        ------
        Refusal
            There is no feature of that name.
        """
        if not isinstance(name, str) or name not in self.names:
            raise Refusal(f"there is no feature '{name}'{nearest(str(name), self.names)}: table.names lists all {len(self.names)}")
        return np.asarray(self.values[:, self.names.index(name)], np.float64)

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame over time [s] with a column for each feature.

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        return pandas().DataFrame(self.values, columns=list(self.names), index=pandas().Index(self.time, name="time"))


class FeatureExtractor:
    """Computes features block by block, as a node or an online classifier does, with the same results as `extract_features`."""

    @checked_arguments(orders=of_type(Orders), sampling_rate=number, families=optional(texts), axes=texts)
    def __init__(
        self,
        orders: Orders,
        sampling_rate: int,
        *,
        window: float = 1.0,
        hop: float = 0.5,
        families: Sequence[str] | None = None,
        axes: Sequence[str] = AXES,
    ) -> None:
        """Prepare for blocks of a signal.

        Parameters
        ----------
        orders
            Characteristic orders of the bearing.
        sampling_rate
            Sampling rate [Hz].
        window, hop
            Length of a window, and time from one to the next [s].
        families
            Names of the families of features; all by default.
        axes
            ``x``, ``y`` or both.

        Raises
        ------
        Refusal
            Unknown orders, an unknown family or axis, or a window outside 0.2 .. 60 s.
        """
        if math.isnan(orders.bpfo):
            raise Refusal("the bearing is unknown: give its geometry or its orders as bearing")
        if not 0.0 < sampling_rate < math.inf:
            raise Refusal(f"sampling_rate = {sampling_rate:g} Hz is not a finite number above 0: give that of the signal")
        length = finite_number("window =", window, "s")
        if not SHORTEST <= length <= LONGEST:
            raise Refusal(f"window = {length:g} s is outside {SHORTEST:g} .. {LONGEST:g} s")
        step = finite_number("hop =", hop, "s")
        if not 1.0 / sampling_rate <= step <= length:
            raise Refusal(f"hop = {step:g} s is outside {1.0 / sampling_rate:g} .. {length:g} s, the length of the window")
        self._families, self._axes = _chosen(families), _checked_axes(axes)
        self._orders, self._rate = orders, sampling_rate
        self._samples, self._hop = round(length * sampling_rate), max(1, round(step * sampling_rate))
        self.names = tuple(f"{axis}_{name}" for axis in self._axes for family in self._families for name in family.names(sampling_rate))
        self._next: int | None = None
        self._acceleration, self._angle = np.zeros((0, 2)), np.zeros(0)

    @checked_arguments(index=number, acceleration=numbers, shaft_angle=numbers)
    def update(self, index: int, acceleration: npt.ArrayLike, shaft_angle: npt.ArrayLike) -> FeatureTable:
        """Take a block that begins at sample ``index``, shapes (samples, 2) and (samples,); return the windows that end in it.

        Where samples were lost, a new window begins.
        """
        block, angle = np.asarray(acceleration, np.float64), np.asarray(shaft_angle, np.float64)
        if block.ndim != 2 or block.shape[1] != len(AXES) or angle.shape != block.shape[:1]:
            raise Refusal(f"a block of shapes {block.shape} and {angle.shape} does not fit: give (samples, 2) and (samples,)")
        if index != self._next:
            self._acceleration, self._angle = np.zeros((0, 2)), np.zeros(0)
        self._next = index + len(angle)
        self._acceleration = np.concatenate([self._acceleration, block])
        self._angle = np.concatenate([self._angle, angle])
        count = max(0, (len(self._angle) - self._samples) // self._hop + 1)
        begins = np.arange(count) * self._hop
        first = self._next - len(self._angle)
        ends = (first + begins + self._samples) / self._rate
        values = [self._row(self._acceleration[k : k + self._samples], self._angle[k : k + self._samples]) for k in begins]
        self._acceleration, self._angle = self._acceleration[count * self._hop :], self._angle[count * self._hop :]
        return FeatureTable(self.names, ends, np.array(values).reshape(count, len(self.names)))

    def _row(self, acceleration: Floats, angle: Floats) -> Floats:
        """Return the features of one window, NaN where its shaft does not turn as it must."""
        turns = unwrapped_turns(angle) if np.isfinite(angle).all() else np.zeros(len(angle))
        sound = np.isfinite(acceleration).all() and abs(turns[-1]) >= LEAST_TURNS and not reverses(turns)
        if not sound:
            return np.full(len(self.names), np.nan)
        columns = acceleration[:, [AXES.index(axis) for axis in self._axes]].T
        windows = Windows(
            columns - columns.mean(axis=1, keepdims=True), np.broadcast_to(forward_turns(turns), columns.shape), self._rate, self._orders
        )
        return np.concatenate([family.compute(windows) for family in self._families], axis=1).ravel()


def extract_features(
    signal: Signal | npt.ArrayLike,
    sampling_rate: float | None = None,
    *,
    shaft_angle: npt.ArrayLike | None = None,
    bearing: BearingLike | None = None,
    window: float = 1.0,
    hop: float = 0.5,
    families: Sequence[str] | None = None,
    axes: Sequence[str] = AXES,
) -> FeatureTable:
    """Return the features of a signal, window by window.

    The families are ``statistics``, ``band_levels``, ``kurtogram``, ``envelope_lines``, ``cepstrum`` and ``spectral_coherence``.

    Parameters
    ----------
    signal
        A `SimulationResult`, `Recording` or `Waveform`, or accelerations of shape (samples, 2) or (samples,) [m/s^2].
    sampling_rate
        Sampling rate of plain arrays [Hz].
    shaft_angle
        Rotation of the inner ring beside plain arrays, shape (samples,) [rad].
    bearing
        Geometry or orders of the bearing beside plain arrays.
    window, hop
        Length of a window, and time from one to the next [s].
    families
        Names of the families; all by default.
    axes
        ``x``, ``y`` or both; the names of the features begin with the axis.

    Returns
    -------
    FeatureTable
        Names, end of each window [s] and values, shape (windows, features).

    Raises
    ------
    Refusal
        An unknown bearing, family or axis, a window outside 0.2 .. 60 s, a signal without a shaft angle or shorter than a window.

    Examples
    --------
    >>> import dcrb_ros
    >>> run = dcrb_ros.simulate("healthy", 2.0)
    >>> table = dcrb_ros.extract_features(run, families=["statistics"], axes=["y"])
    >>> table
    <FeatureTable: 3 windows of 5 features>
    >>> table.names[0]
    'y_rms'
    """
    source = signal_of(signal, sampling_rate, shaft_angle=shaft_angle, bearing=bearing)
    extractor = FeatureExtractor(source.orders, source.sampling_rate, window=window, hop=hop, families=families, axes=axes)
    tables, tracked, seconds = [], False, 0.0
    for piece in source.pieces():
        tables.append(extractor.update(piece.first_index, piece.acceleration[:, :2], piece.shaft_angle))
        tracked |= bool(np.isfinite(piece.shaft_angle).any())
        seconds += len(piece.shaft_angle) / source.sampling_rate
    if not tracked:
        raise Refusal("the signal has no shaft angle, over which the features are taken: give shaft_angle in rad")
    table = FeatureTable(extractor.names, np.concatenate([part.time for part in tables]), np.concatenate([part.values for part in tables]))
    if not len(table):
        raise Refusal(f"{seconds:.3g} s without a window of {window:g} s: give a longer signal or a shorter window")
    return table


def _chosen(names: Sequence[str] | None) -> tuple[FeatureFamily, ...]:
    known = {family.name: family for family in FAMILIES}
    if names is None:
        return FAMILIES
    wanted = [names] if isinstance(names, str) else list(names)
    unknown = next((name for name in wanted if name not in known), None)
    if unknown is not None or not wanted:
        raise Refusal(f"there is no family of features '{unknown or ''}'{nearest(str(unknown), known)}: known are {', '.join(known)}")
    return tuple(family for family in FAMILIES if family.name in wanted)


def _checked_axes(axes: Sequence[str]) -> tuple[str, ...]:
    chosen = tuple(axes)
    if not chosen or any(axis not in AXES for axis in chosen) or len(set(chosen)) < len(chosen):
        raise Refusal(f"axes = {chosen!r} are not axes of the sensor: give x, y or both")
    return chosen
