"""The arrangement of the views of a vehicle in the viewer."""

from __future__ import annotations

import rerun.blueprint as rrb

from dcrb_ros.stream.vehicle_description import SIDES, VehicleDescription
from dcrb_ros.viewer import plan_view
from dcrb_ros.viewer.blueprint import CLOSE_UP, RIGHT, arranged, close_up, picture, plot, spectrum_bounds
from dcrb_ros.viewer.vehicle_content import VehicleContent

ALIGNED = "aligned"
SPECTRA = "spectra"


def compose(content: VehicleContent, *, picture_only: bool = False, live: bool = False) -> rrb.Blueprint:
    """Return the arrangement; see `arranged`."""
    around = (-2.0 * CLOSE_UP, 0.0) if live else (-CLOSE_UP, CLOSE_UP)
    title = "boxes, over the time of the leading one at the same place [m/s²]"
    waveforms = [
        plot(f"{ALIGNED}/{side}", f"{side.capitalize()} {title}", close_up(*around), RIGHT)
        for side in SIDES
        if any(box.side == side for box in content.description.boxes)
    ]
    logs = rrb.Tabs(
        rrb.TextLogView(origin="verdicts", name="Verdicts"), rrb.TextLogView(origin="events", name="Events on the track"), active_tab=0
    )
    spectra = [
        picture(f"{SPECTRA}/{box.name}", f"{box.name}: squared envelope spectrum", spectrum_bounds())
        for box in sorted(content.description.boxes, key=lambda box: (SIDES.index(box.side), content.description.axle(box.axle).x))
    ]
    left = rrb.Vertical(plan(content.description), *waveforms, row_shares=[4.6, *[2.7] * len(waveforms)])
    right = rrb.Vertical(rrb.Grid(*spectra, grid_columns=2), logs, row_shares=[7.0, 3.0])
    return arranged(rrb.Horizontal(left, right, column_shares=[5.0, 5.0]), picture_only=picture_only, live=live)


def plan(description: VehicleDescription) -> rrb.Spatial2DView:
    """Return the plan view."""
    places = [axle.x for axle in description.axles]
    bounds = rrb.VisualBounds2D(x_range=[min(places) - 1.7, max(places) + 2.1], y_range=[-1.75, 1.75])
    return picture(plan_view.ROOT, "Plan: boxes filled by level, framed by verdict; forward is right, left is up", bounds)
