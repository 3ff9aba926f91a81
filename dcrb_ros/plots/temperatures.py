"""The readings of the temperature sensors over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.plots.style import labelled, legend_above

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = {"outer_ring": "#D55E00", "box": "#E69F00", "ambient": "#0072B2"}
"""Colour of each sensor."""


def draw_temperatures(readings: TemperatureReadings, ax: Axes) -> Axes:
    """Draw the readings over time into some axes; sensors that were not recorded are left out."""
    for sensor, colour in COLOURS.items():
        values = getattr(readings, sensor)
        if np.isfinite(values).any():
            ax.plot(readings.time, values, color=colour, marker=".", label=sensor.replace("_", " "))
    legend_above(ax)
    return labelled(ax, "time [s]", "temperature [°C]")
