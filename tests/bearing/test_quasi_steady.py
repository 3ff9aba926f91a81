"""A bearing that runs steadily, without the time loop: its temperatures, and what becomes of it without lubricant."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dcrb_ros.bearing.heat_network import contact_conductance
from dcrb_ros.bearing.load_distribution import roller_forces
from dcrb_ros.bearing.lubricant_condition import lubrication_at
from dcrb_ros.bearing.quasi_steady import QuasiSteady, raceway_conductance
from dcrb_ros.bearing.thermal_fit import Growth, expansion, work_of_growth
from dcrb_ros.core.laws.site import inner_site
from dcrb_ros.diagnosis.wayside import RING_SHARE, WaysideParameters
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.loaded_contacts import material_of

INNER, ROLLERS, OUTER, BOX = 0, 2, 4, 6
"""Nodes of row 1, and the box."""


def bench(**values: Any) -> Configuration:
    """Return the bearing of Table 1 with grease and a thermal network."""
    changes = {key.replace("__", "."): value for key, value in values.items()}
    return load_configuration("dry", {"lubrication.law": "film", "thermal.law": "network", **changes})


def test_rigid_rings_share_the_load_as_in_the_equilibrium() -> None:
    forces = roller_forces(bench(), 100e3 + 7.316 * 9.81, 0.28e-3)
    assert forces[0].max() == pytest.approx(30251.0, rel=1e-3)  # docs/explanation/lubrication.md, most loaded roller
    assert sorted(forces[0])[-2] == pytest.approx(10708.0, rel=1e-3)


def test_a_preload_presses_on_every_roller() -> None:
    assert roller_forces(bench(), 100e3, -2e-5).min() > 1e3


@pytest.mark.parametrize(
    ("changes", "power", "rises"),
    [
        # Steady states at 20 deg C outside: power [W], rises of outer ring and box above ambient [K].
        ({}, 849.0, (21.9, 15.5)),
        ({"thermal__air_speed": 22.5}, 788.0, (30.9, 25.3)),
        ({"operating__speed": 62.832}, 409.0, (14.4, 11.4)),
        ({"lubrication__lubricant": "vg100"}, 1268.0, (32.8, 23.2)),
        ({"lubrication__lubricant": "vg220"}, 1508.0, (38.9, 27.6)),
    ],
)
def test_steady_states_are_those_of_the_estimate(changes: dict[str, Any], power: float, rises: tuple[float, float]) -> None:
    steady = QuasiSteady(bench(**changes))
    running = steady.running()
    found = steady.steady(running)
    assert sum(sum(row) for row in steady.power(running, found)) == pytest.approx(power, rel=0.1)
    assert found[OUTER] - 20.0 == pytest.approx(rises[0], rel=0.1)
    assert found[BOX] - 20.0 == pytest.approx(rises[1], rel=0.1)


@pytest.mark.parametrize("kmh", [100.0, 160.0, 200.0])
def test_a_healthy_axle_box_is_10_to_45_kelvin_above_ambient(kmh: float) -> None:
    steady = QuasiSteady(load_configuration("healthy", {"thermal.law": "network", "operating.speed_kmh": kmh}))
    rises = [one - 20.0 for one in steady.steady(steady.running())]
    assert 10.0 < rises[BOX] < max(rises) < 45.0


@pytest.mark.parametrize("lubricant", ["vg100", "vg220"])
def test_warm_oil_loses_less_and_the_steady_state_is_one(lubricant: str) -> None:
    steady = QuasiSteady(bench(lubrication__lubricant=lubricant))
    running = steady.running()
    warm, from_above = steady.steady(running), steady.steady(running, start=[90.0] * 7)
    assert from_above == pytest.approx(warm, abs=1e-6)
    assert sum(map(sum, steady.power(running, warm))) < 0.7 * sum(map(sum, steady.power(running, [20.0] * 7)))


def test_starved_raceways_heat_most_at_some_35_degrees() -> None:
    steady = QuasiSteady(bench())
    running = steady.running()
    heat = {film: sum(row[0] + row[1] for row in steady.power(running, [film] * 7)) for film in (0.0, 20.0, 35.0, 50.0, 80.0)}
    assert heat[0.0] < 0.6 * heat[35.0]  # the inlet starves faster than the oil becomes viscous
    assert heat[20.0] < heat[35.0] > heat[50.0]
    assert heat[80.0] < 0.7 * heat[35.0]


@pytest.mark.parametrize(
    ("law", "more", "rises"),
    [
        # Cold outside or not, the films of starved raceways are on either side of their greatest heat.
        ("film", (-0.5, 0.0), (21.84, 22.07)),
        # An estimate with the shear of oil at the lands of the cages has 23.3 K at 0 deg C and 21.9 K at 20 deg C at the outer ring.
        ("film_with_cages", (0.8, 1.6), (23.3, 21.9)),
    ],
)
def test_cold_outside_a_bearing_rises_more_only_by_the_oil_about_its_cages(
    law: str, more: tuple[float, float], rises: tuple[float, float]
) -> None:
    found = []
    for ambient in (0.0, 20.0):
        steady = QuasiSteady(bench(lubrication__law=law, thermal__ambient=ambient))
        found.append(steady.steady(steady.running())[OUTER] - ambient)
    assert found == pytest.approx(rises, rel=0.05)
    assert more[0] < found[0] - found[1] < more[1]


def test_at_standstill_there_is_no_heat() -> None:
    steady = QuasiSteady(bench(operating__speed=0.0))
    running = steady.running()
    assert steady.power(running, [20.0] * 7) == [(0.0, 0.0, 0.0)] * 2
    assert steady.steady(running) == [20.0] * 7


def test_rings_of_one_temperature_keep_the_clearance_and_a_hot_inner_ring_takes_it() -> None:
    c = bench()
    network = QuasiSteady(c).network
    assert expansion(c, network, [70.0] * 7).clearance == pytest.approx(11.9e-6 * 50.0 * 280e-6, rel=1e-6)  # 0.17 um
    hot = [80.0 if node in (0, 1) else 20.0 for node in range(7)]
    assert expansion(c, network, hot).clearance == pytest.approx(-56e-6, rel=0.01)
    held = bench(thermal__seat_restraint=1.0)
    assert expansion(held, network, [70.0] * 7).clearance == pytest.approx(-11.9e-6 * 50.0 * (0.07886 + 0.03), rel=1e-6)


def test_growth_works_against_the_forces_that_it_presses_together() -> None:
    """Of 15 kN at the inner raceway and 20 kN at the outer one: a larger outer raceway gives way, all else presses."""
    state: Any = SimpleNamespace(inner_force=np.array([[10e3, 5e3]]), outer_force=np.array([[20e3, 0.0]]))
    work = [work_of_growth(state, Growth(*parts)) for parts in ((1e-6, 0.0, 0.0), (0.0, 1e-6, 0.0), (0.0, 0.0, 1e-6))]
    assert work == pytest.approx([15e-3, -20e-3, 35e-3], rel=1e-12)  # inner and outer raceway, rollers [J]


def test_a_bearing_that_loses_its_lubricant_first_cools_and_then_runs_hot() -> None:
    steady = QuasiSteady(bench())
    running = steady.running()
    found = steady.steady(running)
    start, least, alarmed = found[OUTER], found[OUTER], None
    for step in range(540):  # three hours in steps of 20 s; the loss takes the first hour and a half
        loss = min(step * 20.0 / 5400.0, 1.0)
        found = steady.after(running, found, 20.0, loss)
        least = min(least, found[OUTER])
        if alarmed is None and found[BOX] + RING_SHARE * (found[OUTER] - found[BOX]) - 20.0 > WaysideParameters().above_ambient:
            alarmed = step * 20.0
    assert least < start - 5.0
    assert found[OUTER] > 150.0
    assert alarmed is not None
    assert 15.0 < (alarmed - 5400.0) / 60.0 < 35.0  # minutes after the last lubricant; 24 with these heat capacities and frictions


def test_an_overfilled_bearing_and_rubbing_seals_run_hotter() -> None:
    healthy = QuasiSteady(bench())
    sound = healthy.steady(healthy.running())
    # 32 rollers with 0.5 x 860.75 kg/m^3 x 0.05 x 1.1 x 30 mm x 48 mm x (4.962 m/s)^3 each; 1 Nm at both rows at 125.664 rad/s [W].
    for fault, expected in (({"faults__overfilled__share": 0.05}, 133.3), ({"faults__seal_rub__torque": 1.0}, 251.3)):
        steady = QuasiSteady(bench(**fault))
        running = steady.running()
        added = sum(map(sum, steady.power(running, sound))) - sum(map(sum, healthy.power(healthy.running(), sound)))
        assert added == pytest.approx(expected, rel=1e-3)
        assert steady.steady(running)[BOX] > sound[BOX] + 1.5


def test_contacts_with_a_raceway_conduct_side_by_side() -> None:
    """Of these rollers two are loaded, one touches through its film, and one does not touch."""
    site = inner_site(material_of(bench().bearing))
    # Half-widths of 297 um under 30 kN and of 171 um under 10 kN, from (4 F R / (pi L E*))^(1/2) with R = 12.60 mm, E* = 114.01 GPa.
    loaded = contact_conductance(2.966e-4, 0.048, 5.75) + contact_conductance(1.712e-4, 0.048, 5.75)
    found = raceway_conductance(np.array([30e3, 10e3, 20.0, 0.0]), site, 0.048, 5.75)
    assert found == pytest.approx(loaded + 0.448 + 2.0, rel=1e-3)  # an idle contact, and grease [W/K]


def test_pinned_rollers_lose_nothing_to_the_oil_about_them() -> None:
    """Of oil about the cage the lands remain, docs/explanation/lubrication.md."""
    oiled = {"lubrication.law": "film_with_cages", "thermal.law": "network"}
    lost = []
    for joint in ("pocket", "revolute"):
        steady = QuasiSteady(load_configuration("dry", {**oiled, "cage.joint": joint}))
        lost.append(steady._rest(lubrication_at(steady.configuration, steady._material, 0.0, 60.0, 60.0), steady.running(), 0.0))
    assert 1.0 < lost[0] - lost[1] < 100.0
