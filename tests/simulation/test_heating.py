"""Temperatures, lubricant and clearance of a running bearing: on their grid of steps, in balance, and with an effect on the motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import dcrb_ros
from dcrb_ros.bearing.quasi_steady import QuasiSteady, lost_in_grease
from dcrb_ros.bearing.thermal_fit import oil_state
from dcrb_ros.core.laws.calls import churning
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.heating import AVERAGED
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import scheduled_changes

pytestmark = pytest.mark.slow

WARM = {"thermal.law": "network"}


def simulation(**values: Any) -> Simulation:
    """Return the default bench with a thermal network and more."""
    return Simulation(load_configuration("healthy", WARM | {key.replace("__", "."): value for key, value in values.items()}))


def samples(running: Simulation, duration: float) -> bytes:
    """Return the samples of a run as bytes."""
    return b"".join(block.acceleration.tobytes() for block in running.blocks(duration))


def advanced(running: Simulation, duration: float) -> Simulation:
    """Return a simulation after some time [s]."""
    for _ in running.blocks(duration):
        pass
    return running


def test_the_size_of_blocks_changes_no_sample_and_no_temperature() -> None:
    sizes = (256, 1000, 4096)
    runs = [simulation(publishing__block_size=size, thermal__acceleration=300.0, faults__lubrication__loss=0.5) for size in sizes]
    found = [samples(run, 0.3) for run in runs]
    assert found[1:] == found[:-1]
    assert runs[0]._heating.temperatures == runs[1]._heating.temperatures == runs[2]._heating.temperatures


def test_a_fork_continues_with_the_same_temperatures() -> None:
    run = advanced(simulation(thermal__acceleration=300.0), 0.1)
    other = run.fork()
    assert samples(run, 0.1) == samples(other, 0.1)
    assert run._heating.temperatures == other._heating.temperatures
    assert run._heating.temperatures is not other._heating.temperatures


def test_heat_that_films_lose_is_stored_or_lost() -> None:
    run = simulation(thermal__acceleration=50.0, thermal__start="cold")
    heating = run._heating
    begin, filtered = list(heating.temperatures), sum(map(sum, heating._heat))
    put_in = lost = 0.0
    for tick in range(1, 26):
        advanced(run, 0.02)
        duration = 50.0 * 0.02
        put_in += duration * sum(map(sum, heating._heat))
        lost += duration * sum(g * (t - 20.0) for g, t in zip(heating.flow.ambient, heating.temperatures, strict=True))
        stored = math.fsum(c * (t - b) for c, t, b in zip(heating._network.capacity, heating.temperatures, begin, strict=True))
        assert stored + lost == pytest.approx(put_in, rel=1e-9), tick
    # What was put in is what the account of losses and the seals have, except for what the average still holds.
    booked = float(heating._losses.sum()) + 0.5 * 2 * run.configuration.thermal.seal_torque * 125.664  # type: ignore[union-attr]
    held = AVERAGED * (sum(map(sum, heating._heat)) - filtered)
    assert put_in / 50.0 + held == pytest.approx(booked, rel=2e-3)  # the speed fluctuates by 0.1 %


def test_a_warm_start_is_near_the_steady_state_of_the_running_bearing() -> None:
    run = dcrb_ros.simulate("healthy", 1.0, settings=WARM)
    warm, now = run.states.heat[0].sum(), run.states.heat[-1].sum()
    # The estimate leaves out sliding and the shear of oil in pockets, a quarter of the losses with film_with_cages.
    assert warm < now < 1.5 * warm
    assert abs(run.states.box_temperature[-1] - run.states.box_temperature[0]) < 0.1


def test_a_cold_start_warms_up_and_loses_viscosity_and_clearance() -> None:
    run = dcrb_ros.simulate("healthy", 1.5, settings=WARM | {"thermal.start": "cold", "thermal.acceleration": 1000.0})
    states = run.states
    assert states.box_temperature[0] == pytest.approx(20.0, abs=0.5)
    assert states.inner_ring_temperature[-1].min() > 30.0
    assert states.film[-1, 0] < 0.7 * states.film[10, 0]
    assert states.clearance_change[-1] < -1e-6


def test_lost_lubricant_thins_films_and_then_heats() -> None:
    fine, starved, lost = (
        dcrb_ros.simulate("healthy", 0.3, settings=WARM | {"faults.lubrication.loss": loss, "thermal.start": "cold"}).states
        for loss in (0.0, 0.8, 1.0)
    )
    powers = [states.friction_power[-10:].sum(axis=(1, 2)).mean() for states in (fine, starved, lost)]
    assert powers[1] < 0.8 * powers[0]  # a starved film resists rolling less
    assert powers[2] > 3.0 * powers[0]  # until asperities carry
    assert fine.film_ratio[-1, 0] > 3.0
    assert lost.film_ratio[-1, 0] < 0.1


def test_a_loss_grows_at_its_rate_and_the_truth_names_it() -> None:
    run = simulation(faults__lubrication__loss=0.4, faults__lubrication__duration=1.0)
    truths = [truth for block in run.blocks(0.6) for truth in block.truths]
    assert truths[0].thermal["lubricant_loss"] == 0.0
    at = {round(truth.time_ns * 1e-9, 1): truth.thermal["lubricant_loss"] for truth in truths}
    # A tick of 0.1 s loses a tenth, by a 64th in 2.5 ms.
    assert at[0.3] - at[0.2] == pytest.approx(0.1, abs=1e-12)
    assert at[0.2] == pytest.approx(0.1 + 1.0 / 64.0, abs=0.005)
    assert at[0.5] == pytest.approx(0.4, abs=1e-12)
    assert truths[-1].faults["lubrication"]["loss"] == 0.4


@pytest.mark.parametrize("law", ["network", "none"])
def test_a_scenario_and_a_change_at_run_time_take_the_lubricant(law: str) -> None:
    c = load_configuration("healthy", {"thermal.law": law})
    story = {"timeline": [{"at": 0.1, "over": 0.1, "set": {"faults.lubrication.loss": 1.0}}]}
    told = Simulation(c, scheduled_changes(story, c, "story"))
    states = [states for block in told.blocks(0.42) for states in block.states]
    assert states[5].lubrication.film[0] > 5e-7 > 1e-7 > states[-1].lubrication.film[0]  # type: ignore[union-attr]
    commanded = Simulation(c)
    advanced(commanded, 0.1)
    commanded.change({"faults.lubrication.loss": 1.0})
    states = [states for block in commanded.blocks(0.35) for states in block.states]
    assert states[-1].lubrication.film[0] < 1e-7  # type: ignore[union-attr]
    assert {"lubrication"} == {name for block in commanded.blocks(0.2) for truth in block.truths for name in truth.faults}


@pytest.mark.parametrize("duration", [0.0, 0.5])
def test_a_loss_takes_the_films_without_a_blow(duration: float) -> None:
    run = Simulation(load_configuration("healthy", {"structure.housing": "none"}))
    advanced(run, 0.1)
    before = max(float(np.abs(block.clean).max()) for block in run.blocks(0.1))
    run.change({"faults.lubrication.loss": 1.0, "faults.lubrication.duration": duration})
    after = max(float(np.abs(block.clean).max()) for block in run.blocks(0.4 + duration))
    assert run._heating.loss == 1.0
    # Measured: 6.3 m/s^2 before, up to 63 when the cages fall on their lands, and 120 to 200 by films that go in larger steps.
    assert after < 12.0 * before


def test_lost_clearance_widens_the_load_zone_and_heats() -> None:
    sound, tight = (
        dcrb_ros.simulate("healthy", 0.2, settings=WARM | {"faults.clearance.lost": lost, "thermal.start": "cold"}).states
        for lost in (0.0, 7.5e-5)
    )
    loaded = [(states.inner_force[-10:, :32] > 500.0).mean() for states in (sound, tight)]
    assert loaded[1] > 2.0 * loaded[0]
    assert tight.heat[-1].sum() > 1.2 * sound.heat[-1].sum()


def test_clearance_that_is_lost_at_run_time_goes_in_small_steps() -> None:
    run = simulation()
    advanced(run, 0.1)
    run.change({"faults.clearance.lost": 5e-6})
    gaps = np.array([states.thermal.clearance_change for block in run.blocks(1.0) for states in block.states])  # type: ignore[union-attr]
    assert gaps[-1] - gaps[0] == pytest.approx(-5e-6, abs=5e-7)
    assert np.abs(np.diff(gaps)).max() <= 5 * 0.02e-6  # five changes in 10 ms at most
    assert np.isfinite(gaps).all()


def test_a_lighter_fault_is_refused_where_it_would_do_nothing() -> None:
    for settings, word in (
        ({"thermal.law": "network"}, "lubrication.law is dry"),
        ({"faults.lubrication.loss": 0.5}, "needs a lubricant"),
        ({"faults.seal_rub.torque": 1.0}, "thermal.law is none"),
        ({"thermal.sun": 108.0}, "thermal.sun = 108 W only heats, and thermal.law is none"),
        ({"faults.overfilled.share": 0.1}, "thermal.law = network"),
        ({"faults.clearance.lost": 5e-4}, "interference"),
    ):
        with pytest.raises(Refusal, match=word):
            load_configuration("dry", settings)


def test_too_much_grease_is_refused_where_it_does_not_drag_on_pinned_rollers() -> None:
    overfilled = {"faults.overfilled.share": 0.1}
    pinned = overfilled | {"cage.joint": "revolute", "thermal.law": "network"}
    load_configuration("healthy", overfilled)
    with pytest.raises(Refusal, match="joint is revolute: take") as refused:
        load_configuration("healthy", pinned)
    assert "faults.overfilled.share = 0.1" in str(refused.value)
    heated = load_configuration("healthy", pinned | {"lubrication.law": "film"})
    assert lost_in_grease(heated, 50.0, 0.0) > 100.0


def test_an_overfill_acts_while_the_bearing_runs() -> None:
    run = Simulation(load_configuration("healthy"))
    next(run.blocks())
    normal = churning(run._payload.lubrication)
    for share, factor in ((0.05, 11.0), (0.0, 1.0)):
        run.change({"faults.overfilled.share": share})
        for _ in run.blocks(0.2):
            pass
        assert churning(run._payload.lubrication) == pytest.approx(factor * normal)


def test_the_housing_sensor_lags_behind_a_step_by_its_time_constant() -> None:
    from dcrb_ros.bearing.heat_network import heat_network
    from dcrb_ros.simulation.temperature_sensors import TemperatureSensors

    c = load_configuration("healthy", WARM | {"thermal.sensor_noise": 0.0, "thermal.sensor_resolution": 0.0})
    sensors = TemperatureSensors(c, heat_network(c.bearing, c.thermal), [20.0] * 7)
    for _ in range(3000):  # 60 s in ticks
        sensors.follow(c, [70.0] * 7, 0.02)
    reading = sensors.reading(c, 0, 0)
    assert reading is not None
    assert reading.box == pytest.approx(20.0 + 50.0 * (1.0 - math.exp(-1.0)), rel=1e-9)
    assert reading.outer_ring == 70.0


def test_sensors_read_once_a_second_with_noise_and_resolution() -> None:
    readings = [reading for block in simulation().blocks(2.05) for reading in block.temperatures]
    assert [reading.time_ns for reading in readings] == [0, 1_000_000_000, 2_000_000_000]
    for reading in readings:
        assert reading.outer_ring % 0.5 == reading.box % 0.5 == reading.ambient % 0.5 == 0.0
        assert abs(reading.ambient - 20.0) < 1.5


@pytest.mark.parametrize("law", ["film", "film_with_cages"])
def test_cold_oil_is_held_at_the_temperature_at_which_it_flows_and_counted(law: str) -> None:
    c = load_configuration(
        "healthy",
        WARM
        | {
            "thermal.start": "cold",
            "thermal.ambient": -40.0,
            "lubrication.law": law,
            "lubrication.lubricant": "vg220",
            "lubrication.layer": 2e-6,
        },
    )
    run = advanced(Simulation(c), 0.1)
    assert run._heating.truth(c)["clamped"] == 1.0
    assert math.isfinite(run._heating.temperatures[0])


def test_hot_oil_is_held_at_the_end_of_its_formulas_and_each_time_is_counted() -> None:
    run = simulation(thermal__start="cold")
    heating = run._heating
    advanced(run, 0.35)
    assert heating.clamped == 0  # within the range nothing is counted
    found = []
    for warm in (300.0, 400.0):
        heating.temperatures = [warm] * len(heating.temperatures)
        advanced(run, 0.2)
        found.append(heating._oil)
    assert heating.clamped == 4  # of the ticks of 0.1 s, two at each temperature
    assert found[0] == found[1] == oil_state(0.0, 250.0, 250.0, 0.0)
    heating.temperatures = [240.0] * len(heating.temperatures)
    advanced(run, 0.1)
    assert heating.clamped == 4
    assert heating.truth(run.configuration)["clamped"] == 4.0


def test_a_speed_that_changes_during_a_time_lapse_keeps_its_time_and_the_truth_has_both() -> None:
    c = load_configuration("healthy", WARM | {"thermal.acceleration": 100.0, "operating.speed_ramp": 500.0})
    story = {"timeline": [{"at": 0.05, "set": {"operating.speed": 75.664}}]}
    truths = [truth for block in Simulation(c, scheduled_changes(story, c, "story")).blocks(0.32) for truth in block.truths]
    assert {truth.thermal["acceleration"] for truth in truths} == {100.0}
    speeds = {round(truth.time_ns * 1e-9, 1): truth.speed for truth in truths}
    assert speeds[0.1] == pytest.approx(100.664, rel=0.01)  # 50 ms of a ramp of 500 rad/s^2, not of one a hundred times as fast
    assert speeds[0.3] == pytest.approx(75.664, rel=0.01)


def test_grease_above_its_limit_burns_at_its_rate() -> None:
    """By 1 % per kelvin and hour: a tick of 0.02 s lasts for 0.01 h at this time lapse."""
    run = simulation(thermal__acceleration=1800.0, thermal__grease_limit=80.0)
    heating = run._heating
    burnt = []
    for temperature in (70.0, 90.0, 110.0):
        heating.temperatures, before = [temperature] * len(heating.temperatures), heating._lost
        heating._lose(run.configuration)
        burnt.append(heating._lost - before)
    assert burnt == pytest.approx([0.0, 0.01 * 0.01 * 10.0, 0.01 * 0.01 * 30.0], rel=1e-6)


def test_raceways_have_the_shares_of_the_heat_that_their_contacts_make() -> None:
    run = advanced(simulation(), 1.5)
    steady = QuasiSteady(run.configuration)
    for found, expected in zip(run._heating._heat, steady.power(steady.running(), run._heating.temperatures), strict=True):
        assert expected[0] < 0.8 * expected[1]  # the outer raceway, which the rollers touch everywhere, makes more
        assert found[0] / found[1] == pytest.approx(expected[0] / expected[1], rel=0.15)


def test_a_bearing_that_burns_off_ends_the_run_with_the_reason() -> None:
    run = simulation(thermal__acceleration=3000.0, faults__lubrication__loss=1.0, faults__clearance__lost=9.5e-5)
    with pytest.raises(ModelFailure, match="burnt off"):
        advanced(run, 5.0)


def test_the_account_of_energy_closes_while_radii_grow() -> None:
    run = advanced(simulation(thermal__start="cold", thermal__acceleration=200.0), 0.5)
    energy = run.energy
    assert abs(energy.residual) < 2e-3 * energy.drive


def test_films_that_fill_the_gap_at_the_start_are_refused_and_later_the_oil_is_warm() -> None:
    """Those of -20 degrees take 8.6 um of a gap of 6 um; at 20 degrees they are thin, and colder air does not cool the oil at once."""
    cold = {"thermal.law": "network", "thermal.start": "cold", "lubrication.law": "film"}
    with pytest.raises(Refusal, match=r"films of .* of oil at -20 and -20 deg C at the start fill the radial gap of 6e-06 m: raise"):
        Simulation(load_configuration("ball_bearing_6205", {**cold, "thermal.ambient": -20.0}))
    simulation = Simulation(load_configuration("ball_bearing_6205", cold))
    simulation.change({"thermal.ambient": -20.0})
    Simulation(load_configuration("ball_bearing_6205", {**cold, "thermal.start": "warm", "lubrication.temperature": -20.0}))
