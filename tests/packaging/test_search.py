"""The search of the site."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

SITE = yaml.safe_load((Path(__file__).parents[2] / "mkdocs.yml").read_text(encoding="utf-8").replace("!ENV", ""))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("operating.speed", ["operating", "speed"]),
        ("faults.outer_1.width [m]", ["faults", "outer", "1", "width", "m"]),
        ("outer_ring/vibration", ["outer", "ring", "vibration"]),
        ("dcrb_ros.simulate", ["dcrb", "ros", "simulate"]),
        ("0.25 mm", ["0.25", "mm"]),
    ],
)
def test_words_end_at_dots_underscores_and_slashes_but_numbers_stay_whole(text: str, words: list[str]) -> None:
    (search,) = (plugin["search"] for plugin in SITE["plugins"] if isinstance(plugin, dict) and "search" in plugin)
    assert [word for word in re.split(search["separator"], text) if word] == words
