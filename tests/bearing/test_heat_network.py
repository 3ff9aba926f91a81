"""The thermal network: heat is conserved, temperatures stay within bounds, and steady states are those worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dcrb_ros.bearing.heat_network import Conductances, contact_conductance, heat_network, idle_conductance, surface_exchange
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.settings.thermal import Thermal

NETWORK = heat_network(Bearing(), Thermal())
RACEWAYS = [(62.8, 73.6)] * 2
"""Conductances of inner and outer raceway [W/K] at 1200 rpm under 100 kN."""
VEHICLE = 57.8
"""Speed of the vehicle at 1200 rpm on wheels of 0.92 m [m/s]."""
AMBIENT = 20.0

heats = st.lists(st.floats(0.0, 5e3), min_size=7, max_size=7)
temperatures = st.lists(st.floats(-40.0, 600.0), min_size=7, max_size=7)


def at_speed() -> Conductances:
    """Return the conductances at 208 km/h."""
    return NETWORK.conductances(RACEWAYS, VEHICLE, 0.4 * VEHICLE)


def test_capacities_add_up_to_the_masses() -> None:
    # 7.316 kg and 13.49 kg of rings, 2 x 16 rollers of 0.248 kg, two cages of 2.459 kg, 60 kg of box, and the journal.
    journal = 2.0 * NETWORK.capacity[0] / 465.0 - 7.316
    assert journal == pytest.approx(20.84, rel=0.05)  # 130 mm x 200 mm of steel
    assert sum(NETWORK.capacity) == pytest.approx(54_140, rel=0.01)


def test_the_resistance_from_the_box_is_that_of_the_inverted_matrix() -> None:
    above = np.array(NETWORK.steady(at_speed(), [0.0] * 6 + [100.0], AMBIENT)) - AMBIENT
    inverse = np.linalg.inv(np.array(at_speed().matrix))
    assert above[-1] / 100.0 == pytest.approx(inverse[-1, -1], rel=1e-12)
    assert above[-1] / 100.0 == pytest.approx(0.02069, rel=1e-3)  # [K/W]


def test_rings_conduct_from_row_to_row_through_their_section() -> None:
    # 7.316 kg and 13.49 kg of steel over 160 mm of width: sections of 58.25 and 107.4 cm^2, with 45 W/(m K) over the 80 mm between rows.
    matrix = at_speed().matrix
    assert matrix[0][1] == matrix[1][0] == pytest.approx(-45.0 * 58.25e-4 / 0.08, rel=1e-3)
    assert matrix[4][5] == matrix[5][4] == pytest.approx(-45.0 * 107.4e-4 / 0.08, rel=1e-3)


def test_half_of_the_heat_of_a_contact_goes_to_each_body() -> None:
    # Of 100 W at the inner raceway, 60 W at the outer one and 10 W of cage and seals in row 1, and 7 W of sun.
    assert NETWORK.heat([(100.0, 60.0, 10.0), (0.0, 0.0, 0.0)], 7.0) == [50.0, 0.0, 85.0, 0.0, 35.0, 0.0, 7.0]


@pytest.mark.parametrize("node", [0, 6])
def test_a_node_that_is_cut_off_from_the_others_warms_by_its_heat_over_its_conductance(node: int) -> None:
    whole = at_speed()
    alone = Conductances([[whole.ambient[i] if i == j else 0.0 for j in range(7)] for i in range(7)], whole.ambient)
    for k in range(7):
        alone.matrix[k][k] = alone.matrix[k][k] or 1.0
    heat = [0.0] * 7
    heat[node] = 50.0
    assert NETWORK.steady(alone, heat, AMBIENT)[node] - AMBIENT == pytest.approx(50.0 / whole.ambient[node], rel=1e-12)


@given(heat=heats, begin=temperatures, duration=st.floats(0.02, 60.0))
@settings(deadline=None)
def test_what_is_stored_and_lost_is_what_was_put_in(heat: list[float], begin: list[float], duration: float) -> None:
    flow = at_speed()
    after = NETWORK.after(begin, flow, heat, AMBIENT, duration)
    stored = math.fsum(c * (now - before) for c, now, before in zip(NETWORK.capacity, after, begin, strict=True))
    lost = math.fsum(g * (now - AMBIENT) for g, now in zip(flow.ambient, after, strict=True)) * duration
    moved = math.fsum(c * abs(now - before) for c, now, before in zip(NETWORK.capacity, after, begin, strict=True))
    assert stored + lost - duration * math.fsum(heat) == pytest.approx(0.0, abs=1e-9 * (1.0 + duration * math.fsum(heat) + moved))


@given(heat=heats)
@settings(deadline=None)
def test_at_rest_the_surroundings_get_all_the_heat(heat: list[float]) -> None:
    flow = at_speed()
    steady = NETWORK.steady(flow, heat, AMBIENT)
    lost = math.fsum(g * (one - AMBIENT) for g, one in zip(flow.ambient, steady, strict=True))
    assert lost == pytest.approx(math.fsum(heat), rel=1e-9, abs=1e-9)


@given(begin=st.lists(st.floats(AMBIENT, 600.0), min_size=7, max_size=7), duration=st.floats(0.02, 1e4))
@settings(deadline=None)
def test_without_heat_the_hottest_cools_and_nothing_gets_colder_than_the_surroundings(begin: list[float], duration: float) -> None:
    now = begin
    for _ in range(5):
        before, now = now, NETWORK.after(now, at_speed(), [0.0] * 7, AMBIENT, duration)
        assert max(now) <= max(before) + 1e-9
        assert min(now) >= AMBIENT - 1e-9


@given(heat=st.lists(st.floats(0.0, 5e3), min_size=3, max_size=3), duration=st.floats(0.02, 1e4))
@settings(deadline=None)
def test_rows_that_are_heated_alike_stay_alike(heat: list[float], duration: float) -> None:
    found = [AMBIENT] * 7
    for _ in range(5):
        found = NETWORK.after(found, at_speed(), NETWORK.heat([heat, heat], 0.0), AMBIENT, duration)
    assert [found[0], found[2], found[4]] == pytest.approx([found[1], found[3], found[5]], rel=1e-12)


def test_a_time_lapse_of_100_comes_to_the_same_temperatures_in_a_hundredth_of_the_steps() -> None:
    flow, heat = at_speed(), NETWORK.heat([(154.0, 240.0, 31.0)] * 2, 0.0)
    real = lapse = [AMBIENT] * 7
    for _ in range(18_000):  # an hour in ticks of 20 ms would take ten times as long to compute, so ticks of 0.2 s stand for them
        real = NETWORK.after(real, flow, heat, AMBIENT, 0.2)
    for _ in range(1_800):  # 36 s in ticks of 20 ms
        lapse = NETWORK.after(lapse, flow, heat, AMBIENT, 100 * 0.02)
    assert lapse == pytest.approx(real, abs=0.05)


def test_one_row_has_a_node_of_each_kind() -> None:
    network = heat_network(Bearing(rows=1, row_phase=0.0), Thermal())
    assert network.names == ["row1/inner_ring", "row1/rollers", "row1/outer_ring", "box"]
    flow = network.conductances([(62.8, 73.6)], VEHICLE, 0.4 * VEHICLE)
    steady = network.steady(flow, network.heat([(154.0, 240.0, 31.0)], 0.0), AMBIENT)
    assert sum(g * (one - AMBIENT) for g, one in zip(flow.ambient, steady, strict=True)) == pytest.approx(425.0, rel=1e-12)


def test_a_loaded_contact_conducts_with_the_root_of_its_speed() -> None:
    assert contact_conductance(2.4e-4, 0.048, 5.75) == pytest.approx(21.3, rel=0.01)  # [W/K]
    assert contact_conductance(2.4e-4, 0.048, 23.0) == pytest.approx(2.0 * contact_conductance(2.4e-4, 0.048, 5.75), rel=1e-12)
    assert contact_conductance(2.4e-4, 0.048, 0.0) > 0.0


def test_an_idle_contact_conducts_through_its_film() -> None:
    assert idle_conductance(0.048) == pytest.approx(0.448, rel=1e-12)  # 0.14 W/(m K), 48 mm x 0.2 mm of oil of 3 um [W/K]


def test_wind_cools_the_box() -> None:
    # 0.45 m^2 at 208 km/h, 104 km/h and at rest, behind bogie and wheel.
    for kmh, expected in ((208.0, 41.1), (104.0, 25.8), (0.0, 5.4)):
        assert 0.45 * surface_exchange(0.4 * kmh / 3.6, 0.33) == pytest.approx(expected, rel=0.01)
