"""The arrangement of the views in the viewer."""

from __future__ import annotations

import rerun.blueprint as rrb

from dcrb_ros.viewer import bearing_picture, load_zone, order_map, palette, spectrum_picture
from dcrb_ros.viewer.content import Content
from dcrb_ros.viewer.drawing import Drawing
from dcrb_ros.viewer.timeline import TIMELINE

CLOSE_UP = 0.15
"""Time shown before and after the cursor in close-ups [s]."""
PANELS = (rrb.BlueprintPanel(state="collapsed"), rrb.SelectionPanel(state="collapsed"))
PANEL = rrb.archetypes.PlotBackground(color=palette.BACKGROUND, show_grid=True)


def compose(content: Content, drawing: Drawing | None, *, picture_only: bool = False) -> rrb.Blueprint:
    """Return the arrangement for a recording; ``picture_only`` hides the viewer's bars for a screenshot."""
    detected: list[rrb.View | rrb.Container] = [
        *([indicators()] if content.detector_output.indicators else []),
        *([features()] if content.features else []),
        *([verdicts()] if content.detector_output.verdicts else []),
    ]
    time = rrb.TimePanel(state="collapsed", timeline=TIMELINE, playback_speed=0.1, play_state="playing")
    bars = [rrb.TopPanel(state="hidden")] if picture_only else []
    return rrb.Blueprint(arrangement(drawing, detected, around=(-CLOSE_UP, CLOSE_UP)), *bars, *PANELS, time, auto_views=False)


def compose_live(drawing: Drawing | None) -> rrb.Blueprint:
    """Return the arrangement for a running bench, in which the cursor follows the newest sample."""
    detected: list[rrb.View | rrb.Container] = [indicators(), features(), verdicts()]
    time = rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following")
    return rrb.Blueprint(arrangement(drawing, detected, around=(-2.0 * CLOSE_UP, 0.0)), *PANELS, time, auto_views=False)


def arrangement(drawing: Drawing | None, detected: list[rrb.View | rrb.Container], *, around: tuple[float, float]) -> rrb.Horizontal:
    """Return the views; close-ups show the time range ``around`` the cursor [s]."""
    axis = close_up(*around)
    left: list[rrb.View | rrb.Container] = [waveform(axis)]
    right: list[rrb.View | rrb.Container] = [rrb.Tabs(spectrum(), orders(), active_tab=0), summary()]
    if drawing is not None:
        left.insert(0, rrb.Tabs(bearing(drawing), zone(drawing.bearing.rows), active_tab=0))
        right.append(motion(axis))
    if detected:
        left.append(rrb.Tabs(*detected))
    return rrb.Horizontal(
        rrb.Vertical(*left, row_shares=[6.0, 3.0, 2.0][-len(left) :] if drawing is None else [6.0, 3.2, 2.4][: len(left)]),
        rrb.Vertical(*right, row_shares=[4.9, 3.1, 3.5][: len(right)]),
        column_shares=[5.6, 4.4],
    )


def bearing(drawing: Drawing) -> rrb.Spatial2DView:
    """Return the view of the bearing."""
    centre = drawing.centre(drawing.bearing.rows - 1)[0]
    bounds = rrb.VisualBounds2D(
        x_range=[-centre - drawing.extent, centre + drawing.extent],
        y_range=[-drawing.rim - 2.0 * drawing.roller, drawing.extent + 2.9 * drawing.roller],
    )
    return rrb.Spatial2DView(
        origin=bearing_picture.ROOT, name="Bearing: normal force of the rollers", background=palette.BACKGROUND, visual_bounds=bounds
    )


def spectrum() -> rrb.Spatial2DView:
    """Return the view of the squared envelope spectrum."""
    width, height = spectrum_picture.WIDTH, spectrum_picture.HEIGHT
    bounds = rrb.VisualBounds2D(x_range=[-0.1 * width, 1.02 * width], y_range=[-4.6 * spectrum_picture.TRACK, height + 100.0])
    return rrb.Spatial2DView(
        origin=spectrum_picture.ROOT,
        name="Squared envelope spectrum: level over background",
        background=palette.BACKGROUND,
        visual_bounds=bounds,
    )


def orders() -> rrb.Spatial2DView:
    """Return the view of the order map: all squared envelope spectra over time."""
    width, height = spectrum_picture.WIDTH, spectrum_picture.HEIGHT
    bounds = rrb.VisualBounds2D(x_range=[-0.1 * width, 1.02 * width], y_range=[-4.6 * spectrum_picture.TRACK, height + 100.0])
    return rrb.Spatial2DView(origin=order_map.ROOT, name="Order map", background=palette.BACKGROUND, visual_bounds=bounds)


def zone(rows: int) -> rrb.Spatial2DView:
    """Return the polar view of the load zone."""
    half = 0.5 * (rows - 1) * load_zone.SPACING + 1.4 * load_zone.RADIUS
    bounds = rrb.VisualBounds2D(x_range=[-half, half], y_range=[-1.5 * load_zone.RADIUS, 1.3 * load_zone.RADIUS])
    name = "Load zone: mean (line) and current normal force"
    return rrb.Spatial2DView(origin=load_zone.ROOT, name=name, background=palette.BACKGROUND, visual_bounds=bounds)


def waveform(axis: rrb.archetypes.TimeAxis) -> rrb.Tabs:
    """Return the views of the waveform: around the cursor and, on a second tab, the whole recording."""
    around = rrb.TimeSeriesView(
        origin="waveform",
        name="Acceleration of the outer ring [m/s²]",
        axis_x=axis,
        background=PANEL,
        plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
    )
    whole = rrb.TimeSeriesView(origin="waveform", name="Whole recording", background=PANEL, plot_legend=rrb.PlotLegend(visible=False))
    return rrb.Tabs(around, whole, active_tab=0)


def close_up(before: float, after: float) -> rrb.archetypes.TimeAxis:
    """Return the time axis of a plot that follows the cursor, from ``before`` to ``after`` relative to it [s]."""
    begin, end = (rrb.TimeRangeBoundary.cursor_relative(seconds=seconds) for seconds in (before, after))
    return rrb.archetypes.TimeAxis(view_range=rrb.TimeRange(start=begin, end=end))


def motion(axis: rrb.archetypes.TimeAxis) -> rrb.Tabs:
    """Return the plots of the states over time."""
    plain = rrb.PlotLegend(visible=False)
    forces = rrb.TimeSeriesView(origin="forces/row1", name="Roller forces, row 1 [kN]", axis_x=axis, background=PANEL, plot_legend=plain)
    spins = rrb.TimeSeriesView(origin="spins/row1", name="Spins [rad/s]", axis_x=axis, background=PANEL, plot_legend=plain)
    cages = rrb.TimeSeriesView(origin="cages", name="Cages [rad/s]", background=PANEL)
    operating = rrb.TimeSeriesView(origin="operating", name="Speed and load", background=PANEL)
    return rrb.Tabs(forces, spins, cages, operating, active_tab=0)


def indicators() -> rrb.TimeSeriesView:
    """Return the plot of the detector's levels over time."""
    legend = rrb.PlotLegend(rrb.Corner2D.LeftTop)
    return rrb.TimeSeriesView(origin="indicators", name="Fault indicators [dB over background]", background=PANEL, plot_legend=legend)


def features() -> rrb.TimeSeriesView:
    """Return the plot of the features of every block over time."""
    return rrb.TimeSeriesView(origin="features", name="Features of each block", background=PANEL)


def verdicts() -> rrb.TextLogView:
    """Return the log of the detector's verdicts."""
    return rrb.TextLogView(origin="diagnosis", name="Verdicts")


def summary() -> rrb.TextDocumentView:
    """Return the summary page."""
    return rrb.TextDocumentView(origin="summary", name="Recording")
