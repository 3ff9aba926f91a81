"""The load zone as a polar plot: the mean and the current normal force at the inner raceway over azimuth."""

from __future__ import annotations

import math

import numpy as np
import rerun as rr

from dcrb_ros.bearing.load_zone import mean_force, sector_azimuths
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.states import BodyNames
from dcrb_ros.viewer import columns, palette
from dcrb_ros.viewer.bearing_picture import thinned
from dcrb_ros.viewer.content import Content, Motion
from dcrb_ros.viewer.drawing import circle, on_circle
from dcrb_ros.viewer.spectrum_picture import log_texts

ROOT = "load_zone"
RADIUS = 100.0
"""Radius at the largest force of the scale [picture units]."""
SPACING = 3.0 * RADIUS
STEPS = 4
SPOKES = 12


def log_load_zone(content: Content, motion: Motion, largest: float) -> None:
    """Log the polar plot of every row, with a scale up to the ``largest`` force [N]."""
    motion = thinned(motion)
    log_static(content.bodies, largest)
    log_mean(content.bodies, motion, largest)
    log_now(content.bodies, motion, largest)


def log_static(bodies: BodyNames, largest: float) -> None:
    """Log the positions of the rows, and their scales."""
    for row in range(bodies.rows):
        path = f"{ROOT}/row{row + 1}"
        rr.log(path, rr.Transform3D(translation=[(row - 0.5 * (bodies.rows - 1)) * SPACING, 0.0, 0.0]), static=True)
        rr.log(f"{path}/now", rr.Arrows2D.from_fields(origins=[[0.0, 0.0]], radii=[1.4], draw_order=3.0), static=True)
        log_scale(path, largest, row)


def log_mean(bodies: BodyNames, motion: Motion, largest: float) -> None:
    """Log the mean force over azimuth as a line for every row."""
    for row in range(bodies.rows):
        points = on_circle(RADIUS * mean_force(*of_row(bodies, motion, row)) / largest, sector_azimuths())
        strip = np.concatenate([points, points[:1]])
        colour = palette.ROWS[row % len(palette.ROWS)]
        rr.log(f"{ROOT}/row{row + 1}/mean", rr.LineStrips2D([strip], radii=[1.2], colors=[colour], draw_order=2.0), static=True)


def of_row(bodies: BodyNames, motion: Motion, row: int) -> tuple[Floats, Floats]:
    """Return azimuth [rad] and normal force [N] of the rollers of a row, shape (times, rollers) each."""
    rollers = slice(row * bodies.rollers_per_row, (row + 1) * bodies.rollers_per_row)
    return motion.azimuth[:, rollers], motion.force[:, rollers]


def log_scale(path: str, largest: float, row: int) -> None:
    """Log circles of constant force and spokes every 30 degrees, with labels."""
    circles = [circle(RADIUS * (k + 1) / STEPS) for k in range(STEPS)]
    azimuths = np.linspace(math.pi, -math.pi, SPOKES, endpoint=False)
    spokes = [np.stack([np.zeros(2), on_circle(RADIUS, angle)]) for angle in azimuths]
    grid = rr.LineStrips2D([*circles, *spokes], radii=rr.Radius.ui_points(0.5), colors=[palette.FAINT], draw_order=0.0)
    rr.log(f"{path}/grid", grid, static=True)
    names = [f"{round(math.degrees(angle))}°" for angle in azimuths]
    log_texts(f"{path}/azimuths", on_circle(1.12 * RADIUS, azimuths), names, palette.MUTED, drop=6.0)
    at = on_circle(np.array([0.5, 1.0]) * RADIUS, math.radians(105.0))
    log_texts(f"{path}/forces", at, [f"{0.5 * largest / 1e3:g}", f"{largest / 1e3:g} kN"], palette.MUTED, drop=6.0)
    log_texts(f"{path}/name", np.array([[0.0, -1.32 * RADIUS]]), [f"row {row + 1}"], palette.BRIGHT, drop=6.0)


def log_now(bodies: BodyNames, motion: Motion, largest: float) -> None:
    """Log the force of every roller over time as an arrow from the centre."""
    for row in range(bodies.rows):
        azimuth, force = of_row(bodies, motion, row)
        tips = on_circle(RADIUS * np.clip(force / largest, 0.0, 1.25), azimuth)
        colours = palette.force_colours(force, largest)
        colours[force <= 0.0, 3] = 0
        arrows = columns.vectors(rr.Arrows2D.descriptor_vectors(), tips)
        colour = columns.colours(rr.Arrows2D.descriptor_colors(), colours)
        columns.send(f"{ROOT}/row{row + 1}/now", motion.time_ns, arrows, colour)
