"""Waveform, squared envelope spectrum and temperatures in one figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.diagnosis.envelope_spectrum import trackable
from dcrb_ros.plots.envelope_spectrum import plot_envelope_spectrum
from dcrb_ros.plots.style import labelled, legend_above
from dcrb_ros.plots.waveform import plot_waveform
from dcrb_ros.text.writing import whole_file

COLOURS = {"outer_ring": "#D55E00", "box": "#E69F00", "ambient": "#0072B2"}
"""Colour of each temperature sensor."""


def write_overview(waveform: Waveform, file: Path, *, title: str, order: bool = True, readings: TemperatureReadings | None = None) -> bool:
    """Write a figure of the waveform and its squared envelope spectrum, over ``order`` or frequency; return whether it is over orders.

    A waveform that cannot be order-tracked has a spectrum over frequency. Temperatures follow below if there are ``readings`` of them.

    Raises:
        Refusal: the file cannot be written, or samples are missing in the waveform.
    """
    warm = readings is not None and len(readings) > 0
    figure = Figure(figsize=(10.0, 9.0 if warm else 6.4), dpi=110, layout="constrained")
    upper, lower, *rest = figure.subplots(3 if warm else 2, 1)
    plot_waveform(waveform, ax=upper)
    tracked = trackable(waveform)
    over_orders = order and tracked
    plot_envelope_spectrum(waveform, order_tracking=tracked, x="order" if over_orders else "frequency", ax=lower)
    if readings is not None and warm:
        _draw_temperatures(readings, rest[0])
        rest[0].set_xlim(upper.get_xlim())
    speed = f", mean shaft frequency {waveform.shaft_frequency:.2f} Hz" if waveform.tracked else ""
    figure.suptitle(f"{title}{speed}", fontsize="large", parse_math=False)
    with whole_file(file) as temporary:
        figure.savefig(temporary)
    return over_orders


def _draw_temperatures(readings: TemperatureReadings, ax: Axes) -> None:
    """Draw the readings over time; sensors that were not recorded are left out."""
    for sensor, colour in COLOURS.items():
        values = getattr(readings, sensor)
        if np.isfinite(values).any():
            ax.plot(readings.time, values, color=colour, marker=".", label=sensor.replace("_", " "))
    legend_above(ax)
    labelled(ax, "time [s]", "temperature [°C]")
