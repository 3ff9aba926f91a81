"""The data card."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from dcrb_ros.sweep.card import card
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.table import Tally


def card_of(tree: dict[str, Any]) -> str:
    tally = Tally(statuses=Counter({"done": 2, "refused": 1}), reasons=Counter({"the rollers do not fit": 1}), seconds=0.2)
    return card(Plan(sweep_of({"duration": 0.1, **tree}, "sweep.yaml")), tally)


def test_unrecorded_time_is_mentioned_only_if_there_is_any() -> None:
    assert "not recorded" not in card_of({})
    assert "The first 0.05 s of a run are not recorded." in card_of({"settle": 0.05})


@pytest.mark.parametrize(
    ("tree", "words"),
    [
        ({}, "double-row roller"),
        ({"set": {"bearing.rows": 1}}, "single-row roller"),
        ({"vary": {"bearing.rows": [2, 1]}}, "single-row or double-row roller"),
        ({"design": "random", "points": 2, "vary": {"bearing.rows": {"low": 1, "high": 2}}}, "single-row or double-row roller"),
    ],
)
def test_the_title_names_the_rows_of_the_bearing(tree: dict[str, Any], words: str) -> None:
    assert card_of(tree).startswith(f"# Vibration of a simulated {words} bearing\n")


def test_refused_runs_are_counted_with_their_reasons() -> None:
    found = card_of({})
    assert "3 runs were planned, with the outcomes 2 done, 1 refused." in found
    assert "Reasons of the runs that were refused or failed:\n\n* 1 x the rollers do not fit" in found


def test_axes_have_units_and_texts_with_commas_are_told_apart() -> None:
    bars, many = ["row1/bar3", "row1/bar15, row2/bar15"], [float(speed) for speed in range(50, 73)]
    found = card_of(
        {
            "vary": {"operating.speed": many, "operating.load": {"low": 1e4, "high": 1e5, "scale": "log", "count": 2}},
            "duration": 3.0,
            "cases": {"cage": {"faults.broken_bars": bars}, "grows": {"scenario": "growing_spall"}},
        }
    )
    assert "* `operating.load` [N]: 10000 to 100000, logarithmic" in found
    assert "68.0, 69.0 and 3 more\n" in found
    assert "* case `cage`: `faults.broken_bars`: `row1/bar3`, `row1/bar15, row2/bar15`" in found
    assert "* case `grows`: `scenario`: `growing_spall`" in found


@pytest.mark.parametrize(
    ("seeds", "words"), [(1, "one seed per condition"), (3, "3 seeds per condition"), ([4, 5], "seeds: 4, 5 in every condition")]
)
def test_seeds_are_described(seeds: int | list[int], words: str) -> None:
    assert f"* {words}; every run is simulated from its own start" in card_of({"seeds": seeds})


def test_a_case_shows_every_value_of_the_file_and_a_twin_no_fault() -> None:
    bench = {"base": "outer_ring_defect", "cases": {"none": {}, "notch": {"faults.outer_1.kind": "notch"}}}
    width = {"faults.inner_1.width": 0.001}
    found = card_of({**bench, "cases": {**bench["cases"], "inner": width}, "vary": {"operating.speed": [50.0, 60.0]}})
    assert "* case `none`: as the base\n" in found
    assert "* case `notch`: `faults.outer_1.kind`: `notch`\n" in found  # the value of the base
    assert "* case `healthy`: no fault\n* case `inner`: `faults.inner_1.width` [m]: 0.001\n" in card_of(
        {"base": "outer_ring_defect", "twins": True, "cases": {"inner": width}}
    )
