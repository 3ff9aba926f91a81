"""The ends of the parameters' ranges: the configuration refuses them, or the model stands them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration, parameter_fields
from dcrb_ros.simulation.loop import Simulation

pytestmark = pytest.mark.slow

MODEL = ("bearing", "housing", "contact", "friction", "cage", "operating")
"""Groups that the model depends on; the measurement chain has its own tests."""
NUMBERS = [field for field in parameter_fields() if field.key.partition(".")[0] in MODEL and field.kind in (int, float)]


def run(configuration: Configuration, seconds: float) -> None:
    """Run a simulation; it fails by itself where it diverges."""
    for block in Simulation(configuration, waveform_only=True).blocks(seconds):
        assert np.isfinite(block.acceleration).all()


# A cold start slides through the whole Stribeck curve. Some 30 ends of ranges are simulated for 100 steps each.
@pytest.mark.parametrize("field", NUMBERS, ids=lambda field: field.key)
def test_the_model_stands_what_the_configuration_accepts(field: ParameterField) -> None:
    for end in (field.low, field.high):
        try:
            configuration = load_configuration("dry", {"operating.start": "cold", field.key: end, "publishing.block_size": 50})
        except Refusal:
            continue
        run(configuration, 0.001)


@pytest.mark.parametrize("static", [0.0, 0.06])
@pytest.mark.parametrize("joint", ["revolute", "pocket"])
def test_the_model_runs_without_kinetic_friction(joint: str, static: float) -> None:
    friction = {"friction.kinetic_coefficient": 0.0, "friction.static_coefficient": static}
    run(load_configuration("dry", {"cage.joint": joint, "operating.start": "cold", **friction}), 0.01)


@pytest.mark.parametrize(
    ("key", "value", "joint"),
    [
        ("contact.loss_time", 1e-4, "revolute"),
        ("contact.damping", 1e5, "revolute"),
        ("friction.viscous", 10.0, "revolute"),
        ("friction.viscous", 10.0, "pocket"),
        ("housing.stiffness", 1e3, "revolute"),
    ],
)
def test_a_value_that_the_model_does_not_stand_is_refused_with_one_that_it_does(key: str, value: float, joint: str) -> None:
    settings = {"cage.joint": joint, "bearing.inner_ring_mass": 2.0, "operating.load": 5e4}
    with pytest.raises(Refusal, match=re.escape(f"{key} = {value:g}")) as refused:
        load_configuration("dry", {**settings, key: value})
    proposed = re.search(r"at (?:most|least) ([\d.e+-]+\d)", str(refused.value))
    assert proposed
    toward = 0.999 if value > float(proposed[1]) else 1.001  # the proposal is rounded
    run(load_configuration("dry", {**settings, key: toward * float(proposed[1])}), 0.01)
