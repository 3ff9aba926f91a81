"""JSON from outside."""

from __future__ import annotations

import math

import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import DEEPEST, MOST_DIGITS, json_text, parsed_json


def test_the_size_of_a_text_is_limited() -> None:
    assert parsed_json("[1]", "it", 3) == [1]
    with pytest.raises(Refusal, match="it has 3 characters; at most 2 are read"):
        parsed_json("[1]", "it", 2)


def test_the_number_of_values_is_limited() -> None:
    assert parsed_json('[1, 2, {"a": 3}]', "it", most=4) == [1, 2, {"a": 3}]
    with pytest.raises(Refusal, match="it has some 5 values; at most 4 are read"):
        parsed_json('[1, 2, {"a": [3]}]', "it", most=4)


@pytest.mark.parametrize(("opening", "closing"), [("[", "]"), ('{"a": ', "}")])
def test_nesting_is_limited(opening: str, closing: str) -> None:
    parsed_json(opening * DEEPEST + "1" + closing * DEEPEST, "it")
    for levels in (DEEPEST + 1, 100_000):
        with pytest.raises(Refusal, match=f"it is nested more than {DEEPEST} deep: flatten it"):
            parsed_json(opening * levels + "1" + closing * levels, "it")


@pytest.mark.parametrize("number", ["NaN", "-Infinity", "1e999", "9" * (MOST_DIGITS + 1), "[", "'a'", "\udc80"])
def test_numbers_that_are_not_finite_and_broken_texts_are_refused(number: str) -> None:
    with pytest.raises(Refusal, match="it is not valid JSON: "):
        parsed_json(number, "it")


def test_bytes_are_read_as_utf_8() -> None:
    assert parsed_json('"é"'.encode(), "it") == "é"
    with pytest.raises(Refusal, match="it is not valid JSON"):
        parsed_json(b'"\xff"', "it")


def test_a_number_that_json_does_not_have_is_null() -> None:
    tree = {"peak": math.inf, "levels": (1.5, math.nan), "name": "nan", "boxes": {"a": -math.inf}}
    assert parsed_json(json_text(tree), "text") == {"peak": None, "levels": [1.5, None], "name": "nan", "boxes": {"a": None}}
