"""Two recordings side by side: third octaves, squared envelope spectra, kurtosis by octave, and the residual of a calibration."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from dcrb_ros.plots.style import AXES_COLOURS, labelled, legend_above
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.printable import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from dcrb_ros.calibration.calibration import Calibration
    from dcrb_ros.calibration.comparison import AxisComparison, RecordingComparison

DASHED = (0.0, (4.0, 2.0))
LONGEST_LABEL, LONGEST_LINE = 24, 110
"""Characters of a name in a legend, and of a line above the figure [-]."""


def comparison_figure(comparison: RecordingComparison, *, title: str = "", calibration: Calibration | None = None) -> Figure:
    """Return the figure of a comparison; with a calibration its last row is the residual of the fit in narrow bins."""
    figure = Figure(figsize=(12.0, 9.0), dpi=110, layout="constrained")
    (levels, envelope), (kurtosis, residual) = figure.subplots(2, 2)
    names, heading = _labels(comparison)
    _levels(levels, comparison.axes, names)
    _envelope(envelope, comparison.axes[-1], names)
    _kurtosis(kurtosis, comparison.axes, names)
    if calibration is None:
        _difference(residual, comparison.axes, names)
    else:
        _residual(residual, calibration)
    lines = [printable(title)] if title else heading
    figure.suptitle("\n".join(textwrap.fill(line, LONGEST_LINE) for line in lines), fontsize="large", parse_math=False)
    return figure


def _labels(comparison: RecordingComparison) -> tuple[tuple[str, str], list[str]]:
    """Return names that fit into a legend, and the lines above the figure: A and B for names that are too long.

    Matplotlib hides a label that begins with an underscore.
    """
    first, second = map(printable, comparison.names)
    if all(len(name) <= LONGEST_LABEL and not name.startswith("_") for name in (first, second)):
        return (first, second), [f"{first} and {second}"]
    return ("A", "B"), [f"A: {first}", f"B: {second}"]


def _levels(ax: Axes, axes: Sequence[AxisComparison], names: tuple[str, str]) -> None:
    for pair in axes:
        _both(ax, pair.axis, pair.frequency, pair.levels, names)
    legend_above(ax)
    apart = ", ".join(f"{pair.axis.upper()} {pair.level_distance:.1f} dB" for pair in axes)
    labelled(ax, "Frequency in Hz", "Level in dB over 1 (m/s²)²", f"Third octaves, {apart} apart")


def _both(ax: Axes, axis: str, frequency: Floats, values: tuple[Floats, Floats], names: tuple[str, str], **look: Any) -> None:
    """Draw a quantity of an axis of both recordings over the frequency [Hz], that of the second one dashed."""
    for name, each, style in zip(names, values, ("solid", DASHED), strict=True):
        ax.semilogx(frequency, each, color=AXES_COLOURS[axis], linestyle=style, label=f"{axis.upper()}, {name}", **look)


def _envelope(ax: Axes, pair: AxisComparison, names: tuple[str, str]) -> None:
    if not len(pair.orders):
        ax.text(0.5, 0.5, "no speed, no orders", transform=ax.transAxes, ha="center")
        labelled(ax, "Order", "Amplitude over mean", "Squared envelope spectrum")
        return
    for name, values, colour in zip(names, pair.envelopes, (AXES_COLOURS["y"], "#D55E00"), strict=True):
        ax.plot(pair.orders, values, color=colour, linewidth=0.8, label=name, alpha=0.85)
    legend_above(ax)
    labelled(
        ax,
        "Order of the shaft",
        "Amplitude over mean",
        f"Squared envelope spectrum of {pair.axis.upper()}, {pair.envelope_distance:.2f} apart",
    )


def _kurtosis(ax: Axes, axes: Sequence[AxisComparison], names: tuple[str, str]) -> None:
    for pair in axes:
        _both(ax, pair.axis, pair.octaves, pair.kurtosis, names, marker="o", markersize=4.0)
    ax.axhline(3.0, color="#808080", linewidth=0.8)
    octaves = axes[0].octaves
    ax.set_xticks(octaves, [f"{octave:g}" for octave in octaves])
    ax.minorticks_off()
    legend_above(ax)
    labelled(ax, "Middle of the octave in Hz", "Kurtosis (noise has 3)", "Kurtosis by octave")


def _difference(ax: Axes, axes: Sequence[AxisComparison], names: tuple[str, str]) -> None:
    for pair in axes:
        ax.semilogx(pair.frequency, pair.difference, color=AXES_COLOURS[pair.axis], marker="o", markersize=4.0, label=pair.axis.upper())
    ax.axhline(0.0, color="#808080", linewidth=0.8)
    legend_above(ax)
    labelled(ax, "Frequency in Hz", "Difference in dB", f"{names[1]} over {names[0]}")


def _residual(ax: Axes, calibration: Calibration) -> None:
    for axis, frequency, values in calibration.residual:
        ax.semilogx(frequency, values, color=AXES_COLOURS[axis], linewidth=0.7, label=f"{axis.upper()}: measured over model")
    for axis in sorted({band.axis for band in calibration.path}):
        bands = [band for band in calibration.path if band.axis == axis and band.identified]
        middles, half = np.array([band.frequency for band in bands]), np.array([0.5 * (band.high - band.low) for band in bands])
        ax.fill_between(middles, -half, half, color=AXES_COLOURS[axis], alpha=0.2, label=f"{axis.upper()}: interval of the path")
    ax.axhline(0.0, color="#808080", linewidth=0.8)
    ax.set_ylim(-15.0, 15.0)
    legend_above(ax)
    labelled(ax, "Frequency in Hz", "Residual in dB", "Residual of the fit, and the interval of the path in third octaves")
