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


def test_a_value_within_the_range_has_no_flaw() -> None:
    assert flaw_of(fields_by_key()["operating.speed"], 100.0) == ""
