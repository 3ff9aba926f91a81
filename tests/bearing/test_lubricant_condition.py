"""What is left of the lubricant after a loss: layers shrink, and friction and slip rise, as the page on heat says."""

from __future__ import annotations

import pytest

from dcrb_ros.bearing.lubricant_condition import cage_friction_of, remaining
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.loaded_contacts import material_of


def bench(*settings: str) -> Configuration:
    return load_configuration("dry", ["lubrication.law=film", *settings])


@pytest.mark.parametrize(
    ("loss", "layer", "pocket_layer", "friction", "slip"),
    [
        # Layer of the grease, 5 um, and in the pockets, 100 um; friction of 0.12 and slip of 0.004 at asperities.
        (0.1, 4.502e-6, 90e-6, 0.1218, 0.004016),
        (0.5, 2.51e-6, 50e-6, 0.165, 0.006),
        (1.0, 0.02e-6, 0.0, 0.30, 0.02),
    ],
)
def test_a_loss_takes_the_layers_and_adds_friction_and_slip(
    loss: float, layer: float, pocket_layer: float, friction: float, slip: float
) -> None:
    found = remaining(bench(), loss)
    names = ("layer", "pocket_layer", "boundary_friction", "micro_slip")
    assert [found[name] for name in names] == pytest.approx([layer, pocket_layer, friction, slip], rel=1e-9)


@pytest.mark.parametrize(("loss", "left"), [(0.0, 1.0), (0.5, 0.5), (1.0, 1e-6)])
def test_a_loss_takes_the_oil_at_lands_and_orbit(loss: float, left: float) -> None:
    found = remaining(bench("lubrication.land_fill=0.3"), loss)
    assert found["land_fill"] == pytest.approx(0.3 * left, abs=1e-6)
    assert found["oil_share"] == pytest.approx(0.005 * left, rel=1e-9)


def test_an_overfill_adds_to_the_normal_filling() -> None:
    overfilled = load_configuration("healthy", {"faults.overfilled.share": 0.05})
    assert remaining(overfilled, 0.0)["oil_share"] == pytest.approx(0.055)


def test_a_thin_layer_does_not_grow_and_high_friction_does_not_fall() -> None:
    found = remaining(bench("lubrication.layer=1e-8", "lubrication.boundary_friction=0.4"), 1.0)
    assert (found["layer"], found["boundary_friction"]) == pytest.approx((1e-8, 0.4), rel=1e-9)


@pytest.mark.parametrize(("loss", "friction"), [(0.0, 0.05), (0.5, 0.1125), (1.0, 0.30)])
def test_bars_and_lands_rub_more_after_a_loss(loss: float, friction: float) -> None:
    found = cage_friction_of(bench(), material_of(bench().bearing), loss)
    assert (found.kinetic_coefficient, found.static_coefficient) == pytest.approx((friction, friction), rel=1e-9)
