"""A value of a parameter is refused by its type before its range."""

from __future__ import annotations

from typing import Any

import pytest

from dcrb_ros.schema.parameter_field import flaw_of
from dcrb_ros.settings.files import fields_by_key


@pytest.mark.parametrize("value", [{}, [], None, "text", True])
def test_a_value_of_another_kind_is_refused_in_a_sentence(value: Any) -> None:
    field = fields_by_key()["operating.speed"]
    assert "is not a number within" in flaw_of(field, value)


@pytest.mark.parametrize(
    ("value", "flaw"),
    [
        (25600.0, "25600.0 Hz is written with a decimal point: write 25600"),
        (25600.5, "25600.5 Hz is not a whole number within 1000 .. 204800 Hz"),
        (1e300, "1e+300 Hz is not a whole number within 1000 .. 204800 Hz"),
    ],
)
def test_a_whole_number_with_a_decimal_point_is_refused_with_the_number_to_write(value: float, flaw: str) -> None:
    assert flaw_of(fields_by_key()["sensor.sampling_rate"], value) == f"sensor.sampling_rate = {flaw}"


def test_a_value_within_the_range_has_no_flaw() -> None:
    assert flaw_of(fields_by_key()["operating.speed"], 100.0) == ""
