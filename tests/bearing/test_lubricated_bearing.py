"""The whole bench with an oil film: its energy, its losses, and its limits."""

from __future__ import annotations

import functools
import itertools
from typing import Any

import numpy as np
import pytest
from even_surfaces import EVEN
from oil_films import inner_film, outer_film, resistance

from dcrb_ros.bearing.film_observation import friction_losses
from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.core.laws.film import thickness_under
from dcrb_ros.core.laws.film_thickness import asperity_share
from dcrb_ros.core.observation import LOADED_FORCE
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.states import FRICTION_SOURCES, LubricationState, States

pytestmark = pytest.mark.slow  # the kernels of oil at the raceways only are compiled for it

SHAFT = 125.664  # rad/s, 1200 rpm
FILM = {"law": "film", "lubricant": "vg100", "temperature": 70.0}


def bench(**groups: dict[str, Any]) -> Simulation:
    """Return a lubricated bench with 1000 states a second."""
    given: dict[str, dict[str, Any]] = {
        "lubrication": FILM,
        "friction": {"convection": 0.7},
        "contact": {"loss_time": 1e-5},
        "publishing": {"state_rate": 1000},
        "sensor": {"noise_density": 0.0},
    }
    found = {name: given.get(name, {}) | groups.get(name, {}) for name in {*given, *groups}}
    # The dry bench has smooth surfaces, whose kernels are compiled anyway, too.
    surfaces = EVEN if found["lubrication"]["law"] == "film" else {}
    return Simulation(Configuration.model_validate({"surfaces": surfaces, **found}))


@functools.cache
def run(duration: float, **lubrication: Any) -> tuple[Simulation, list[States]]:
    """Return a bench with some parameters of lubrication after a time [s], and its states."""
    simulation = bench(lubrication=FILM | lubrication)
    return simulation, [states for block in simulation.blocks(duration) for states in block.states]


def lubrication(states: States) -> LubricationState:
    """Return films and losses."""
    assert states.lubrication is not None
    return states.lubrication


def lost(states: States, source: str) -> float:
    """Return the energy that both rows have lost by a source since the start [J]."""
    return float(lubrication(states).friction_loss[:, FRICTION_SOURCES.index(source)].sum())


def power(states: list[States], source: str) -> float:
    """Return the power lost by a source over the second half of some states [W]."""
    first, last = states[len(states) // 2], states[-1]
    return (lost(last, source) - lost(first, source)) / (1e-9 * (last.time_ns - first.time_ns))


def test_the_energy_account_closes() -> None:
    simulation, _ = run(0.2)
    account = simulation.energy
    assert account.drive > 50.0
    assert abs(account.residual) < 1e-3 * account.drive


def test_no_film_gives_energy_to_a_roller() -> None:
    simulation = bench()
    rollers = simulation._state.rollers[0]
    before: list[Any] = [0.0, 0.0]
    for _ in simulation.blocks(0.1):
        for n, losses in enumerate((rollers.contact_loss, rollers.rolling_loss)):
            now = simulation._state.of_rollers(losses).copy()
            assert (now >= before[n]).all()
            before[n] = now
    assert before[1].min() > 0.0


def test_rolling_takes_twice_the_resistance_times_the_speed() -> None:
    # Biboulet and Houpert 2010, Part 1, section 4: the power lost is 2 F_R |V|, at both raceways.
    _, states = run(0.2)
    half, expected, work = states[len(states) // 2 :], 0.0, bench()
    inner, outer = work._payload.inner.film, work._payload.outer.film
    orbit = np.mean([s.speed[32:34].mean() for s in half])
    radii = work.configuration.bearing
    passing = (SHAFT - orbit) * radii.inner_raceway_radius, orbit * radii.outer_raceway_radius
    for s in half:
        for film, forces, speed in ((inner, s.inner_force, passing[0]), (outer, s.outer_force, passing[1])):
            expected += sum(2.0 * abs(resistance(film, float(force))) * speed for force in forces[:32] if force > 1.0) / len(half)
    assert power(states, "rolling") == pytest.approx(expected, rel=0.02)


def test_idle_rollers_on_the_outer_raceway_lose_twice_the_resistance_times_the_speed() -> None:
    # Without load and weight the rollers touch the outer raceway only, under their centrifugal force; they begin in pure rolling.
    simulation = bench(operating={"load": 0.0, "gravity": 0.0})
    states = [s for block in simulation.blocks(0.04) for s in block.states]
    orbit = states[-1].speed[32]
    force = float(np.median(states[-1].outer_force[:32]))
    assert force == pytest.approx(simulation._payload.roller_mass * orbit**2 * 0.094, rel=0.05)
    speed = float(orbit) * 0.10914
    against = abs(resistance(outer_film(SHAFT, layer=50e-6), force))
    taken = lost(states[-1], "rolling") - lost(states[0], "rolling")
    assert taken / (1e-9 * (states[-1].time_ns - states[0].time_ns)) == pytest.approx(32 * 2.0 * against * speed, rel=0.15)


def test_the_shaft_does_the_work_of_rolling() -> None:
    with_it, without = (run(0.2, rolling_resistance=resists)[0].energy for resists in (True, False))
    assert with_it.drive - without.drive == pytest.approx(lost(run(0.2)[1][-1], "rolling"), rel=0.15)


def test_a_thin_layer_resists_rolling_less_and_loads_the_asperities_more() -> None:
    thick, thin = (run(0.2, **oil)[1] for oil in ({}, {"lubricant": "grease", "layer": 1e-6}))
    assert power(thin, "rolling") < 0.6 * power(thick, "rolling")
    shares = [asperity_share(float(lubrication(states[-1]).film_ratio[0])) for states in (thin, thick)]
    assert shares[0] > 2.0 * shares[1] > 0.0


@pytest.mark.parametrize(("speed", "target"), [(0.0, 0.0), (5.0, -5.0)])
def test_standstill_and_reversal_do_not_diverge(speed: float, target: float) -> None:
    simulation = bench(operating={"speed": speed, "speed_ramp": 200.0})
    if target != speed:
        simulation.command_speed(target)
    states = [s for block in simulation.blocks(0.1) for s in block.states]
    assert np.isfinite(states[-1].inner_force).all()
    assert max(s.inner_force[:32].max() for s in states) < 5e4
    assert max(np.abs(s.speed[:32]).max() for s in states) < 100.0
    assert abs(simulation.energy.residual) < 0.1


def test_a_vanishing_film_has_the_forces_of_the_dry_bench() -> None:
    dry_friction = {"kinetic_coefficient": 0.05, "static_coefficient": 0.05}
    thin = {"law": "film", "lubricant": "custom", "viscosity_40": 3.0, "viscosity_100": 1.3, "temperature": 40.0}
    thin |= {"pressure_coefficient": 1e-8, "layer": 1e-9}
    rough = {"boundary_friction": 0.05, "limiting_friction": 0.05, "squeeze": False, "rolling_resistance": False}
    found = []
    for oil in (thin | rough, {"law": "dry"}):
        simulation = bench(friction=dry_friction | {"convection": 0.7}, contact={"loss_time": 2.5e-6}, lubrication=oil)
        states = [s for block in simulation.blocks(0.1) for s in block.states]
        loaded = states[-1].inner_force[:32] > 3e3
        found.append((states, loaded, simulation.energy))
    (lubricated, at, oiled), (dry, dry_at, account) = found
    assert (at == dry_at).all()
    assert lubricated[-1].inner_force[:32][at] == pytest.approx(dry[-1].inner_force[:32][at], rel=0.01)
    assert lubricated[-1].speed[32:34] == pytest.approx(dry[-1].speed[32:34], rel=0.01)
    assert oiled.friction == pytest.approx(account.friction, rel=0.2)


def test_states_show_the_film_of_the_most_loaded_contact() -> None:
    states = run(0.2)[1][-1]
    heaviest = float(states.inner_force[:32].max()), float(states.outer_force[:32].max())
    films = inner_film(SHAFT, layer=50e-6), outer_film(SHAFT, layer=50e-6)
    expected = [thickness_under(film, force) for film, force in zip(films, heaviest, strict=True)]
    assert lubrication(states).film == pytest.approx(expected, rel=2e-3)  # at the present speeds of the cages
    assert lubrication(states).film_ratio == pytest.approx(lubrication(states).film / 2.8e-7, rel=1e-12)


def test_the_sources_are_all_that_friction_and_contacts_take() -> None:
    simulation, states = run(0.2)
    taken, booked = lubrication(states[-1]).friction_loss, simulation.energy
    # The account goes on for the last millisecond after the last states.
    shares = taken.sum() / (booked.friction + booked.loss), lost(states[-1], "rolling") / booked.friction
    assert shares[0] == pytest.approx(1.0, abs=0.01)
    assert 0.9 < shares[1] < 1.0
    assert (taken >= 0.0).all()
    assert (taken[:, [0, 1, 3, 5]] > 0.0).all()


def test_power_is_what_the_shaft_puts_in() -> None:
    """Over an interval: drive and load less what is stored and what the housing takes is the power of all sources, to 0.1 %."""
    simulation = bench()
    list(simulation.blocks(0.06))
    before = simulation.energy
    lost_before = friction_losses(simulation._state)
    list(simulation.blocks(0.1))
    after, taken = simulation.energy, (friction_losses(simulation._state) - lost_before).sum()
    change = {name: getattr(after, name) - getattr(before, name) for name in ("drive", "load", "housing", "stored", "notch")}
    put_in = change["drive"] + change["load"] - change["housing"] - change["stored"] - change["notch"]
    assert taken == pytest.approx(put_in, rel=1e-3)


def test_power_and_torque_are_means_since_the_states_before() -> None:
    states = run(0.2)[1]
    first, second = lubrication(states[-2]), lubrication(states[-1])
    apart = 1e-9 * (states[-1].time_ns - states[-2].time_ns)
    assert second.friction_power == pytest.approx((second.friction_loss - first.friction_loss) / apart, rel=1e-9)
    assert second.friction_torque == pytest.approx(second.friction_power / SHAFT, rel=1e-6)
    # VG 100, 70 deg C: 1009 W in rolling, docs/results/realism.md, "Losses by lubricant"
    assert np.mean([lubrication(s).friction_power[:, 1].sum() for s in states[100:]]) == pytest.approx(1009.0, rel=0.03)


def test_films_of_a_row_are_those_of_its_loaded_contacts() -> None:
    states = run(0.2)[1][-1]
    oil, force = lubrication(states), states.inner_force[:32].reshape(2, 16)
    film = inner_film(SHAFT, layer=50e-6)
    for row in range(2):
        films = [thickness_under(film, one) for one in force[row] if one > LOADED_FORCE]
        assert oil.least_film[row, 0] == pytest.approx(min(films), rel=2e-3)
        assert oil.mean_film[row, 0] == pytest.approx(np.mean(films), rel=2e-3)
        assert len(films) < 8
    assert oil.least_film_ratio == pytest.approx(oil.least_film / 2.8e-7, rel=1e-12)
    assert oil.least_film.min(axis=0) == pytest.approx(oil.film, rel=1e-12)
    # docs/explanation/lubrication.md, "Traction": a film of VG 100 at 70 deg C of 0.70 um under 30 kN, 0.78 um under 10 kN
    assert 0.69e-6 < oil.film[0] < 0.80e-6


def test_the_most_loaded_roller_rolls() -> None:
    oil = lubrication(run(0.2)[1][-1])
    # docs/explanation/lubrication.md, "Traction": a loaded roller is locked to within mm/s
    assert np.abs(oil.loaded_slip).max() < 5e-3
    assert np.abs(oil.loaded_traction).max() < 0.06


def test_a_row_without_load_has_no_films() -> None:
    simulation = bench(operating={"load": 0.0, "gravity": 0.0})
    states = [s for block in simulation.blocks(0.02) for s in block.states][-1]
    assert np.isnan(lubrication(states).least_film).all()
    assert np.isnan(lubrication(states).loaded_slip).all()
    assert np.isfinite(lubrication(states).friction_power).all()


def test_the_history_has_films_and_losses_over_time() -> None:
    states = run(0.2)[1]
    history = StateHistory.of(states, bench().bodies.names)
    shapes = {"film": (2,), "least_film": (2, 2), "loaded_slip": (2, 2), "friction_loss": (2, 6), "friction_torque": (2, 6)}
    for name, shape in shapes.items():
        assert np.array_equal(getattr(history, name)[-1], getattr(lubrication(states[-1]), name), equal_nan=True)
        assert getattr(history, name).shape == (len(states), *shape)


def test_a_dry_bench_has_no_films() -> None:
    simulation = bench(lubrication={"law": "dry"})
    (states, *_) = itertools.islice((s for block in simulation.blocks(0.02) for s in block.states), 1)
    assert states.lubrication is None
    assert StateHistory.of([states], simulation.bodies.names).film is None
    assert simulation._state.of_rollers(simulation._state.rollers[0].rolling_loss).max() == 0.0
