"""Warnings of light loads and of notches that are taken for spalls."""

from __future__ import annotations

import pytest

from dcrb_ros.bearing.plausibility import implausible, minimum_load
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.settings.shipped import shipped

FAST = "operating.speed=314.159"  # 3000 rpm


def warnings(bench: str, *settings: str) -> list[str]:
    return list(implausible(load_configuration(bench, settings)))


def test_the_minimum_load_is_that_of_the_catalogue() -> None:
    # SKF: F_rm = k_r (6 + 4 n/n_r) (d_m/100)^2 = 0.2 * 10 * 1.88^2 kN at the reference speed of 5.5e5/188 rpm, for each row.
    bearing = Bearing()
    mean = 2e3 * bearing.pitch_radius
    reference = 5.5e5 / mean * 3.14159265 / 30.0
    assert minimum_load(bearing, reference) == pytest.approx(2.0 * 2e3 * (mean / 100.0) ** 2, rel=1e-6)
    assert minimum_load(bearing.model_copy(update={"rows": 1}), -reference) == pytest.approx(2e3 * (mean / 100.0) ** 2, rel=1e-6)


def test_a_fast_bearing_under_a_light_load_is_said_to_rattle() -> None:
    (sentence,) = warnings("healthy", FAST, "operating.load=5000.0")
    assert sentence.startswith("a load of 5 kN is below 21.4 kN, under which the model rattles at 3000 rpm")
    assert warnings("healthy", FAST, "operating.load=-22000.0") == []
    assert warnings("healthy", "operating.speed=125.664", "operating.load=1000.0") == []  # 1200 rpm
    assert warnings("paper", FAST, "operating.load=5000.0") == []


def test_a_width_alone_is_said_to_be_a_notch() -> None:
    (sentence,) = warnings("healthy", "faults.inner_1.width=0.002")
    assert sentence.startswith("faults.inner_1.kind = notch is a groove 0.3 mm deep across the whole raceway")
    assert warnings("healthy", "faults.inner_1.width=0.002", "faults.inner_1.kind=spall") == []
    assert warnings("paper", "faults.outer_1.width=0.002") == []


@pytest.mark.parametrize("name", [name for name in shipped("configuration") if name != "detector"])
def test_shipped_benches_give_no_warning(name: str) -> None:
    assert warnings(name) == []
