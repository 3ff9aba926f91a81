"""The arrangement of the views in the viewer."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import rerun.blueprint as rrb

from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.viewer import bearing_picture, load_zone, order_map, palette, spectrum_picture
from dcrb_ros.viewer.columns import TIMELINE
from dcrb_ros.viewer.content import Content, Series
from dcrb_ros.viewer.drawing import Drawing
from dcrb_ros.viewer.series import is_warm

CLOSE_UP = 0.15
"""Time shown before and after the cursor in close-ups [s]."""
LEAST_CHANGE = 1.1
"""Highest over lowest shaft frequency from which the order map is shown first [-]."""
LEVEL_TICK = 10.0
"""Spacing of the values at which the axis of levels may end [dB]."""
MARGIN = 0.06
"""Time shown before and after the whole recording, over its duration [-]."""
LABELLED = (1.0, 2.0, 3.0, 10.0)
"""Ends of an axis relative to a power of ten at which it has at least three labels [-]; 10 is the next power."""
PANELS = (rrb.BlueprintPanel(state="collapsed"), rrb.SelectionPanel(state="collapsed"))
PANEL = rrb.archetypes.PlotBackground(color=palette.BACKGROUND, show_grid=True)
PLAIN, LEFT, RIGHT = rrb.PlotLegend(visible=False), rrb.PlotLegend(rrb.Corner2D.LeftTop), rrb.PlotLegend(rrb.Corner2D.RightTop)
"""No legend, and legends in the corners of a plot."""


def plot(
    origin: str, name: str, axis: rrb.archetypes.TimeAxis | None, legend: rrb.PlotLegend | None = None, **options: Any
) -> rrb.TimeSeriesView:
    """Return a plot over time."""
    return rrb.TimeSeriesView(origin=origin, name=name, axis_x=axis, background=PANEL, plot_legend=legend, **options)


def picture(origin: str, name: str, bounds: rrb.VisualBounds2D) -> rrb.Spatial2DView:
    """Return a view of a plane."""
    return rrb.Spatial2DView(origin=origin, name=name, background=palette.BACKGROUND, visual_bounds=bounds)


def arranged(views: rrb.Container, *, picture_only: bool = False, live: bool = False) -> rrb.Blueprint:
    """Return views with the bars of the viewer, which ``picture_only`` hides for a screenshot; ``live`` follows the newest sample."""
    play: dict[str, Any] = {"play_state": "following"} if live else {"play_state": "playing", "playback_speed": 0.1}
    time = rrb.TimePanel(state="collapsed", timeline=TIMELINE, **play)
    bars = [rrb.TopPanel(state="hidden")] if picture_only else []
    return rrb.Blueprint(views, *bars, *PANELS, time, auto_views=False)


def compose(content: Content, drawing: Drawing | None, *, picture_only: bool = False) -> rrb.Blueprint:
    """Return the arrangement for a recording; see `arranged`."""
    output, whole = content.detector_output, whole_time(content)
    detected: list[rrb.View | rrb.Container] = [
        *([indicators(whole, level_axis(output.indicators))] if output.indicators else []),
        *([features(whole)] if content.features else []),
        *([verdicts()] if output.verdicts else []),
    ]
    amplitude = waveform_axis(content.waveform.acceleration)
    views = arrangement(
        drawing,
        detected,
        around=(-CLOSE_UP, CLOSE_UP),
        whole=whole,
        amplitude=amplitude,
        map_first=speed_varies(content),
        lubricated=content.lubrication is not None,
        warm=is_warm(content.truths),
    )
    return arranged(views, picture_only=picture_only)


def whole_time(content: Content) -> rrb.archetypes.TimeAxis:
    """Return the time axis of the whole recording; with a margin, since the plots cut off a label at their edge."""
    margin = round(MARGIN * (content.end_ns - content.start_ns))
    begin, end = (rrb.TimeRangeBoundary.absolute(nanos=nanos) for nanos in (content.start_ns - margin, content.end_ns + margin))
    return rrb.archetypes.TimeAxis(view_range=rrb.TimeRange(start=begin, end=end))


def level_axis(levels: Series) -> rrb.ScalarAxis:
    """Return the vertical axis of the levels that are finite numbers; it ends at labelled values [dB]."""
    finite = levels.values[np.isfinite(levels.values)]
    low, high = (float(value) for value in (finite.min(initial=0.0), finite.max(initial=1.0)))
    return rrb.ScalarAxis(range=(LEVEL_TICK * math.floor(low / LEVEL_TICK), LEVEL_TICK * math.ceil(high / LEVEL_TICK)))


def waveform_axis(acceleration: Floats | Samples) -> rrb.ScalarAxis | None:
    """Return the vertical axis of the waveform, one for the whole recording; None for samples that are not finite.

    Rerun labels the powers of ten only where it has room for few labels, so the axis ends at 1, 2 or 3 times one of them [m/s^2].
    """
    largest = float(np.abs(acceleration).max(initial=0.0))
    if not 0.0 < largest < math.inf:
        return None
    unit = 10.0 ** math.floor(math.log10(largest))
    end = unit * next((share for share in LABELLED if largest <= share * unit * (1.0 + 1e-9)), LABELLED[-1])
    return rrb.ScalarAxis(range=(-end, end))


def speed_varies(content: Content) -> bool:
    """Return whether the shaft frequency changes so much that a single spectrum does not represent the recording."""
    frequencies = [d.shaft_frequency for d in content.detector_output.diagnoses if d.shaft_frequency > 0.0]
    return bool(frequencies) and max(frequencies) > LEAST_CHANGE * min(frequencies)


def compose_live(drawing: Drawing | None, *, lubricated: bool = False, warm: bool = False) -> rrb.Blueprint:
    """Return the arrangement for a running bench, in which the cursor follows the newest sample."""
    detected: list[rrb.View | rrb.Container] = [indicators(), features(), verdicts()]
    views = arrangement(drawing, detected, around=(-2.0 * CLOSE_UP, 0.0), lubricated=lubricated, warm=warm)
    return arranged(views, live=True)


def arrangement(
    drawing: Drawing | None,
    detected: list[rrb.View | rrb.Container],
    *,
    around: tuple[float, float],
    whole: rrb.archetypes.TimeAxis | None = None,
    amplitude: rrb.ScalarAxis | None = None,
    map_first: bool = False,
    lubricated: bool = False,
    warm: bool = False,
) -> rrb.Horizontal:
    """Return the views.

    Close-ups show the time range ``around`` the cursor [s], other plots the ``whole`` time. ``amplitude`` is the vertical axis of
    the waveform. ``map_first`` shows the order map before the spectrum, ``lubricated`` plots of films and friction,
    ``warm`` shows temperatures, noise and films instead of forces and the close-up of the waveform, which are tabs behind them.
    """
    axis = close_up(*around)
    left: list[rrb.View | rrb.Container] = [waveform(axis, whole, amplitude, noise_first=warm)]
    spectra = [
        picture(spectrum_picture.ROOT, "Squared envelope spectrum: level over background", spectrum_bounds()),
        picture(order_map.ROOT, "Order map", spectrum_bounds()),
    ]
    right: list[rrb.View | rrb.Container] = [
        rrb.Tabs(*spectra, active_tab=int(map_first)),
        rrb.TextDocumentView(origin="summary", name="Recording"),
    ]
    if drawing is not None:
        left.insert(0, rrb.Tabs(bearing(drawing), zone(drawing.bearing.rows), active_tab=0))
        plots = motion(axis, whole, lubricated=lubricated and not warm)
        right = heat(right[1], spectra, plots, whole, lubricated=lubricated) if warm else [*right, plots]
    if detected:
        left.append(rrb.Tabs(*detected))
    return rrb.Horizontal(
        rrb.Vertical(*left, row_shares=[6.0, 3.0, 2.0][-len(left) :] if drawing is None else [5.7, 3.2, 2.8][: len(left)]),
        rrb.Vertical(*right, row_shares=[4.9, 3.1, 3.5][: len(right)]),
        column_shares=[5.6, 4.4],
    )


def bearing(drawing: Drawing) -> rrb.Spatial2DView:
    """Return the view of the bearing."""
    centre = drawing.centre(drawing.bearing.rows - 1)[0]
    bounds = rrb.VisualBounds2D(
        x_range=[-centre - drawing.extent, centre + drawing.extent],
        y_range=[-drawing.rim - 2.0 * drawing.roller, drawing.extent + 3.5 * drawing.roller],
    )
    return picture(bearing_picture.ROOT, "Bearing: normal force of the rollers", bounds)


def spectrum_bounds() -> rrb.VisualBounds2D:
    """Return the part of the plane that shows plot, tracks, and the texts beside them."""
    width, height = spectrum_picture.WIDTH, spectrum_picture.HEIGHT
    return rrb.VisualBounds2D(x_range=[-0.13 * width, 1.02 * width], y_range=[-5.0 * spectrum_picture.TRACK, height + 115.0])


def zone(rows: int) -> rrb.Spatial2DView:
    """Return the polar view of the load zone."""
    half = 0.5 * (rows - 1) * load_zone.SPACING + 1.4 * load_zone.RADIUS
    bounds = rrb.VisualBounds2D(x_range=[-half, half], y_range=[-1.5 * load_zone.RADIUS, 1.3 * load_zone.RADIUS])
    return picture(load_zone.ROOT, "Load zone: mean (line) and current normal force", bounds)


def heat(
    page: rrb.View | rrb.Container,
    spectra: list[rrb.Spatial2DView],
    plots: rrb.Tabs,
    whole: rrb.archetypes.TimeAxis | None,
    *,
    lubricated: bool,
) -> list[rrb.View | rrb.Container]:
    """Return the views of a bench with temperatures: these, films and friction, and the others on tabs."""
    temperatures = plot("temperatures", "Temperatures [°C]", whole, LEFT)
    oil = [rrb.Tabs(*films(whole), active_tab=0)] if lubricated else []
    return [rrb.Tabs(temperatures, *plots.contents, active_tab=0), *oil, rrb.Tabs(page, *spectra, active_tab=0)]


def films(whole: rrb.archetypes.TimeAxis | None) -> tuple[rrb.TimeSeriesView, rrb.TimeSeriesView]:
    """Return the plots of oil films and of friction over time."""
    return plot("films", "Oil film [µm], Lambda", whole, RIGHT), plot("friction", "Friction [W]", whole)


def waveform(
    axis: rrb.archetypes.TimeAxis,
    whole_axis: rrb.archetypes.TimeAxis | None,
    amplitude: rrb.ScalarAxis | None,
    *,
    noise_first: bool = False,
) -> rrb.Tabs:
    """Return the views of the waveform: around the cursor and, on further tabs, the whole recording and the noise of its blocks.

    ``noise_first`` shows the noise first.
    """
    around = plot("waveform", "Acceleration of the outer ring [m/s²]", axis, RIGHT, axis_y=amplitude)
    whole = plot("waveform", "Whole recording", whole_axis, PLAIN, axis_y=amplitude)
    noise = plot("features", "Vibration: rms of each block in Y [m/s²]", whole_axis, PLAIN, contents=["/features/rms"])
    return rrb.Tabs(noise, around, whole, active_tab=0) if noise_first else rrb.Tabs(around, whole, noise, active_tab=0)


def close_up(before: float, after: float) -> rrb.archetypes.TimeAxis:
    """Return the time axis of a plot that follows the cursor, from ``before`` to ``after`` relative to it [s]."""
    begin, end = (rrb.TimeRangeBoundary.cursor_relative(seconds=seconds) for seconds in (before, after))
    return rrb.archetypes.TimeAxis(view_range=rrb.TimeRange(start=begin, end=end))


def motion(axis: rrb.archetypes.TimeAxis, whole: rrb.archetypes.TimeAxis | None, *, lubricated: bool) -> rrb.Tabs:
    """Return the plots of the states over time."""
    forces = plot("forces/row1", "Roller forces, row 1 [kN]", axis, PLAIN)
    spins, cages = plot("spins/row1", "Spins [rad/s]", axis, PLAIN), plot("cages", "Cages [rad/s]", whole)
    operating = plot("operating", "Speed and load", whole)
    return rrb.Tabs(forces, spins, cages, operating, *(films(whole) if lubricated else ()), active_tab=0)


def indicators(whole: rrb.archetypes.TimeAxis | None = None, levels: rrb.ScalarAxis | None = None) -> rrb.TimeSeriesView:
    """Return the plot of the detector's levels over time."""
    return plot("indicators", "Fault indicators [dB over background]", whole, LEFT, axis_y=levels)


def features(whole: rrb.archetypes.TimeAxis | None = None) -> rrb.TimeSeriesView:
    """Return the plot of the features of every block over time."""
    return plot("features", "Features of each block", whole)


def verdicts() -> rrb.TextLogView:
    """Return the log of the detector's verdicts."""
    return rrb.TextLogView(origin="diagnosis", name="Verdicts")
