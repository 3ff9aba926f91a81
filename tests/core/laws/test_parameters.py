"""What the parameters of all laws have in common."""

from __future__ import annotations

import math

import pytest

from dcrb_ros.core.laws import LUBRICATION_LAWS, NORMAL_LAWS, TRACTION_LAWS

pytestmark = pytest.mark.kernel

PARAMETERS = [
    pytest.param(parameter, id=f"{law.name}.{parameter.name}")
    for laws in (NORMAL_LAWS, TRACTION_LAWS)
    for law in laws.values()
    for parameter in law.parameters
]


@pytest.mark.parametrize("parameter", PARAMETERS)
def test_a_parameter_is_not_negative_and_its_default_is_within_its_range(parameter: object) -> None:
    low, default, high = (float(getattr(parameter, name)) for name in ("low", "default", "high"))
    assert 0.0 <= low <= default <= high < math.inf
    assert low < high


def test_laws_of_every_kind_were_found() -> None:
    assert all((NORMAL_LAWS, TRACTION_LAWS, LUBRICATION_LAWS))
    assert PARAMETERS
