"""The squared envelope spectrum with the fault lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.fault_lines import BearingLike, fault_combs
from dcrb_ros.bearing.waveform import Signal
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.envelope_spectrum import EnvelopeSpectrum, envelope_spectrum
from dcrb_ros.plots.style import CURVE, DASHES, FAULT_LINES, MARKERS, MATPLOTLIB_AXES, labelled, legend_above, new_axes
from dcrb_ros.schema.arguments import checked_arguments, texts
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal, nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

HORIZONTAL = ("order", "frequency")
"""Quantities of the horizontal axis."""
HIGHEST_ORDER = 30.0
"""Highest order shown by default: three harmonics of each ring of the default bearing [-]."""
HIGHEST_FREQUENCY = 600.0
"""Highest frequency shown by default where the speed is unknown [Hz]."""
LEAST_ORDER = 0.3
"""Order from which the spectrum sets the vertical scale [-]: changes over the signal, such as a run-up, lie below it."""
MARKED = 0.1
"""Least height of a peak that is marked, over that of the highest [-]."""
SIDEBANDS = np.arange(-8.0, 9.0)
"""Distances of the sidebands of BPFI from its harmonics, with 0 for these: a defect passes the load zone once a turn [-]."""
SLIP = 0.004
"""Largest deviation of a line from pure rolling, as a share of its frequency [-]."""


@checked_arguments(ax=MATPLOTLIB_AXES)
def plot_envelope_spectrum(
    signal: Signal | EnvelopeSpectrum | npt.ArrayLike,
    sampling_rate: float | None = None,
    *,
    band: tuple[float, float] | None = None,
    shaft_angle: npt.ArrayLike | None = None,
    bearing: BearingLike | None = None,
    order_tracking: bool | None = None,
    x: Literal["order", "frequency"] | None = None,
    highest: float | None = None,
    lines: str | Sequence[str] = ("BPFO", "BPFI", "2BSF", "FTF"),
    ax: Axes | None = None,
) -> Axes:
    """Plot the squared envelope spectrum with the fault lines of the bearing and their harmonics.

    Parameters
    ----------
    signal
        A `SimulationResult`, `Recording`, `Waveform` or `EnvelopeSpectrum`, or accelerations of shape (samples, 2) or (samples,) [m/s^2].
    sampling_rate, band, shaft_angle, bearing, order_tracking
        As for `envelope_spectrum`; not with an `EnvelopeSpectrum`, which has them. Without a bearing no fault lines are drawn.
    x
        Horizontal axis: ``"order"``, multiples of the shaft frequency, or ``"frequency"`` [Hz]; by default orders with order tracking.
    highest
        End of the horizontal axis; order 30 by default, or 600 Hz where the speed is unknown.
    lines
        One or several fault lines to draw: BPFO (outer ring), BPFI (inner ring), 2BSF (roller), FTF (cage).
    ax
        Axes to draw into; those of a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    Refusal
        As `envelope_spectrum`; an unknown line or axis, an end of the axis that is not above 0, or orders where the speed is unknown.

    Examples
    --------
    >>> import dcrb_ros
    >>> run = dcrb_ros.simulate("outer_ring_defect", 1.0)
    >>> ax = dcrb_ros.plot_envelope_spectrum(run, lines=["BPFO"])
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['BPFO 6.72']
    """
    from matplotlib.ticker import EngFormatter

    texts("lines", lines)
    lines = (lines,) if isinstance(lines, str) else lines
    unknown = next((str(name) for name in lines if name not in FAULT_LINES), None)
    if unknown is not None:
        raise Refusal(f"there is no fault line '{unknown}': give some of {', '.join(FAULT_LINES)}{nearest(unknown, FAULT_LINES)}")
    if x is not None and (not isinstance(x, str) or x not in HORIZONTAL):
        raise Refusal(f"x = {x!r} is not one of {', '.join(HORIZONTAL)}{nearest(str(x), HORIZONTAL)}")
    if highest is not None and finite_number("highest =", highest, "orders or Hz") <= 0.0:
        raise Refusal(f"highest = {highest:g} is not above 0: give the end of the horizontal axis")
    options: dict[str, Any] = {"band": band, "shaft_angle": shaft_angle, "bearing": bearing, "order_tracking": order_tracking}
    if isinstance(signal, EnvelopeSpectrum):
        options = {"sampling_rate": sampling_rate, **options}
        double = next((name for name, value in options.items() if value is not None), None)
        if double is not None:
            raise Refusal(f"{double} is given beside {signal!r}, which has its own: leave it out, or give the signal")
        spectrum = signal
    else:
        spectrum = envelope_spectrum(signal, sampling_rate, **options)
    known = spectrum.shaft_frequency > 0.0
    x = x or ("order" if spectrum.tracked else "frequency")
    if x == "order" and not known:
        raise Refusal("the spectrum has no orders, for the speed is unknown: give shaft_angle, or x='frequency'")
    unit = spectrum.shaft_frequency if x == "frequency" and known else 1.0
    positions = spectrum.order if x == "order" else spectrum.frequency
    limit = highest if highest is not None else HIGHEST_ORDER * unit if known else HIGHEST_FREQUENCY
    ax = new_axes() if ax is None else ax
    shown = (positions > 0.0) & (positions <= limit)
    ax.plot(positions[shown], spectrum.amplitude[shown], color=CURVE, linewidth=0.8)
    largest = float(spectrum.amplitude[shown & (positions > LEAST_ORDER * unit)].max(initial=0.0))
    ax.set_ylim(0.0, 1.12 * largest or 1.0)
    ax.set_xlim(0.0, limit)
    if known:
        _draw_lines(ax, spectrum, lines, unit, min(limit, float(positions[-1])), largest)
    label = "order [multiples of the shaft frequency]" if x == "order" else "frequency [Hz]"
    title = f"squared envelope, {Band(*spectrum.band)}{', order-tracked' if spectrum.tracked else ''}"
    ax.yaxis.set_major_formatter(EngFormatter(sep="\N{THIN SPACE}"))
    return labelled(ax, label, "amplitude [(m/s²)²]", title)


def _draw_lines(ax: Axes, spectrum: EnvelopeSpectrum, lines: Sequence[str], unit: float, limit: float, largest: float) -> None:
    """Draw the harmonics of each family as thin lines, with a marker where the spectrum has a peak there."""
    from matplotlib.lines import Line2D

    handles = []
    combs = fault_combs(spectrum.orders, limit / unit)
    families = {comb.name: np.array(comb.orders) for comb in combs}
    if "BPFI" in families:
        families["BPFI"] = np.add.outer(families["BPFI"], SIDEBANDS)
    for comb in combs:
        if comb.name not in lines or not comb.orders:
            continue
        colour, dashes = FAULT_LINES[comb.name], DASHES[comb.name]
        for order in comb.orders:
            ax.axvline(order * unit, color=colour, linewidth=0.9, alpha=0.55, linestyle=dashes, zorder=1.0)
            peak, height = _peak(spectrum, order)
            distance = {name: float(np.abs(lines - peak).min(initial=np.inf)) for name, lines in families.items()}
            if height > 0.0 and height >= MARKED * largest and distance[comb.name] <= min(distance.values()):
                ax.plot(peak * unit, height, marker=MARKERS[comb.name], markersize=4.5, color=colour, zorder=3.0)
        label = f"{comb.name} {comb.orders[0] * unit:.2f}" if unit == 1.0 else f"{comb.name} {comb.orders[0] * unit:.1f} Hz"
        handles.append(Line2D([], [], color=colour, linestyle=dashes, marker=MARKERS[comb.name], markersize=4.5, label=label))
    if handles:
        legend_above(ax, handles)


def _peak(spectrum: EnvelopeSpectrum, order: float) -> tuple[float, float]:
    """Return order and amplitude of the highest peak within the slip of rollers from an order; amplitude 0 without a peak."""
    amplitude = spectrum.amplitude
    near = np.flatnonzero(np.abs(spectrum.order[1:-1] - order) <= max(SLIP * order, 2.0 * spectrum.order[1])) + 1
    peaks = near[(amplitude[near] >= amplitude[near - 1]) & (amplitude[near] >= amplitude[near + 1])]
    if not len(peaks):
        return order, 0.0
    best = peaks[np.argmax(amplitude[peaks])]
    return float(spectrum.order[best]), float(amplitude[best])
