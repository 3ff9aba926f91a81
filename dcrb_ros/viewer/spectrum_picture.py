"""The plot of the squared envelope spectrum in Rerun, with labelled fault lines.

It is drawn in a two-dimensional view with X right and Y down, including the axes, since Rerun's own plots are over time only or
are bar charts without labels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import rerun as rr

from dcrb_ros.bearing.fault_lines import Comb, fault_combs
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.viewer import columns, palette
from dcrb_ros.viewer.columns import time_column
from dcrb_ros.viewer.spectrum import ORDER_STEP, Spectra

ROOT = "envelope_spectrum"
WIDTH, HEIGHT, TRACK = 1000.0, 300.0, 46.0
"""Width and height of the plot, and height of the track of each fault above it [picture units]."""
NAMES, VALUES = -72.0, -56.0
"""Horizontal positions of the names of the tracks and of the values of the vertical axis [picture units]."""
LEVEL_TICK = 20.0
"""Spacing of the level ticks [dB]."""
MOST_ORDER_TICKS = 8
LABEL_DROP = 20.0
"""Distance of a label below its point in a window of typical size [picture units]."""
SEARCH = 0.006
"""Range to either side of a harmonic in which its peak is searched, as a share of its order [-]."""


@dataclass(frozen=True)
class Axes:
    """The ranges of the plot's axes: orders [-] and levels [dB]."""

    highest_order: float
    lowest_level: float
    highest_level: float

    def points(self, orders: Floats, levels: Floats) -> Floats:
        """Return positions in the plot, shape (..., 2) [picture units]."""
        span = self.highest_level - self.lowest_level
        x = np.asarray(orders) / self.highest_order * WIDTH
        y = HEIGHT * (self.highest_level - np.clip(levels, self.lowest_level, self.highest_level)) / span
        return np.stack(np.broadcast_arrays(x, y), axis=-1)


def log_spectra(spectra: Spectra, orders: Orders, start_ns: int, *, root: str = ROOT) -> None:
    """Log the spectrum of every window, the axes and the fault lines of some ``orders`` under ``root``.

    The spectrum of a window is shown from the window's end on, the first one from ``start_ns``, where the viewer opens.
    """
    times = spectra.time_ns.copy()
    times[0] = start_ns
    GrowingSpectra(orders, root=root).log(replace(spectra, time_ns=times))


class GrowingSpectra:
    """Spectra that arrive one after another, on axes that grow with them."""

    def __init__(self, orders: Orders, *, root: str = ROOT) -> None:
        """Begin without spectra; ``orders`` are those of the fault lines."""
        self._orders, self._root = orders, root
        self._axes: Axes | None = None

    def log(self, spectra: Spectra) -> bool:
        """Log further spectra; return whether the fault lines were drawn anew, on other axes."""
        combs, axes = fault_combs(self._orders, spectra.highest_order), axes_of(spectra)
        known = self._axes
        grown = known is None or axes.highest_level > known.highest_level or axes.highest_order != known.highest_order
        if known is None or grown:
            self._axes = axes
            log_axes(axes, root=self._root)
            log_combs(axes, combs, root=self._root)
        log_levels(self._axes or axes, combs, spectra, root=self._root)
        return grown


def axes_of(spectra: Spectra) -> Axes:
    """Return axes whose ranges contain all spectra."""
    highest = max(LEVEL_TICK * np.ceil(float(spectra.level.max(initial=0.0)) / LEVEL_TICK), 2.0 * LEVEL_TICK)
    return Axes(spectra.highest_order, -0.5 * LEVEL_TICK, float(highest))


def track(row: int, count: int) -> float:
    """Return the height of a track above the plot, the lowest one clear of the plot's highest value [picture units]."""
    return -TRACK * (count - row + 0.3)


def log_combs(axes: Axes, combs: Sequence[Comb], *, root: str) -> None:
    """Log the fault lines and the style of curve, area and peaks."""
    for row, comb in enumerate(combs):
        log_comb(axes.highest_order, comb, track(row, len(combs)), root=root)
        fixed = rr.Points2D.from_fields(radii=rr.Radius.ui_points(3.5), colors=[palette.FAULT_LINES[comb.name]], draw_order=5.0)
        rr.log(f"{root}/{comb.name}/peaks", fixed, static=True)
    half = 0.55 * WIDTH * ORDER_STEP / axes.highest_order
    rr.log(f"{root}/area", rr.LineStrips2D.from_fields(radii=[half], colors=[palette.AREA], draw_order=2.0), static=True)
    thin = rr.Radius.ui_points(0.7)
    rr.log(f"{root}/curve", rr.LineStrips2D.from_fields(radii=thin, colors=[palette.CURVE], draw_order=3.0), static=True)


def log_levels(axes: Axes, combs: Sequence[Comb], spectra: Spectra, *, root: str) -> None:
    """Log the curve, the area below it, the peaks and the shaft frequency of every spectrum over time."""
    for comb in combs:
        log_peaks(axes, comb, spectra, root=root)
    log_curve(axes, spectra, root=root)
    labels = [f"multiples of the shaft frequency ({frequency:.2f} Hz)" for frequency in spectra.shaft_frequency]
    rr.send_columns(f"{root}/meaning", [time_column(spectra.time_ns)], rr.Points2D.columns(labels=labels))


def log_axes(axes: Axes, *, root: str) -> None:
    """Log grid, ticks and the position of the axis label."""
    orders = order_ticks(axes.highest_order)
    levels = np.arange(0.0, axes.highest_level + 1e-9, LEVEL_TICK)
    upright = [axes.points(np.array([o, o]), np.array([axes.lowest_level, axes.highest_level])) for o in orders]
    level = [axes.points(np.array([0.0, axes.highest_order]), np.array([v, v])) for v in levels]
    grid = rr.LineStrips2D([*upright, *level], radii=rr.Radius.ui_points(0.5), colors=[palette.FAINT], draw_order=0.0)
    rr.log(f"{root}/grid", grid, static=True)
    below = axes.points(orders, np.full_like(orders, axes.lowest_level)) + np.array([0.0, 30.0])
    beside = axes.points(np.zeros_like(levels), levels) + np.array([VALUES, 0.0])
    texts = [*(f"{order:g}" for order in orders), *(f"{value:g}" for value in levels[:-1]), f"{levels[-1]:g} dB"]
    log_texts(f"{root}/ticks", np.concatenate([below, beside]), texts, palette.MUTED)
    middle = [[0.5 * WIDTH, HEIGHT + 74.0 - LABEL_DROP]]
    label = rr.Points2D.from_fields(positions=middle, radii=[0.01], show_labels=True, colors=[palette.MUTED])
    rr.log(f"{root}/meaning", label, static=True)


def order_ticks(highest: float) -> Floats:
    """Return the tick positions of an axis up to the ``highest`` order [-]."""
    tick = next(step for step in (5.0, 10.0, 20.0, 50.0, 100.0) if highest / step < MOST_ORDER_TICKS or step == 100.0)
    return np.arange(0.0, highest + 1e-9, tick)


def log_texts(path: str, positions: Floats, texts: Sequence[str], colour: palette.Colour, *, drop: float = LABEL_DROP) -> None:
    """Log texts at positions, shifted upwards by ``drop``, since Rerun draws a label at a fixed distance below its point."""
    raised = positions - [0.0, drop]
    rr.log(path, rr.Points2D(raised, radii=0.01, labels=list(texts), show_labels=True, colors=[colour]), static=True)


def log_comb(highest_order: float, comb: Comb, y: float, *, root: str) -> None:
    """Log the track of one fault: its name, and for every harmonic a dot and a line down through the plot."""
    colour, path = palette.FAULT_LINES[comb.name], f"{root}/{comb.name}"
    x = np.array(comb.orders) / highest_order * WIDTH
    dots = np.stack([x, np.full_like(x, y)], axis=-1)
    feet = np.stack([x, np.full_like(x, HEIGHT)], axis=-1)
    lines = np.stack([dots, feet], axis=1).astype(np.float32)
    track = [[[0.0, y], [WIDTH, y]]]
    thin = rr.Radius.ui_points(0.6)
    rr.log(f"{path}/track", rr.LineStrips2D(track, radii=thin, colors=[palette.FAINT], draw_order=1.0), static=True)
    rr.log(f"{path}/lines", rr.LineStrips2D(lines, radii=thin, colors=[palette.with_opacity(colour, 0.32)], draw_order=1.0), static=True)
    rr.log(f"{path}/harmonics", rr.Points2D(dots, radii=rr.Radius.ui_points(3.0), colors=[colour], draw_order=2.0), static=True)
    log_texts(f"{path}/name", np.array([[NAMES, y]]), [comb.name], colour)


def log_peaks(axes: Axes, comb: Comb, spectra: Spectra, *, root: str) -> None:
    """Log a dot at the peak of the spectrum near every harmonic."""
    if not comb.orders:
        return
    orders, level = spectra.orders, spectra.level
    resolution = float(orders[1] - orders[0])
    positions = np.empty((len(level), len(comb.orders), 2))
    for k, harmonic in enumerate(comb.orders):
        near = np.flatnonzero(np.abs(orders - harmonic) <= max(SEARCH * harmonic, 1.5 * resolution))
        best = near[np.argmax(level[:, near], axis=1)]
        positions[:, k] = axes.points(orders[best], level[np.arange(len(level)), best])
    path = f"{root}/{comb.name}/peaks"
    columns.send(path, spectra.time_ns, columns.vectors(rr.Points2D.descriptor_positions(), positions))


def log_curve(axes: Axes, spectra: Spectra, *, root: str) -> None:
    """Log the curve of the spectrum and the area below it."""
    curve = axes.points(spectra.orders, spectra.level)
    foot = curve.copy()
    foot[..., 1] = HEIGHT
    area = np.stack([foot, curve], axis=2)
    columns.send(f"{root}/area", spectra.time_ns, columns.strips(area))
    columns.send(f"{root}/curve", spectra.time_ns, columns.strips(curve[:, None]))
