"""Comparisons of tables of heights: continuity, defects over a share of the length, growth, and a bearing at rest in its dents."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from dcrb_ros.bearing.contact_path import envelope, reduced_radii
from dcrb_ros.bearing.damage_tables import RACEWAY_NODES
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.bearing.surfaces import between_nodes
from dcrb_ros.core.contacts.heights import TURN, interpolated, unpacked
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.validation.oiled_runs import EVEN, HEALTHY, SPALL, SPALLED
from dcrb_ros.validation.report_row import ReportRow, about, between

CHAPTER = "Surfaces with heights"
AMPLITUDE, LENGTH = 10e-6, 1e-3
"""Of the wave whose troughs a rigid roller does not reach [m]."""
PASSES = 0.03
"""Simulated time in which a spall is passed four times [s]."""
SETTLING, SAMPLE = 0.05, 1.0 / 51200.0
"""Simulated time before a spall grows, and of a sample [s]."""
MIDDLE = 6e-4
"""Angle within which a roller lies in the middle of the spall [rad]; it passes in two samples."""
NARROW = (*SPALLED, "faults.outer_1.width=0.001", "faults.outer_1.share=1", "contact.loss_time=0")
"""A spall over which a loaded roller remains in contact."""
GROWTH = 2e-5
"""By how much it grows [m]."""
STIFFNESS = 0.82, 1.9
"""Of a roller between both raceways under 18 kN, and of its outer contact alone, before the roller gives way [kN/um]."""
SHIFT = 1000
"""By how many nodes a spall is shifted; at the azimuth zero it lies across the first node."""
SINGLE = 2e-12
"""Single precision of a height of 20 um [m]; the tables have it."""
BRINELLED = ("faults.outer_1.kind=brinelling", "faults.outer_1.width=0.0012", "faults.outer_1.depth=1e-5")


def height_rows() -> Iterator[ReportRow]:
    """Yield the comparisons; they need runs of some hundredths of a second only."""
    yield from table_rows()
    yield from share_rows()
    yield between(
        CHAPTER,
        "Change of a contact's force in the step in which the spall under it grows, over that of the height",
        growth_force(),
        *STIFFNESS,
        "kN/um",
    )
    (forces, drop), (even, at_rest) = (resting(settings) for settings in (BRINELLED, ()))
    yield about(CHAPTER, "Largest forces of a bearing that rests in its dents, by those without", forces, even, 0.01, "kN")
    yield about(CHAPTER, "By how much it lies lower", drop - at_rest, felt_depth(BRINELLED), 0.05, "um")


def table_rows() -> Iterator[ReportRow]:
    """Yield the comparisons of heights that need no run."""
    radius = reduced_radii(Configuration())[1]
    spacing = LENGTH / 500.0
    wave = AMPLITUDE * np.cos(2.0 * math.pi / LENGTH * spacing * np.arange(5001))
    felt = envelope(wave, spacing, radius)[1000:4001]
    yield about(
        CHAPTER,
        "Lowest path of a rigid roller over a wave of 1 mm and 10 um, outer raceway",
        1e6 * felt.min(),
        1e6 * trough(radius),
        2e-3,
        "um",
    )
    value, slope = jumps()
    yield between(CHAPTER, "Largest jump of a height at the nodes of the spalled raceway", value, 0.0, 1e-15, "m")
    yield between(CHAPTER, "Largest jump of its slope there", slope, 0.0, 1e-9, "m/rad")
    yield about(CHAPTER, "Slopes of that table over those of its heights", slope_ratio(), 1.0, 0.01)
    yield between(CHAPTER, "Change of a spall's heights as it is shifted away from the first node", shift_change(), 0.0, SINGLE, "m")


def trough(radius: float) -> float:
    """Return the lowest path over the wave [m]: on both flanks at t, with a k sin(k t) = t/R beyond the trough's middle."""
    k = 2.0 * math.pi / LENGTH
    low, high = 0.25 * LENGTH, 0.5 * LENGTH
    for _ in range(60):
        t = 0.5 * (low + high)
        low, high = (t, high) if AMPLITUDE * k * math.sin(k * t) > t / radius else (low, t)
    return -AMPLITUDE * math.cos(k * low) - low * low / (2.0 * radius)


def spalled_table(*settings: str) -> tuple[Floats, Floats]:
    """Return heights [m] and slopes [m/rad] of the outer raceway with a spall over the whole length at its nodes, the first one again."""
    given = load_configuration(SPALL, (*SPALLED, "faults.outer_1.share=1", *settings))
    heights, slopes = unpacked(build_payload(given).surfaces.raceways[1, 0])
    return heights, slopes


def jumps() -> tuple[float, float]:
    """Return the largest jumps of height [m] and slope [m/rad] between the curves on both sides of a node."""
    heights, slopes = spalled_table()
    spacing = TURN / (len(heights) - 1)
    curve: Any = getattr(interpolated, "py_func", interpolated)
    given = heights[:-1], heights[1:], slopes[:-1], slopes[1:], spacing
    begins, ends = (np.array(curve(*given, u)) for u in (0.0, 1.0))
    value, slope = np.abs(np.roll(ends, 1, axis=1) - begins).max(axis=1)
    return float(value), float(slope)


def shift_change() -> float:
    """Return the change of the heights of a spalled raceway as the spall is shifted, without the shift itself [m]."""
    (heights, _), nodes = spalled_table(*EVEN, "faults.outer_1.azimuth=0"), RACEWAY_NODES
    shifted, _ = spalled_table(*EVEN, f"faults.outer_1.azimuth={TURN * SHIFT / nodes!r}")
    return float(np.abs(np.roll(heights[:-1], SHIFT) - shifted[:-1]).max())


def slope_ratio() -> float:
    """Return the factor between the slopes of the table and the central differences of its heights, by least squares [-]."""
    heights, slopes = (values[:-1] for values in spalled_table())
    by_differences = (np.roll(heights, -1) - np.roll(heights, 1)) / (2.0 * TURN / len(heights))
    return float(np.dot(slopes, by_differences) / np.dot(by_differences, by_differences))


def share_rows() -> Iterator[ReportRow]:
    """Yield the limits of a defect over a share of the length: the share 0 and the share 1."""
    none, least, most, whole = (samples(share) for share in (None, 1e-6, 1.0 - 1e-6, 1.0))
    change = float(np.abs(whole - none).max())
    yield between(
        CHAPTER, "Samples with a spall over 1e-6 of the length, over the effect of a whole one", _apart(least, none, change), 0.0, 1e-3
    )
    yield between(CHAPTER, "Samples with a spall over all but 1e-6 of the length, the same", _apart(most, whole, change), 0.0, 1e-3)


def _apart(samples: Floats, others: Floats, scale: float) -> float:
    return float(np.abs(samples - others).max()) / scale


def samples(share: float | None) -> Floats:
    """Return the acceleration of the outer ring with a spall over a share of the length, or without one, shape (samples, 2) [m/s^2]."""
    spall = () if share is None else (*SPALLED, f"faults.outer_1.share={share!r}")
    blocks = Simulation(load_configuration(HEALTHY, (*EVEN, *spall)), waveform_only=True).blocks(PASSES)
    return np.concatenate([block.clean for block in blocks]).astype(np.float64)


def growth_force() -> float:
    """Return by how much the force of the contact in a spall's middle changes as the spall grows, over the change of its height [kN/um]."""
    simulation = Simulation(load_configuration(HEALTHY, (*EVEN, *NARROW)), waveform_only=True)
    list(simulation.blocks(SETTLING))
    while np.abs(azimuths(simulation)).min() > MIDDLE:
        list(simulation.blocks(SAMPLE))
    at = np.unravel_index(np.abs(azimuths(simulation)).argmin(), azimuths(simulation).shape)
    grown, same = simulation.fork(), simulation.fork()
    grown.change({"faults.outer_1.width": simulation.configuration.faults.outer_1.width + GROWTH})
    grown._apply_commands()
    heights = []
    for each in (grown, same):
        # The first step: the roller gives way within the next ones.
        advance(each._payload, each._state, each._work, np.empty((1, 2)), np.empty(1))
        table = unpacked(each._payload.surfaces.raceways[1, at[0]])
        heights.append(float(between_nodes(*table, azimuths(each)[at])))
    return 1e-9 * float((grown._state.outer_force - same._state.outer_force)[at] / (heights[0] - heights[1]))


def azimuths(simulation: Simulation) -> Floats:
    """Return the azimuths of the rollers from the load line, shape (rows, rollers) [rad]."""
    from_ring = simulation._state.roller_position[..., :2] - simulation._state.outer_position
    return np.asarray(np.arctan2(from_ring[..., 0], -from_ring[..., 1]))


def resting(settings: tuple[str, ...]) -> tuple[Floats, float]:
    """Return the three largest forces at the outer raceway of row 1 [kN] of a bearing at rest, and how low its inner ring lies [um]."""
    state = Simulation(at_rest(settings))._state
    return np.sort(state.outer_force[0])[-3:] / 1e3, -1e6 * float(state.inner_position[1] - state.outer_position[1])


def at_rest(settings: tuple[str, ...]) -> Configuration:
    """Return a bearing whose rows lie in phase, so that the rollers of both lie in dents, and one of each on the load line."""
    return load_configuration(HEALTHY, (*EVEN, "operating.start=warm", "bearing.row_phase=0", *settings))


def felt_depth(settings: tuple[str, ...]) -> float:
    """Return the depth to which a roller sinks into the deepest dent [um]."""
    felt, even = (unpacked(build_payload(at_rest(given)).surfaces.raceways[1, 0])[0] for given in (settings, ()))
    return 1e6 * float((even - felt).max())
