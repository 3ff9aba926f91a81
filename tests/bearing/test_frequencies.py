"""Characteristic frequencies and rolling (Eqs. 41 to 45 of Fan et al. 2025)."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.bearing.payload import roller_spin
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import cage_speed
from dcrb_ros.settings.parameters import Bearing

PAPER = Configuration.model_validate({"cage": {"joint": "revolute"}})


def test_frequencies_at_20_hz() -> None:
    found = characteristic_orders(Bearing()).frequencies(20.0)
    # The paper states the first three at 1200 rpm; BSF is 20 Hz (D/d - d/D)/2 with d = 30 mm and D = 188 mm (Randall and Antoni 2011).
    expected = {"FTF": 8.4, "BPFO": 134.5, "BPFI": 185.5, "BSF": 10.0 * (188.0 / 30.0 - 30.0 / 188.0)}
    assert found == pytest.approx(expected, abs=0.05)


def test_orders_by_name() -> None:
    orders = characteristic_orders(Bearing())
    assert list(orders.as_dict()) == ["FTF", "BPFO", "BPFI", "BSF"]
    assert Orders.from_dict(orders.as_dict()) == orders
    with pytest.raises(KeyError):
        Orders.from_dict({"FTF": 0.4})


@given(st.integers(6, 60), st.floats(0.001, 0.3))
def test_orders_of_any_geometry(count: int, ratio: float) -> None:
    orders = characteristic_orders(Bearing(rollers_per_row=count, pitch_radius=0.1, roller_radius=0.1 * max(ratio, 0.005)))
    assert orders.bpfo + orders.bpfi == pytest.approx(count)
    assert orders.bpfo < 0.5 * count < orders.bpfi
    assert orders.ftf < 0.5


def test_cage_and_roller_speed_of_the_paper() -> None:
    # Section 2.3.2 at 124.8 rad/s: cage 52.4, roller -380.5 rad/s relative to the cage.
    cage, spin = cage_speed(PAPER, 124.8), roller_spin(PAPER.bearing, 124.8)
    assert cage == pytest.approx(52.4, rel=0.002)
    assert spin - cage == pytest.approx(-380.5, rel=0.001)


@pytest.mark.parametrize("name", ["ftf", "bpfo", "bpfi", "bsf"])
@pytest.mark.parametrize(
    ("order", "accepted"), [(0.01, True), (1000.0, True), (0.0099, False), (1001.0, False), (-1.0, False), (1e300, False)]
)
def test_orders_have_one_range_wherever_they_come_from(name: str, order: float, accepted: bool) -> None:
    found = {"ftf": 0.4, "bpfo": 3.6, "bpfi": 5.4, "bsf": 2.4, name: order}
    if accepted:
        assert getattr(Orders(**found), name) == order
        return
    for make in (lambda: Orders(**found), lambda: Orders.from_dict({key.upper(): value for key, value in found.items()})):
        with pytest.raises(Refusal, match=rf"{name.upper()} = .* is outside 0\.01 \.\. 1000 orders of the shaft"):
            make()


def test_the_orders_of_an_unknown_bearing_are_all_nan() -> None:
    Orders(*[math.nan] * 4)
    with pytest.raises(Refusal, match="FTF = nan is outside"):
        Orders(math.nan, 3.6, 5.4, 2.4)


def test_a_shaft_frequency_that_is_no_number_is_refused() -> None:
    with pytest.raises(Refusal, match="shaft_frequency is a str, not a number"):
        Orders(0.4, 4.0, 6.0, 3.0).frequencies("20")  # type: ignore[arg-type]
