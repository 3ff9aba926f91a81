"""Tables of damaged raceways: continuity, shift, defects over a share of the length, growth under a roller, and rest in dents."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
from even_surfaces import EVEN
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from dcrb_ros.bearing.contact_path import envelope, reduced_radii
from dcrb_ros.bearing.damage_tables import RACEWAY_NODES
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.heights import TURN, interpolated, unpacked
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

SPACING = TURN / RACEWAY_NODES
SINGLE = 2e-12
"""Single precision of a height of 20 um [m]; the tables have it."""


def bench(spall: dict[str, Any] | None = None, **groups: Any) -> Configuration:
    """Return the lubricated bench with even surfaces, in which only a defect of the outer raceway has heights."""
    even = {f"surfaces.{name}": value for name, value in EVEN.items()} | {"surfaces.short_waves": 0, "surfaces.cage_unbalance": 0}
    steady = {"operating.speed_fluctuation": 0, "operating.speed_ripple": 0}
    defect = {f"faults.outer_1.{name}": value for name, value in (spall or {}).items()}
    return load_configuration("healthy", even | steady | defect | {key.replace("__", "."): value for key, value in groups.items()})


def spalled(**changes: Any) -> dict[str, Any]:
    """Return a spall over the whole length of both raceways, with some parameters changed."""
    return {"kind": "spall", "width": 2e-3, "depth": 6e-5, "row": 0, "share": 1.0} | changes


def table(configuration: Configuration) -> tuple[Floats, Floats]:
    """Return heights [m] and slopes [m/rad] of the outer raceway of row 1 at its nodes, the first one again."""
    heights, slopes = unpacked(build_payload(configuration).surfaces.raceways[1, 0])
    return heights, slopes


def test_a_rigid_roller_does_not_reach_the_troughs_of_a_steep_wave() -> None:
    """It lies on both flanks of a wave of 1 mm and 10 um, at t with a k sin(k t) = t/R beyond the trough's middle."""
    amplitude, length, radius = 10e-6, 1e-3, reduced_radii(Configuration())[1]
    k, spacing = TURN / length, length / 500.0
    path = envelope(amplitude * np.cos(k * spacing * np.arange(5001)), spacing, radius)[1000:4001]
    t = brentq(lambda t: amplitude * k * math.sin(k * t) - t / radius, 0.25 * length, 0.5 * length)
    assert path.min() == pytest.approx(-amplitude * math.cos(k * t) - t * t / (2.0 * radius), rel=2e-3)


def test_heights_and_slopes_of_a_spall_are_continuous_at_its_nodes_and_belong_together() -> None:
    heights, slopes = table(bench(spalled()))
    curve: Any = getattr(interpolated, "py_func", interpolated)
    begins, ends = (np.array(curve(heights[:-1], heights[1:], slopes[:-1], slopes[1:], SPACING, u)) for u in (0.0, 1.0))
    jump, kink = np.abs(np.roll(ends, 1, axis=1) - begins).max(axis=1)
    assert jump <= 1e-15  # [m]
    assert kink <= 1e-9  # [m/rad]
    heights, slopes = heights[:-1], slopes[:-1]
    differences = (np.roll(heights, -1) - np.roll(heights, 1)) / (2.0 * SPACING)
    assert np.dot(slopes, differences) / np.dot(differences, differences) == pytest.approx(1.0, abs=0.01)


def test_a_spall_moves_with_its_azimuth_also_across_the_first_node() -> None:
    nodes = 1000
    heights, shifted = (table(bench(spalled(azimuth=azimuth)))[0][:-1] for azimuth in (0.0, SPACING * nodes))
    assert np.abs(np.roll(heights, nodes) - shifted).max() <= SINGLE


@functools.cache
def samples(share: float | None) -> Floats:
    """Return the acceleration of the outer ring while rollers pass a spall four times [m/s^2]; without a share there is no spall."""
    simulation = Simulation(bench(None if share is None else spalled(share=share)), waveform_only=True)
    return np.concatenate([block.clean for block in simulation.blocks(0.03)]).astype(np.float64)


@pytest.mark.parametrize(("share", "limit"), [(1e-6, None), (1.0 - 1e-6, 1.0)])
def test_a_share_has_both_limits(share: float, limit: float | None) -> None:
    effect = np.abs(samples(1.0) - samples(None)).max()
    assert np.abs(samples(share) - samples(limit)).max() < 1e-3 * effect


def azimuths(simulation: Simulation) -> Floats:
    """Return the azimuths of the rollers from the load line, shape (rows, rollers) [rad]."""
    from_ring = simulation._state.roller_position[..., :2] - simulation._state.outer_position
    return np.asarray(np.arctan2(from_ring[..., 0], -from_ring[..., 1]))


def test_a_spall_that_grows_under_a_roller_relieves_it_by_the_stiffness_of_its_contact() -> None:
    """Between that of a roller between both raceways under 18 kN, 0.82 kN/um, and that of its outer contact alone, 1.9 kN/um."""
    simulation = Simulation(bench(spalled(width=1e-3), contact__loss_time=0), waveform_only=True)
    list(simulation.blocks(0.05))
    while np.abs(azimuths(simulation)).min() > 6e-4:  # a roller passes this range in two samples
        list(simulation.blocks(1.0 / 51200.0))
    at = np.unravel_index(np.abs(azimuths(simulation)).argmin(), azimuths(simulation).shape)
    grown, same = simulation.fork(), simulation.fork()
    grown.change({"faults.outer_1.width": 1.02e-3})
    grown._pending.apply(grown._apply)
    heights = []
    for each in (grown, same):
        # The first step: the roller gives way within the next ones.
        advance(each._payload, each._state, each._work, np.empty((1, 2)), np.empty(1))
        nodes = unpacked(each._payload.surfaces.raceways[1, at[0]])
        heights.append(float(CubicHermiteSpline(SPACING * np.arange(RACEWAY_NODES + 1), *nodes)(azimuths(each)[at] % TURN)))
    change = float((grown._state.outer_force - same._state.outer_force)[at] / (heights[0] - heights[1]))
    assert 0.82e9 < change < 1.9e9  # [N/m]


def test_a_bearing_that_rests_in_its_dents_carries_what_it_carries_without_them_and_lies_as_much_lower() -> None:
    rest, forces, drops = {}, {}, {}
    for name, dents in (("even", None), ("dented", {"kind": "brinelling", "width": 1.2e-3, "depth": 1e-5})):
        # The rows are in phase, so the rollers of both lie in dents, and one of each on the load line.
        rest[name] = bench(dents, operating__start="warm", bearing__row_phase=0)
        state = Simulation(rest[name])._state
        forces[name] = np.sort(state.outer_force[0])[-3:]
        drops[name] = float(state.outer_position[1] - state.inner_position[1])
    sag = float((table(rest["even"])[0] - table(rest["dented"])[0]).max())
    assert forces["dented"] == pytest.approx(forces["even"], rel=0.01)
    assert drops["dented"] - drops["even"] == pytest.approx(sag, rel=0.05)
