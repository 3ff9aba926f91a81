"""The arrangement of the views of a vehicle in the viewer."""

from __future__ import annotations

import rerun.blueprint as rrb

from dcrb_ros.stream.vehicle_description import SIDES, VehicleDescription
from dcrb_ros.viewer import palette, plan_view
from dcrb_ros.viewer.blueprint import CLOSE_UP, PANEL, PANELS, close_up, spectrum_bounds
from dcrb_ros.viewer.columns import TIMELINE
from dcrb_ros.viewer.vehicle_content import VehicleContent

ALIGNED = "aligned"
SPECTRA = "spectra"


def compose(content: VehicleContent, *, picture_only: bool = False, live: bool = False) -> rrb.Blueprint:
    """Return the arrangement; ``picture_only`` hides the viewer's bars for a screenshot, ``live`` follows the newest sample."""
    around = (-2.0 * CLOSE_UP, 0.0) if live else (-CLOSE_UP, CLOSE_UP)
    legend = rrb.PlotLegend(rrb.Corner2D.RightTop)
    waveforms = [
        rrb.TimeSeriesView(
            origin=f"{ALIGNED}/{side}",
            name=f"{side.capitalize()} boxes, over the time of the leading one at the same place [m/s²]",
            axis_x=close_up(*around),
            background=PANEL,
            plot_legend=legend,
        )
        for side in SIDES
        if any(box.side == side for box in content.description.boxes)
    ]
    logs = rrb.Tabs(
        rrb.TextLogView(origin="verdicts", name="Verdicts"), rrb.TextLogView(origin="events", name="Events on the track"), active_tab=0
    )
    spectra = [
        rrb.Spatial2DView(
            origin=f"{SPECTRA}/{box.name}",
            name=f"{box.name}: squared envelope spectrum",
            background=palette.BACKGROUND,
            visual_bounds=spectrum_bounds(),
        )
        for box in sorted(content.description.boxes, key=lambda box: (SIDES.index(box.side), content.description.axle(box.axle).x))
    ]
    left = rrb.Vertical(plan(content.description), *waveforms, row_shares=[4.6, *[2.7] * len(waveforms)])
    right = rrb.Vertical(rrb.Grid(*spectra, grid_columns=2), logs, row_shares=[7.0, 3.0])
    time = (
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following")
        if live
        else rrb.TimePanel(state="collapsed", timeline=TIMELINE, playback_speed=0.1, play_state="playing")
    )
    bars = [rrb.TopPanel(state="hidden")] if picture_only else []
    return rrb.Blueprint(rrb.Horizontal(left, right, column_shares=[5.0, 5.0]), *bars, *PANELS, time, auto_views=False)


def plan(description: VehicleDescription) -> rrb.Spatial2DView:
    """Return the plan view."""
    places = [axle.x for axle in description.axles]
    bounds = rrb.VisualBounds2D(x_range=[min(places) - 1.7, max(places) + 2.1], y_range=[-1.75, 1.75])
    name = "Plan: boxes filled by level, framed by verdict; forward is right, left is up"
    return rrb.Spatial2DView(origin=plan_view.ROOT, name=name, background=palette.BACKGROUND, visual_bounds=bounds)
