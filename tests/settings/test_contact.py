"""Contact and friction: what the parameters that laws declare must satisfy."""

from __future__ import annotations

from dataclasses import replace

import pytest

from dcrb_ros.core.laws import NORMAL_LAWS
from dcrb_ros.core.laws.interface import Parameter
from dcrb_ros.schema.fields import Group, quantity
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.contact import with_laws

STIFFNESS = Parameter("stiffness", 1e9, "N/m", "Stiffness", 1e6, 1e12)


def group_with(*parameters: Parameter) -> type[Group]:
    class Contact(Group):
        """A group with a field of its own."""

        loss_time: float = quantity(1e-6, "s", "Damping", 0.0, 1e-4)

    laws = {name: replace(NORMAL_LAWS["power"], name=name, parameters=(p,)) for name, p in zip("ab", parameters, strict=False)}
    return with_laws(laws, "Normal force")(Contact)


def test_the_parameters_of_laws_become_fields_of_the_group() -> None:
    group = group_with(STIFFNESS, replace(STIFFNESS, name="other"))
    assert set(group.model_fields) == {"law", "stiffness", "other", "loss_time"}


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ((STIFFNESS, STIFFNESS), "normal force law 'b': a parameter 'stiffness' exists already"),
        ((replace(STIFFNESS, name="law"),), "a parameter 'law' exists already"),
        ((replace(STIFFNESS, name="loss_time"),), "a parameter 'loss_time' exists already"),
        ((replace(STIFFNESS, default=1e5),), "the default 100000.0 of 'stiffness' is outside 1e\\+06 .. 1e\\+12 N/m"),
        ((replace(STIFFNESS, default=float("nan")),), "the default nan of 'stiffness' is outside"),
    ],
)
def test_a_parameter_that_replaces_another_or_has_an_invalid_default_is_refused(parameters: tuple[Parameter, ...], words: str) -> None:
    with pytest.raises(Refusal, match=words):
        group_with(*parameters)
