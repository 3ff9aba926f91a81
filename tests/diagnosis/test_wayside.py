"""The wayside hot-box detector: once per passage, by its two rules, with its errors."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.diagnosis.wayside import AxleBoxes, Passage, Wayside, WaysideParameters
from dcrb_ros.messages.statuses import ERROR, OK, decode_diagnostics
from dcrb_ros.messages.topics.wayside import WAYSIDE_TEMPERATURE, encode_alarm, encode_reading

HEALTHY = AxleBoxes(box=35.0, outer_ring=42.0, opposite_box=35.0, opposite_outer_ring=42.0, ambient=20.0)
SPEED = 125.664
"""Of the shaft, 57.8 m/s on wheels of 0.92 m [rad/s]."""


def passages(boxes: AxleBoxes, parameters: WaysideParameters, seconds: int, acceleration: float = 1.0) -> list[Passage]:
    """Return the readings over some time in steps of a second."""
    line = Wayside(parameters)
    found = (line.follow(k * 1_000_000_000, SPEED, boxes, acceleration) for k in range(seconds + 1))
    return [one for one in found if one is not None]


def test_a_box_is_read_once_for_each_spacing() -> None:
    found = passages(HEALTHY, WaysideParameters(spacing=30.0), 3600)
    assert len(found) == int(3600 * 57.805 / 30e3)
    assert [one.distance for one in found] == pytest.approx([30.0 * (k + 1) for k in range(len(found))], abs=0.06)
    assert len(passages(HEALTHY, WaysideParameters(spacing=30.0), 36, acceleration=100.0)) == len(found)


def test_the_first_detector_has_a_place_of_its_own() -> None:
    found = passages(HEALTHY, WaysideParameters(first=5.0, spacing=30.0), 1200)
    assert [one.distance for one in found] == pytest.approx([5.0, 35.0, 65.0], abs=0.06)


def test_a_reading_is_the_box_with_a_part_of_the_ring_and_the_error_of_emissivity() -> None:
    (one, *_) = passages(HEALTHY, WaysideParameters(noise=0.0), 1200)
    assert one.reading == pytest.approx(35.0 + 0.15 * 7.0)
    (dull, *_) = passages(HEALTHY, WaysideParameters(noise=0.0, emissivity_error=-0.5), 1200)
    assert dull.reading - 20.0 == pytest.approx(0.5 * (one.reading - 20.0))


def test_readings_scatter_as_said() -> None:
    readings = np.array([one.reading for one in passages(HEALTHY, WaysideParameters(spacing=1.0, noise=3.0), 20_000)])
    assert readings.std() == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize(("box", "rules"), [(35.0, (False, False)), (90.0, (False, True)), (113.0, (False, True)), (115.0, (True, True))])
def test_the_rules_are_94_kelvin_over_ambient_and_53_over_the_other_box(box: float, rules: tuple[bool, bool]) -> None:
    boxes = AxleBoxes(box=box, outer_ring=box, opposite_box=35.0, opposite_outer_ring=35.0, ambient=20.0)
    (one, *_) = passages(boxes, WaysideParameters(noise=0.0), 1200)
    assert (one.over_ambient, one.over_opposite) == rules
    assert one.alarm is any(rules)
    _, (status,) = decode_diagnostics(encode_alarm(one))
    assert status.level == (ERROR if one.alarm else OK)
    assert WAYSIDE_TEMPERATURE.decoded(encode_reading(one, 3.0)) == pytest.approx(box)


def test_a_healthy_bench_has_all_that_the_detector_looks_at() -> None:
    import dcrb_ros

    truths = dcrb_ros.simulate("healthy", 0.1, settings={"thermal.law": "network", "faults.lubrication.loss": 0.3}).truth.truths
    found = truths[-1].thermal
    assert found["opposite_box [deg C]"] > found["box [deg C]"]  # a starved bearing is cooler at first
    assert 10.0 < found["opposite_box [deg C]"] - found["ambient [deg C]"] < 45.0
