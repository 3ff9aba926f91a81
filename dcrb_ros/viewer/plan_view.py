"""The plan view of a bogie in Rerun: boxes filled by the level of their vibration and framed by the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr

from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status
from dcrb_ros.stream.vehicle_description import BoxDescription, VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import BOX_PARTS
from dcrb_ros.viewer import columns, palette
from dcrb_ros.viewer.columns import time_column
from dcrb_ros.viewer.content import Series, Times
from dcrb_ros.viewer.vehicle_content import TrackEvent, Verdicts

ROOT = "plan"
BOX, RAIL, WHEEL = 1.0, 0.75, 0.46
"""Half the distance of the boxes and of the rails, and the radius of a wheel if it is not known [m]."""
LENGTH, HEIGHT = 0.62, 0.34
"""Size of a box in the picture [m]."""
STRIPS = 16
"""Lines that fill a box [-]."""
SHOWN = 0.15
"""Time for which an event on the track is shown [s]."""
MARK = 0.12
"""Radius of the mark of an event [m]."""
WAITING, HEALTHY, DOUBTFUL = palette.MUTED, (110, 214, 130, 255), (255, 196, 87, 255)


def centre(description: VehicleDescription, box: BoxDescription) -> tuple[float, float]:
    """Return where a box is in the picture, in which the vehicle runs to the right [m]."""
    return description.axle(box.axle).x, -BOX if box.side == "left" else BOX


def log_fixed(description: VehicleDescription) -> None:
    """Log rails, wheelsets and the names of the boxes."""
    places = [axle.x for axle in description.axles]
    first, last = min(places) - 1.5, max(places) + 1.5
    rails = [[[first, side * RAIL], [last, side * RAIL]] for side in (-1.0, 1.0)]
    rr.log(f"{ROOT}/rails", rr.LineStrips2D(rails, radii=0.035, colors=[palette.STEEL_EDGE], draw_order=0.0), static=True)
    frame = [[[min(places) - 0.3, side * 0.98], [max(places) + 0.3, side * 0.98]] for side in (-1.0, 1.0)] + [[[0.0, -0.98], [0.0, 0.98]]]
    rr.log(f"{ROOT}/frame", rr.LineStrips2D(frame, radii=0.07, colors=[palette.FAINT], draw_order=1.0), static=True)
    axles = [[[x, -1.05], [x, 1.05]] for x in places]
    rr.log(f"{ROOT}/axles", rr.LineStrips2D(axles, radii=0.07, colors=[palette.STEEL], draw_order=2.0), static=True)
    wheels = [
        [[axle.x - axle.wheel_radius, side * RAIL], [axle.x + axle.wheel_radius, side * RAIL]]
        for axle in description.axles
        for side in (-1.0, 1.0)
    ]
    rr.log(f"{ROOT}/wheels", rr.LineStrips2D(wheels, radii=0.065, colors=[palette.STEEL_EDGE], draw_order=3.0), static=True)
    gears = [axle.x for axle in description.axles if axle.driven]
    if gears:
        drives = [[[x, -0.42], [x, -0.28]] for x in gears]
        rr.log(f"{ROOT}/gears", rr.LineStrips2D(drives, radii=0.22, colors=[palette.BRASS], draw_order=3.0), static=True)
    arrow = rr.Arrows2D(origins=[[last - 0.1, 0.0]], vectors=[[0.5, 0.0]], colors=[palette.MUTED], radii=0.02)
    rr.log(f"{ROOT}/forward", arrow, static=True)
    for box in description.boxes:
        x, y = centre(description, box)
        fill = [
            [[x - 0.5 * LENGTH, level], [x + 0.5 * LENGTH, level]]
            for level in y + HEIGHT * (np.arange(STRIPS) + 0.5 - 0.5 * STRIPS) / STRIPS
        ]
        filled = rr.LineStrips2D.from_fields(strips=fill, radii=[0.7 * HEIGHT / STRIPS], draw_order=4.0)
        rr.log(f"{ROOT}/{box.name}/fill", filled, static=True)
        outline = rr.Boxes2D(centers=[[x, y]], half_sizes=[[0.5 * LENGTH + 0.05, 0.5 * HEIGHT + 0.05]], radii=0.03, draw_order=5.0)
        rr.log(f"{ROOT}/{box.name}/frame", outline, static=True)
        below = y + (0.5 * HEIGHT + 0.12) * (1.0 if y > 0.0 else -1.9)
        label = rr.Points2D.from_fields(positions=[[x, below]], radii=[0.001], show_labels=True, colors=[palette.BRIGHT])
        rr.log(f"{ROOT}/{box.name}/text", label, static=True)


def log_levels(description: VehicleDescription, features: Mapping[str, Series], largest: float) -> None:
    """Log the level of every block in each box as its colour, on a scale up to ``largest`` [m/s^2]."""
    for box in description.boxes:
        series = features.get(box.name)
        if series is None or "rms" not in series.names:
            continue
        rms = series.values[:, series.names.index("rms")]
        colours = palette.force_colours(np.repeat(rms[:, None], STRIPS, axis=1), largest)
        columns.send(f"{ROOT}/{box.name}/fill", series.time_ns, columns.colours(rr.LineStrips2D.descriptor_colors(), colours))


def log_verdicts(description: VehicleDescription, verdicts: Sequence[Verdicts], start_ns: int | None) -> None:
    """Log the verdicts on the parts of each box as the colour of its frame and as text, grey from ``start_ns`` on, if it is given."""
    shown = [*([Verdicts(start_ns, {})] if start_ns is not None else []), *verdicts]
    if not shown:
        return
    times = np.array([verdict.time_ns for verdict in shown], np.int64)
    for box in description.boxes:
        frames = np.array([[colour_of(worst(verdict.statuses, box.name))] for verdict in shown], np.uint8)
        columns.send(f"{ROOT}/{box.name}/frame", times, columns.colours(rr.Boxes2D.descriptor_colors(), frames))
        texts = [text_of(verdict.statuses, box.name) for verdict in shown]
        rr.send_columns(f"{ROOT}/{box.name}/text", [time_column(times)], rr.Points2D.columns(labels=texts))


def worst(statuses: Mapping[str, Status], box: str) -> Status | None:
    """Return the most serious verdict on a box; None before the first."""
    own = [statuses[f"{box}/{part}"] for part in BOX_PARTS if f"{box}/{part}" in statuses]
    return max(own, key=lambda status: status.level) if own else None


def colour_of(status: Status | None) -> palette.Colour:
    """Return the colour of a verdict."""
    if status is None or status.message == "waiting":
        return WAITING
    return {OK: HEALTHY, WARN: DOUBTFUL, ERROR: palette.DEFECT}.get(status.level, palette.DEFECT)


def text_of(statuses: Mapping[str, Status], box: str) -> str:
    """Return the name of a box with its verdicts."""
    own = {part: statuses[f"{box}/{part}"].message for part in BOX_PARTS if f"{box}/{part}" in statuses}
    found = [f"{part} {verdict}" if verdict != part else part for part, verdict in own.items() if verdict not in ("healthy", "waiting")]
    said = ", ".join(found).replace("_", " ") or ("waiting" if "waiting" in own.values() or not own else "healthy")
    return f"{box}: {said}"


def log_events(description: VehicleDescription, events: Sequence[TrackEvent]) -> None:
    """Log each event on the track as a mark at its wheel, for some time."""
    wheels = {box.name: (description.axle(box.axle).x, -RAIL if box.side == "left" else RAIL) for box in description.boxes}
    for name, place in wheels.items():
        path = f"{ROOT}/{name}/event"
        own = sorted((event for event in events if event.where == name), key=lambda event: event.time_ns)
        times, shown = _flashes(own)
        if len(times):
            rr.log(path, rr.Points2D.from_fields(positions=[place], colors=[palette.DEFECT], draw_order=6.0), static=True)
            rr.send_columns(path, [time_column(times)], rr.Points2D.columns(radii=[MARK if on else 0.0 for on in shown]))


def _flashes(events: Sequence[TrackEvent]) -> tuple[Times, list[bool]]:
    """Return the times at which the mark of a wheel appears and disappears, in order, and which of them it is [ns]."""
    times, shown = list[int](), list[bool]()
    for number, event in enumerate(events):
        times.append(event.time_ns)
        shown.append(True)
        gone = event.time_ns + round(SHOWN * 1e9)
        if number + 1 == len(events) or events[number + 1].time_ns > gone:
            times.append(gone)
            shown.append(False)
    return np.array(times, np.int64), shown
