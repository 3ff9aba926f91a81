"""The waveform over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.waveform import Signal, signal_of
from dcrb_ros.plots.style import AXES_COLOURS, MATPLOTLIB_AXES, labelled, legend_above, new_axes
from dcrb_ros.schema.arguments import checked_arguments
from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_BUNDLES = 4_000
"""Bundles of samples into which a long waveform is drawn: a few for each pixel."""


@checked_arguments(ax=MATPLOTLIB_AXES)
def plot_waveform(
    signal: Signal | npt.ArrayLike,
    sampling_rate: float | None = None,
    *,
    start: float | None = None,
    stop: float | None = None,
    axis: Literal["x", "y", "both"] = "y",
    ax: Axes | None = None,
) -> Axes:
    """Plot the acceleration of the outer ring over time.

    Parameters
    ----------
    signal
        A `SimulationResult`, `Recording` or `Waveform`, or accelerations of shape (samples, 2) or (samples,) [m/s^2].
    sampling_rate
        Sampling rate of plain arrays [Hz].
    start, stop
        Stretch to show, everything by default [s].
    axis
        Direction of the sensor: ``"y"`` along the load, ``"x"`` across it, or ``"both"``.
    ax
        Axes to draw into; those of a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    Refusal
        No sample between start and stop, or an unknown axis.

    Examples
    --------
    >>> import dcrb_ros
    >>> ax = dcrb_ros.plot_waveform(dcrb_ros.simulate("outer_ring_defect", 0.2), stop=0.1)
    >>> ax.get_ylabel()
    'acceleration Y [m/s²]'
    """
    if not isinstance(axis, str) or axis not in ("x", "y", "both"):
        raise Refusal(f"axis = {axis!r} is not one of x, y, both")
    shown = signal_of(signal, sampling_rate).waveform().between(start, stop)
    ax = new_axes() if ax is None else ax
    for column, name in ((1, "y"), (0, "x")):
        if axis in (name, "both"):
            time, values = _line(shown.time, shown.acceleration[:, column], np.flatnonzero(np.diff(shown.index) != 1) + 1)
            ax.plot(time, values, color=AXES_COLOURS[name], linewidth=0.6, label=name.upper())
    if axis == "both":
        legend_above(ax)
    if len(shown) > 1:  # a single sample has no limits
        ax.set_xlim(shown.time[0], shown.time[-1])
    return labelled(ax, "time [s]", f"acceleration {'' if axis == 'both' else axis.upper() + ' '}[m/s²]")


def _line(time: Floats, values: Samples, gaps: npt.NDArray[np.intp]) -> tuple[Floats, Samples]:
    """Return the points of a line, broken at ``gaps``; of a long one the smallest and the largest of every few samples."""
    bundle = len(values) // MOST_BUNDLES
    if bundle > 1:
        starts = np.union1d(np.arange(0, len(values), bundle), gaps)
        values = np.stack([np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)], axis=1).ravel()
        time, gaps = np.repeat(time[starts], 2), 2 * np.searchsorted(starts, gaps)
    return np.insert(time, gaps, np.nan), np.insert(values, gaps, np.nan)
