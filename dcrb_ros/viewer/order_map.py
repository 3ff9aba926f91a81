"""The order map: the squared envelope spectra of a recording as rows of an image, with the fault lines.

Orders are multiples of the shaft frequency, so the lines of a fault are vertical even if the speed changes.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import rerun as rr

from dcrb_ros.bearing.fault_lines import fault_combs
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.viewer import columns, palette
from dcrb_ros.viewer.content import Times
from dcrb_ros.viewer.spectrum import Spectra
from dcrb_ros.viewer.spectrum_picture import HEIGHT, VALUES, WIDTH, log_comb, log_texts, order_ticks, track

ROOT = "order_map"
TIME_TICKS = 6
SCALE_QUANTILE = 0.9995
"""Quantile of the levels at the end of the colour scale [-]."""


def log_order_map(spectra: Spectra, orders: Orders) -> None:
    """Log the map, its axes, the fault lines of some ``orders`` and a line at the current time under `ROOT`."""
    log_map(spectra)
    log_fault_lines(spectra.highest_order, orders)
    log_cursor(spectra.time_ns)


def log_map(spectra: Spectra) -> None:
    """Log the image of the spectra and its axes."""
    largest = max(10.0, 5.0 * np.ceil(float(np.quantile(spectra.level, SCALE_QUANTILE)) / 5.0))
    rr.log(f"{ROOT}/levels", rr.Image(picture(spectra, largest), draw_order=-1.0), static=True)
    log_axes(spectra, largest)


def log_fault_lines(highest_order: float, orders: Orders) -> None:
    """Log the fault lines across the map."""
    combs = fault_combs(orders, highest_order)
    for row, comb in enumerate(combs):
        log_comb(highest_order, comb, track(row, len(combs)), root=ROOT)


def picture(spectra: Spectra, largest: float) -> npt.NDArray[np.uint8]:
    """Return the levels as colours on a scale up to ``largest`` [dB], shape (HEIGHT, WIDTH, 3).

    A pixel shows the largest level of its orders. Where no window ends within one and a half steps, the row has the background colour.
    """
    borders = np.searchsorted(spectra.orders, np.arange(int(WIDTH)) / WIDTH * spectra.highest_order)
    columns = np.maximum.reduceat(spectra.level, np.minimum(borders, len(spectra.orders) - 1), axis=1)
    first, last = span_of(spectra.time_ns)
    wanted = first + (np.arange(int(HEIGHT)) + 0.5) / HEIGHT * (last - first)
    rows = np.minimum(np.searchsorted(spectra.time_ns, wanted), len(columns) - 1)
    columns = columns[rows]
    colours = palette.force_colours(np.maximum(columns, 1e-3), largest)[..., :3]
    dark = np.clip(columns / (0.25 * largest), 0.0, 1.0)[..., None]  # levels near the background are drawn dark
    shown = (colours * dark + np.array(palette.BACKGROUND[:3]) * (1.0 - dark)).astype(np.uint8)
    shown[spectra.time_ns[rows] - wanted > 1.5 * (spectra.time_ns[0] - first)] = palette.BACKGROUND[:3]
    return shown


def span_of(time_ns: Times) -> tuple[int, int]:
    """Return the times at the upper and lower edge of the map [ns]; the row of a window ends at the window's end."""
    step = int(np.median(np.diff(time_ns))) if len(time_ns) > 1 else 1_000_000_000
    return int(time_ns[0]) - step, int(time_ns[-1])


def log_axes(spectra: Spectra, largest: float) -> None:
    """Log the ticks of orders and times, and the axis label."""
    orders = order_ticks(spectra.highest_order)
    first, last = span_of(spectra.time_ns)
    times = np.linspace(first, last, TIME_TICKS)
    below = np.stack([orders / spectra.highest_order * WIDTH, np.full_like(orders, HEIGHT + 30.0)], axis=-1)
    beside = np.stack([np.full(TIME_TICKS, VALUES), np.linspace(0.0, HEIGHT, TIME_TICKS)], axis=-1)
    texts = [*(f"{order:g}" for order in orders), *(f"{time / 1e9:.2f} s" for time in times)]
    log_texts(f"{ROOT}/ticks", np.concatenate([below, beside]), texts, palette.MUTED)
    meaning = f"multiples of the shaft frequency; bright: {largest:g} dB over background"
    log_texts(f"{ROOT}/meaning", np.array([[0.5 * WIDTH, HEIGHT + 74.0]]), [meaning], palette.MUTED)


def log_cursor(time_ns: Times) -> None:
    """Log a line across the map at the current time, window by window."""
    first, last = span_of(time_ns)
    y = HEIGHT * (time_ns - first) / max(1, last - first)
    strips = np.stack([np.stack([np.zeros_like(y), y], -1), np.stack([np.full_like(y, WIDTH), y], -1)], axis=1)
    fixed = rr.LineStrips2D.from_fields(radii=rr.Radius.ui_points(0.8), colors=[palette.BRIGHT], draw_order=6.0)
    rr.log(f"{ROOT}/cursor", fixed, static=True)
    columns.send(f"{ROOT}/cursor", time_ns, columns.strips(strips[:, None]))
