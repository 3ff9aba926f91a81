"""Parameters with dotted keys as trees."""

from __future__ import annotations

from typing import Any

import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten, nest


@pytest.mark.parametrize("flat", [{}, {"a": 1}, {"a.b": 1, "a.c.d": 2.0, "e": "x"}, {"a": {}, "b.c": {}}])
def test_a_tree_has_the_keys_from_which_it_is_made(flat: dict[str, Any]) -> None:
    assert flatten(nest(flat)) == flat


@pytest.mark.parametrize(
    ("flat", "sentence"),
    [
        ({"a.b": 1.5, "a.b.c": 2}, "a.b.c is below b, which has the value 1.5: give one of them"),
        ({"a.b.c": 2, "a.b": 1.5}, "a.b has the value 1.5, and c is below it: give one of them"),
        ({"a": "x", "a.b.c": 2}, "a.b.c is below a, which has the value 'x'"),
    ],
)
def test_a_key_below_a_value_is_refused(flat: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal) as refused:
        nest(flat)
    assert sentence in str(refused.value)


def test_an_empty_group_takes_keys() -> None:
    assert nest({"a": {}, "a.b": 1}) == {"a": {"b": 1}}
