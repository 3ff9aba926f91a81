"""Characteristic frequencies (Eqs. 41 to 45 of Fan et al. 2025)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.kinematics import characteristic_orders
from dcrb_ros.bearing.payload import cage_speed, roller_spin
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Bearing

PAPER = Configuration.model_validate({"cage": {"joint": "revolute"}})


def test_frequencies_at_20_hz() -> None:
    found = characteristic_orders(Bearing()).frequencies(20.0)
    # Eqs. 43 to 45 of Fan et al. 2025 with Table 1, and BSF; section 3.2 prints 8.4, 134.5 and 185.5 Hz.
    expected = {"FTF": 8.404, "BPFO": 134.47, "BPFI": 185.53, "BSF": 61.07}
    assert found == pytest.approx(expected, rel=1e-4)


@given(st.integers(6, 60), st.floats(0.001, 0.3))
def test_orders_of_any_geometry(count: int, ratio: float) -> None:
    orders = characteristic_orders(Bearing(rollers_per_row=count, pitch_radius=0.1, roller_radius=0.1 * max(ratio, 0.005)))
    assert orders.bpfo + orders.bpfi == pytest.approx(count)
    assert orders.bpfo < 0.5 * count < orders.bpfi
    assert orders.ftf < 0.5


def test_rolling_of_the_paper() -> None:
    # Section 2.3.2 at 124.8 rad/s: cage 52.4, roller -380.5 rad/s relative to the cage.
    cage, spin = cage_speed(PAPER, 124.8), roller_spin(PAPER.bearing, 124.8)
    assert cage == pytest.approx(52.4, rel=0.002)
    assert spin - cage == pytest.approx(-380.5, rel=0.001)
