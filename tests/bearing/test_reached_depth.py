"""How far loaded rollers sink into defects."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from even_surfaces import EVEN

from dcrb_ros.bearing.contact_path import reduced_radii
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.bearing.reached_depth import of_widest, reached
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration


def size(fault: str, **values: Any) -> tuple[float, float]:
    """Return depth [um] and share of a defect of the bench ``healthy``."""
    settings = [f"faults.{fault}.{key}={value}" for key, value in values.items()]
    configuration = load_configuration("healthy", settings)
    depth, share = reached(configuration, getattr(configuration.faults, fault))
    return 1e6 * depth, share


def test_rollers_bridge_a_narrow_spall_and_reach_the_floor_of_a_wide_one() -> None:
    # Width^2/(8 R), R = 17.39 mm (docs/explanation/surfaces.md).
    assert size("outer_1", kind="spall", width=2e-3, depth=6e-5, roughness=0.0) == pytest.approx((28.75, 0.3), abs=0.1)
    assert size("outer_1", kind="spall", width=8e-3, depth=6e-5, roughness=0.0) == pytest.approx((60.0, 0.3), abs=0.1)
    assert size("outer_1", kind="spall", width=8e-3, depth=2e-5, roughness=0.0, share=1.0) == pytest.approx((20.0, 1.0), abs=0.1)


def test_a_notch_takes_the_whole_length() -> None:
    assert size("outer_1", width=2e-3) == pytest.approx((28.75, 1.0), abs=0.1)
    assert size("roller_1", width=2e-3) == pytest.approx((39.67, 1.0), rel=0.01)


@pytest.mark.parametrize("load", [2e3, 2e4, 1e5, 2e5])
@pytest.mark.parametrize("width", [0.3e-3, 1e-3, 2e-3])
@pytest.mark.parametrize(("fault", "radius"), [("outer_1", 17.393e-3), ("inner_1", 12.605e-3)])
def test_a_narrow_defect_is_felt_by_its_whole_sag_at_every_load(fault: str, radius: float, width: float, load: float) -> None:
    """c^2/(2 R): the elastic energy of a gap in a contact, see `dcrb_ros.bearing.contact_path`."""
    values = {"kind": "spall", "width": width, "roughness": 0.0, "share": 1.0}
    settings = [f"faults.{fault}.{key}={value}" for key, value in values.items()]
    for bench in ("healthy", "ball_bearing_6205"):
        ball = bench == "ball_bearing_6205"
        configuration = load_configuration(bench, [*settings, f"operating.load={load / 1e3 if ball else load}"])
        reduced = reduced_radii(configuration)[1 if fault == "outer_1" else 0]
        assert ball or reduced == pytest.approx(radius, rel=1e-3)
        sag = (0.5 * width) ** 2 / (2.0 * reduced)
        assert reached(configuration, getattr(configuration.faults, fault))[0] == pytest.approx(min(sag, 3e-4), rel=0.01)


def test_a_label_has_the_size_of_the_widest_defect() -> None:
    spalls = [
        f"faults.{key}.{part}={value}"
        for key, width in (("outer_1", 3e-3), ("inner_1", 1e-3))
        for part, value in (("kind", "spall"), ("width", width), ("share", 0.2 if key == "outer_1" else 0.5))
    ]
    assert of_widest(load_configuration("healthy", spalls))["share"] == pytest.approx(0.2)
    assert of_widest(load_configuration("healthy")) == of_widest(load_configuration("cage_fracture")) == {}


@pytest.mark.parametrize("depth", [2e-5, 6e-5])
def test_a_roller_sinks_by_the_depth_of_a_wide_spall(depth: float) -> None:
    """A roller that only its own weight presses into a spall as long as itself, and 12 mm wide, lies on the floor."""
    middle = {}
    for width in (0.0, 12e-3):
        spall = {"kind": "spall", "width": width, "depth": depth, "share": 1.0, "roughness": 0.0}
        made = Configuration.model_validate(
            {
                "surfaces": EVEN,
                "lubrication": {"law": "film_with_cages"},
                "friction": {"convection": 0.7},
                "contact": {"loss_time": 1e-5},
                "operating": {"speed": 0.0, "load": 100.0},
                "faults": {"outer_1": spall},
            }
        )
        payload = build_payload(made)
        state = initial_state(made, payload)
        steps = round(0.05 / made.simulation.step)
        advance(payload, state, workspace(payload), np.empty((steps, 2)), np.empty(steps))
        middle[width] = float(state.outer_position[1] - state.roller_position[0, 0, 1])
    assert middle[12e-3] - middle[0.0] == pytest.approx(depth, rel=0.03)
