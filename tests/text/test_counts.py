"""Numbers of things in sentences."""

from __future__ import annotations

import pytest

from dcrb_ros.text.counts import counted


@pytest.mark.parametrize(("number", "words"), [(0, "0 recordings"), (1, "1 recording"), (2, "2 recordings")])
def test_one_thing_is_singular(number: int, words: str) -> None:
    assert counted(number, "recording") == words
