"""Text from outside as a terminal may print it."""

from __future__ import annotations

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.schema.printable import printable, printable_lines, shortened
from dcrb_ros.schema.refusal import LONGEST, Refusal


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("m/s² [red] é", "m/s² [red] é"),
        ("\x1b[31mred\x07", r"\x1b[31mred\x07"),
        ("a\nb\tc\rd\0", r"a\nb\tc\rd\x00"),
        ("\ud800\u202e\u2028", r"\ud800\u202e\u2028"),
    ],
)
def test_what_a_terminal_would_obey_is_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown


@given(st.text())
def test_any_text_becomes_printable_once(text: str) -> None:
    assert printable(text).isprintable()
    assert printable(printable(text)) == printable(text)
    assert printable_lines(text).count("\n") == text.count("\n")


def test_a_text_is_shortened_to_a_length() -> None:
    assert shortened("a" * 10, 10) == "a" * 10
    assert shortened("a" * 11, 10) == "aaaaaa ..."


def test_a_refusal_is_one_printable_sentence_of_limited_length() -> None:
    assert str(Refusal("the name 'a\n\x1b[2J' is unknown")) == r"the name 'a\n\x1b[2J' is unknown"
    long = str(Refusal(f"the name {'a' * 10 * LONGEST} is unknown: give another one"))
    assert len(long) == LONGEST + len(" ... ")
    assert long.startswith("the name aaa")
    assert long.endswith("aaa is unknown: give another one")
    assert str(pickle.loads(pickle.dumps(Refusal(long)))) == long
