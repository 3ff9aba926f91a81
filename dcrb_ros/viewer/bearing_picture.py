"""The picture of the bearing in Rerun: fixed shapes are logged once, moving ones as columns over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import rerun as rr

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.block import Truth
from dcrb_ros.viewer import columns, palette
from dcrb_ros.viewer.columns import TIMELINE, time_column
from dcrb_ros.viewer.content import Content, Motion, Times
from dcrb_ros.viewer.drawing import Drawing, arc, circle, on_circle, quaternions, rounded_up
from dcrb_ros.viewer.row_faults import RacewayMark, RowFaults, faults_of_row

ROOT = "bearing"
PICTURE_RATE = 100.0
"""Largest rate of pictures in simulated time [Hz]."""
SCALE_STEPS = 4
Pictures = dict[str, rr.AsComponents]
"""Shapes by their entity path below a row."""
DEFECT_DEPTH = 1.4
"""Depth of a defect as drawn [mm]."""


def drawing_of(content: Content, motion: Motion) -> Drawing:
    """Return the geometry of the picture, with a force scale up to the largest normal force of the motion."""
    rollers = content.bodies.rows * content.bodies.rollers_per_row
    return Drawing(content.bearing, rounded_up(float(np.max(motion.force[:, :rollers], initial=0.0))))


def log_bearing(content: Content, motion: Motion, drawing: Drawing) -> None:
    """Log the moving bearing under `ROOT`."""
    motion = thinned(motion)
    log_static(drawing)
    log_force_scale(drawing)
    log_moving(drawing, motion)
    for row in range(content.bodies.rows):
        log_faults(drawing, row, content.truths, content.start_ns)
    largest = max((math.hypot(*truth.load) for truth in content.truths), default=0.0)
    log_load(drawing, content.truths, largest)


def thinned(motion: Motion) -> Motion:
    """Return the motion at `PICTURE_RATE` at most, since a screen shows no more."""
    if len(motion.time_ns) < 2:
        return motion
    spacing = float(np.median(np.diff(motion.time_ns))) / 1e9
    every = max(1, round(1.0 / (PICTURE_RATE * spacing)))
    return Motion(motion.time_ns[::every], motion.azimuth[::every], motion.speed[::every], motion.force[::every])


def log_static(drawing: Drawing) -> None:
    """Log the constant parts: positions, rings, sizes. All rows share the same shapes."""
    pictures = {**outer_ring(drawing), **inner_ring(drawing), **sizes(drawing)}
    for row in range(drawing.bearing.rows):
        path = f"{ROOT}/row{row + 1}"
        rr.log(path, rr.Transform3D(translation=[*drawing.centre(row), 0.0]), static=True)
        for part, picture in pictures.items():
            rr.log(f"{path}/{part}", picture, static=True)


def log_moving(drawing: Drawing, motion: Motion) -> None:
    """Log rotations, rollers and force bars of every row over time."""
    rows, count = drawing.bearing.rows, drawing.bearing.rollers_per_row
    for row in range(rows):
        path, of_row = f"{ROOT}/row{row + 1}", slice(row * count, (row + 1) * count)
        azimuth, force = motion.azimuth[:, of_row], motion.force[:, of_row]
        log_rotation(f"{path}/inner_ring", motion.time_ns, motion.azimuth[:, -1])
        log_rotation(f"{path}/cage", motion.time_ns, motion.azimuth[:, rows * count + row])
        log_rollers(drawing, f"{path}/rollers", motion.time_ns, azimuth, force)
        log_bars(drawing, f"{path}/normal_force", motion.time_ns, azimuth, force)


def sizes(drawing: Drawing) -> Pictures:
    """Return the sizes and drawing order of the moving shapes."""
    return {
        "rollers": rr.Points2D.from_fields(radii=[drawing.roller], draw_order=4.0),
        "normal_force": rr.LineStrips2D.from_fields(radii=[0.2 * drawing.roller], draw_order=4.0),
        "load": rr.Arrows2D.from_fields(radii=[1.6], colors=[palette.LOAD], draw_order=5.0),
        "load/size": rr.Points2D.from_fields(radii=[0.01], colors=[palette.LOAD], show_labels=True),
    }


def outer_ring(drawing: Drawing) -> Pictures:
    """Return the outer ring, the force scale around it and the position of the row's name."""
    middle, half = 0.5 * (drawing.outer_raceway + drawing.rim), 0.5 * drawing.ring_thickness
    rings = [circle(middle), circle(drawing.outer_raceway), circle(drawing.rim)]
    colours = [palette.STEEL, palette.STEEL_EDGE, palette.STEEL_EDGE]
    steps = [drawing.bars_start + drawing.bars_length * k / SCALE_STEPS for k in range(SCALE_STEPS + 1)]
    arcs = [arc(radius, -0.75 * math.pi, 0.75 * math.pi) for radius in steps]
    above = on_circle(drawing.rim + 1.6 * drawing.roller, math.pi)
    return {
        "outer_ring": rr.LineStrips2D(rings, radii=[half, 0.5, 0.35], colors=colours, draw_order=1.0),
        "force_scale": rr.LineStrips2D(arcs, radii=[0.25], colors=[palette.FAINT], draw_order=0.0),
        "name": rr.Points2D.from_fields(positions=[above], radii=[0.01], show_labels=True),
    }


def inner_ring(drawing: Drawing) -> Pictures:
    """Return the inner ring with a mark that shows its rotation."""
    middle, half = 0.5 * (drawing.inner_raceway + drawing.bore), 0.5 * (drawing.inner_raceway - drawing.bore)
    rings = [circle(middle), circle(drawing.inner_raceway), circle(drawing.bore)]
    colours = [palette.STEEL, palette.STEEL_EDGE, palette.STEEL_EDGE]
    mark = [on_circle(np.array([drawing.bore + 0.25 * half, drawing.inner_raceway - 0.25 * half]), 0.0)]
    return {
        "inner_ring": rr.LineStrips2D(rings, radii=[half, 0.5, 0.35], colors=colours, draw_order=1.0),
        "inner_ring/mark": rr.LineStrips2D(mark, radii=[1.1], colors=[palette.BRIGHT], draw_order=3.0),
    }


def log_rotation(path: str, time_ns: Times, angle: Floats) -> None:
    """Log the rotation of everything under ``path``: ``angle`` over time, shape (times,) [rad]."""
    rr.send_columns(path, [time_column(time_ns)], rr.Transform3D.columns(quaternion=quaternions(angle)))


def log_rollers(drawing: Drawing, path: str, time_ns: Times, azimuth: Floats, force: Floats) -> None:
    """Log the rollers of a row, coloured by their normal force."""
    colours = columns.colours(rr.Points2D.descriptor_colors(), palette.force_colours(force, drawing.largest_force))
    positions = columns.vectors(rr.Points2D.descriptor_positions(), on_circle(drawing.pitch, azimuth))
    columns.send(path, time_ns, positions, colours)


def log_bars(drawing: Drawing, path: str, time_ns: Times, azimuth: Floats, force: Floats) -> None:
    """Log a radial bar outside the ring for the normal force of every roller; shapes (times, rollers) [rad], [N]."""
    colours = palette.force_colours(force, drawing.largest_force)
    colours[force <= 0.0, 3] = 0
    strips = columns.strips(drawing.bars(azimuth, force))
    columns.send(path, time_ns, strips, columns.colours(rr.LineStrips2D.descriptor_colors(), colours))


def log_faults(drawing: Drawing, row: int, truths: Sequence[Truth], start_ns: int, shown: RowFaults | None = None) -> RowFaults:
    """Log the faults of a row whenever the ground truth changes them; return the last ones. ``shown`` are already drawn."""
    if shown is None:
        shown = RowFaults()
        log_row_faults(drawing, row, start_ns, shown)
    known = None
    for truth in truths:
        if truth.faults is known:
            continue
        known, faults = truth.faults, faults_of_row(truth, row)
        if faults != shown:
            log_row_faults(drawing, row, truth.time_ns, faults)
            shown = faults
    return shown


def log_row_faults(drawing: Drawing, row: int, time_ns: int, faults: RowFaults) -> None:
    """Log the defects and the cage bars of a row from ``time_ns`` on, and the names of its faults above it."""
    rr.set_time(TIMELINE, timestamp=np.datetime64(time_ns, "ns"))
    path = f"{ROOT}/row{row + 1}"
    log_defects(drawing, path, faults.raceways)
    for part, picture in cage(drawing, faults.bars).items():
        rr.log(f"{path}/{part}", picture)
    label = ", ".join([f"row {row + 1}", *faults.words])
    rr.log(f"{path}/name", rr.Points2D.from_fields(labels=[label], colors=[palette.DEFECT if any(faults) else palette.MUTED]))


def log_defects(drawing: Drawing, path: str, faults: Sequence[RacewayMark]) -> None:
    """Log the raceway defects of a row; those of the inner ring rotate with it."""
    sides = {
        "outer_ring": (f"{path}/defect", drawing.outer_raceway + DEFECT_DEPTH),
        "inner_ring": (f"{path}/inner_ring/defect", drawing.inner_raceway - DEFECT_DEPTH),
    }
    for ring, (part, radius) in sides.items():
        arcs = [drawing.defect(radius, fault.azimuth, fault.width) for fault in faults if fault.ring == ring]
        rr.log(part, rr.LineStrips2D(arcs, radii=[1.3 * DEFECT_DEPTH], colors=[palette.DEFECT], draw_order=6.0))


@lru_cache(4)
def cage(drawing: Drawing, broken: tuple[int, ...]) -> Pictures:
    """Return the bars of a cage; a broken bar is replaced by a radial mark in the colour of a defect."""
    bars = drawing.cage_bars()
    whole = [bar for number, bar in enumerate(bars, start=1) if number not in broken]
    missing = [drawing.broken_bar(number) for number in broken if number <= len(bars)]
    return {
        "cage": rr.LineStrips2D(whole, radii=[0.24 * drawing.roller], colors=[palette.BRASS], draw_order=2.0),
        "cage/broken": rr.LineStrips2D(missing, radii=[0.13 * drawing.roller], colors=[palette.DEFECT], draw_order=6.0),
    }


def log_load(drawing: Drawing, truths: Sequence[Truth], largest: float) -> None:
    """Log the load on the inner ring as an arrow in the bore of every row; the ``largest`` load has the full length [N]."""
    if not truths:
        return
    load = np.array([truth.load for truth in truths])
    size = np.hypot(load[:, 0], load[:, 1])
    length = 0.8 * drawing.bore * size / max(largest, 1e-9)
    direction = load * [1.0, -1.0] / np.maximum(size, 1e-9)[:, None]
    vectors = direction * length[:, None]
    times = time_column(np.array([truth.time_ns for truth in truths]))
    rows = " on both rows" if drawing.bearing.rows > 1 else ""
    labels = [f"{value / 1e3:.4g} kN{rows}" for value in size]
    for row in range(drawing.bearing.rows):
        path = f"{ROOT}/row{row + 1}/load"
        rr.send_columns(path, [times], rr.Arrows2D.columns(vectors=vectors, origins=-0.1 * vectors))
        positions = -0.75 * drawing.bore * direction
        rr.send_columns(f"{path}/size", [times], rr.Points2D.columns(positions=positions, labels=labels))


def log_force_scale(drawing: Drawing) -> None:
    """Log the colour scale of the normal force below the picture."""
    half = 0.5 * (drawing.centre(drawing.bearing.rows - 1)[0] - drawing.centre(0)[0]) or drawing.outer_raceway
    y, steps = drawing.extent + 0.9 * drawing.roller, 64
    x = np.linspace(-0.5 * half, 0.5 * half, steps + 1)
    strips = np.stack([np.stack([x[:-1], np.full(steps, y)], -1), np.stack([x[1:], np.full(steps, y)], -1)], axis=1)
    colours = palette.force_colours(np.linspace(1e-3, 1.0, steps), 1.0)
    rr.log(f"{ROOT}/scale", rr.LineStrips2D(strips, radii=[2.0], colors=colours), static=True)
    values = [f"{drawing.largest_force * share / 1e3:g}" for share in (0.0, 0.5)] + [f"{drawing.largest_force / 1e3:g} kN"]
    positions = np.array([[x[0], y + 9.0], [0.0, y + 9.0], [x[-1], y + 9.0]])
    rr.log(f"{ROOT}/scale/values", rr.Points2D(positions, radii=0.01, labels=values, show_labels=True, colors=[palette.MUTED]), static=True)
