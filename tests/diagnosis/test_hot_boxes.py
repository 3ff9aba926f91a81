"""Rules for the boxes of a train: each at its limit, blind where the sun would trip it, and read by a line of wayside detectors."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.diagnosis.hot_boxes import HotBoxParameters, hot_boxes, opposite_of
from dcrb_ros.diagnosis.wayside import Box, Wayside, WaysideParameters

BOXES = ("axle_1.left", "axle_1.right", "axle_2.left", "axle_2.right")
BOTH = HotBoxParameters(rules="both")


def rules(hot: str, above: float, *, ambient: float = 20.0, others: float = 35.0, speed: float = 20.0) -> list[str]:
    readings = {box: others + (above if box == hot else 0.0) for box in BOXES}
    broken = hot_boxes(readings, ambient, speed, BOTH)
    assert {each.box for each in broken} <= {hot}
    return [each.rule for each in broken]


@pytest.mark.parametrize(
    ("above", "expected"),
    [
        (14.9, []),
        (15.1, ["others"]),
        (35.1, ["absolute", "others"]),  # 70 deg C
        (52.9, ["opposite", "absolute", "others"]),  # 95 F
        (79.5, ["ambient", "opposite", "absolute", "others"]),  # 170 F over 20 deg C
    ],
)
def test_each_rule_has_its_limit(above: float, expected: list[str]) -> None:
    assert rules("axle_2.right", above) == expected


def test_the_sun_of_a_station_alarms_no_one_below_30_km_per_hour() -> None:
    # 108 W warm a box by 20 K at rest.
    assert rules("axle_1.left", 20.0, speed=0.0) == rules("axle_1.left", 20.0, speed=29.0 / 3.6) == []
    assert rules("axle_1.left", 20.0, speed=31.0 / 3.6) == ["others"]


def test_the_sun_on_a_side_breaks_no_rule_of_the_us() -> None:
    readings = {"axle_1.left": 38.2, "axle_1.right": 35.0, "axle_2.left": 38.2, "axle_2.right": 35.0}
    assert hot_boxes(readings, 20.0, 20.0, HotBoxParameters()) == []


def test_the_sets_have_rules_of_their_own() -> None:
    readings = dict.fromkeys(BOXES, 35.0) | {"axle_1.left": 150.0}
    assert [hot.rule for hot in hot_boxes(readings, 20.0, 20.0, HotBoxParameters(rules="us"))] == ["ambient", "opposite"]
    assert [hot.rule for hot in hot_boxes(readings, 20.0, 20.0, HotBoxParameters(rules="workshop"))] == ["absolute", "others"]


@given(st.floats(-20.0, 40.0), st.floats(0.0, 60.0), st.floats(-30.0, 30.0))
def test_rules_across_axle_and_train_do_not_depend_on_the_weather(ambient: float, above: float, warmer: float) -> None:
    across = []
    for base in (ambient + 15.0, ambient + 15.0 + warmer):
        readings = {box: base + (above if box == BOXES[2] else 0.0) for box in BOXES}
        across.append([each.rule for each in hot_boxes(readings, ambient, 20.0, BOTH) if each.rule in ("opposite", "others")])
    if min(abs(above - 15.0), abs(above - 52.8)) > 1e-6:
        assert across[0] == across[1]


def test_a_sensor_without_a_reading_blinds_no_rule_for_the_other_boxes() -> None:
    readings = dict.fromkeys(BOXES, 35.0) | {"axle_1.left": 60.0, "axle_2.left": float("nan")}
    assert [(hot.box, hot.rule) for hot in hot_boxes(readings, 20.0, 20.0, BOTH)] == [("axle_1.left", "others")]
    assert hot_boxes(dict.fromkeys(BOXES, float("nan")), 20.0, 20.0, BOTH) == []


def test_a_missing_neighbour_leaves_the_rules_that_need_none() -> None:
    assert opposite_of("axle_2.right") == "axle_2.left"
    assert [hot.rule for hot in hot_boxes({"axle_1.left": 150.0}, 20.0, 20.0, BOTH)] == ["ambient", "absolute"]


def test_a_line_of_detectors_reads_every_box_of_a_train_once_per_passage() -> None:
    line, passages = Wayside(WaysideParameters(spacing=30.0, noise=0.0)), []
    boxes = {name: Box(35.0, 40.0) for name in BOXES} | {"axle_2.left": Box(100.0, 140.0)}
    for second in range(3601):
        passages.append(line.follow_train(second * 1_000_000_000, 20.0, boxes, 20.0, HotBoxParameters()))
    read = [passage for passage in passages if passage is not None]
    assert [round(passage.distance) for passage in read] == [30, 60]  # 72 km
    assert read[0].readings["axle_1.left"] == pytest.approx(35.0 + 0.15 * 5.0)
    assert [(hot.box, hot.rule) for hot in read[0].hot] == [("axle_2.left", "opposite")]
