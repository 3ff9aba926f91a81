"""A frame: the steps that the vehicle plans, and its bearings step, as one."""

from __future__ import annotations

from dataclasses import dataclass

from dcrb_ros.schema.arrays import Floats

TICK = 8
"""Steps between two ticks of the structure [-]."""
TICKS = 64
"""Ticks in a frame [-]."""
FRAME = TICK * TICKS
"""Steps in a frame, and between two values of the load [-]."""


@dataclass(frozen=True)
class TrackEvent:
    """A kink that a wheel met, or the beginning or end of a slide."""

    time: float
    """[s]"""
    place: float
    """Place on the track, from the start of the run [m]."""
    box: str
    """The box over the wheel, such as ``axle_1.left``; of a slide, the wheelset."""
    cause: str
    """joint, crossing, flat, slide or slide_end."""
    jump: float
    """Jump of velocity at a kink, or speed at which the wheels are to slide: the first one, at the end the largest [m/s]."""


@dataclass(frozen=True)
class Plan:
    """A frame before the bearings are stepped."""

    shaft_speed: Floats
    """Speed of each wheelset at the end of the frame, shape (axles,) [rad/s]."""
    load: Floats
    """Force on each inner ring in X and Y at the end of the frame, shape (boxes, 2) [N]."""
    motion: Floats
    """Vertical acceleration of the boxes by track and wheels, shape (boxes, `FRAME`) [m/s^2]."""
    speed: float
    """Speed of the vehicle at the start of the frame [m/s]."""
    place: float
    """Place of the middle of the bogie at the start of the frame, from the start of the run [m]."""
    creep: Floats
    """Share by which each wheelset turns faster than it rolls at the start of the frame; below zero in a slide, shape (axles,) [-]."""
    events: tuple[TrackEvent, ...]


@dataclass(frozen=True)
class Rolling:
    """The frame in which wheels roll: ticks of speed, place and angles, and the motion that they cause."""

    speed: Floats
    """Of the vehicle, shape (TICKS + 1,) [m/s]."""
    place: Floats
    """Of the middle of the bogie on the track, shape (TICKS + 1,) [m]."""
    creep: Floats
    """Of each wheelset, shape (axles, TICKS + 1) [-]."""
    angle: Floats
    """Of each wheelset, shape (axles, TICKS + 1) [rad]."""
    outputs: Floats
    """Accelerations of the boxes at the ticks, shape (TICKS, boxes) [m/s^2]."""
    loads: Floats
    """Dynamic loads below `dcrb_ros.vehicle.model.LOAD_CUTOFF` at the first tick, shape (boxes,) [N]."""
    slides: list[TrackEvent]
    """Slides that begin or end with the frame."""
