"""Kinds of faults: their parameters, what follows from them, and what is refused."""

from __future__ import annotations

import math
import pickle
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.faults import Faults
from dcrb_ros.faults.broken_bars import BrokenBars
from dcrb_ros.faults.fault import Fault, Footprint
from dcrb_ros.faults.geometry import BrokenBar, RacewayNotch, RollerNotch
from dcrb_ros.faults.ground_truth import class_of, words_of
from dcrb_ros.faults.group import fault_group
from dcrb_ros.faults.raceway_defect import InnerRacewayDefect, OuterRacewayDefect
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import (
    CHARACTERISTIC,
    COMPONENTS,
    FAULT_CLASSES,
    TITLES,
    TROUBLES,
    VERDICTS,
    FaultClass,
    fault_class,
    is_alarm,
    title_of,
)
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import fields_by_key
from dcrb_ros.settings.parameters import Bearing

BEARING = Bearing()
ALL = Configuration.model_validate(
    {
        "faults": {
            "outer_1": {"width": 2e-3, "row": 1},
            "inner_2": {"width": 1e-3},
            "roller_1": {"width": 1e-3, "roller": 5},
            "broken_bars": "row2/bar3",
        }
    }
).faults


CONDITIONS = ("lubrication", "overfilled", "seal_rub", "clearance")
"""Keys of the faults that damage nothing."""


@pytest.mark.parametrize("kind", dict.fromkeys(Faults.kinds.values()))
def test_the_default_of_a_kind_is_no_fault(kind: type[Fault]) -> None:
    _, default = kind.parameter()
    fault = kind.from_parameter(getattr(default, "default", default))
    assert not fault.present
    assert kind.component in (*COMPONENTS, *TROUBLES)


@pytest.mark.parametrize("key", Faults.kinds)
def test_every_parameter_of_a_fault_changes_at_run_time(key: str) -> None:
    of_fault = [field for name, field in fields_by_key().items() if name.split(".")[:2] == ["faults", key]]
    assert of_fault
    assert all(field.run_time for field in of_fault)


def test_the_keys_stand_in_the_order_of_the_kinds() -> None:
    shipped = ["outer_1", "outer_2", "inner_1", "inner_2", "roller_1", "roller_2", "broken_bars", *CONDITIONS]
    assert list(Faults.model_fields)[: len(shipped)] == shipped


def test_a_group_of_faults_can_be_pickled() -> None:
    assert pickle.loads(pickle.dumps(ALL)) == ALL


def test_faults_are_described_by_their_names() -> None:
    assert ALL.described() == {
        "outer_1": {"width": 2e-3, "depth": 3e-4, "row": 1, "azimuth": 0.0},
        "inner_2": {"width": 1e-3, "depth": 3e-4, "row": 0, "azimuth": 0.0},
        "roller_1": {"width": 1e-3, "depth": 3e-4, "row": 1, "roller": 5, "azimuth": 0.0},
        "broken_bars.row2/bar3": {"row": 2, "bar": 3},
    }


def test_every_fault_becomes_one_record_for_the_kernels() -> None:
    outer, inner, roller, bar = ALL.damage(BEARING)
    assert isinstance(outer, RacewayNotch)
    assert (outer.ring, outer.row) == ("outer_ring", 0)
    assert isinstance(inner, RacewayNotch)
    assert (inner.ring, inner.row) == ("inner_ring", -1)
    assert isinstance(roller, RollerNotch)
    assert (roller.row, roller.roller) == (0, 4)
    assert bar == BrokenBar(1, 2)


def test_rounded_edges_widen_the_reach_of_a_notch() -> None:
    (sharp,), (rounded,) = (list(OuterRacewayDefect(width=2e-3).damage(BEARING, radius)) for radius in (0.0, 1e-3))
    assert math.acos(sharp.nearness) == pytest.approx(1e-3 / BEARING.outer_raceway_radius)
    assert math.acos(rounded.nearness) == pytest.approx(2e-3 / BEARING.outer_raceway_radius)
    assert rounded[:3] == sharp[:3]


def test_a_roller_reaches_the_floor_of_a_wide_notch_only() -> None:
    # A roller of radius R dips between edges b apart by b^2/(8 R), R the reduced radius: 17.4 mm on the outer raceway.
    dip = 3e-4
    narrowest = math.sqrt(8.0 * dip / (1.0 / BEARING.roller_radius - 1.0 / BEARING.outer_raceway_radius))
    for width, reached in ((0.95 * narrowest, False), (1.05 * narrowest, True)):
        (notch,) = OuterRacewayDefect(width=width, depth=dip).damage(BEARING, 0.0)
        assert (notch.bottom > 0.0) == reached


FOOTPRINTS = st.builds(
    Footprint,
    st.sampled_from(["outer_ring", "inner_ring"]),
    st.integers(0, 2),
    st.just(0),
    st.floats(-math.pi, math.pi),
    st.floats(1e-4, 0.05),
    st.just(0.1),
)


@given(FOOTPRINTS, FOOTPRINTS)
def test_footprints_overlap_in_both_directions_or_in_none(one: Footprint, other: Footprint) -> None:
    assert one.overlaps(other) == other.overlaps(one)
    assert one.overlaps(one)
    if one.body != other.body or {one.row, other.row} == {1, 2}:
        assert not one.overlaps(other)


def test_defects_may_not_overlap_across_the_seam_of_the_angle() -> None:
    near = OuterRacewayDefect(width=1e-3, azimuth=3.14), OuterRacewayDefect(width=1e-3, azimuth=-3.14)
    (one,), (other,) = (defect.footprints(BEARING) for defect in near)
    assert one.gap(other) == pytest.approx((2.0 * math.pi - 6.28) * BEARING.outer_raceway_radius)
    assert one.overlaps(other)
    assert not one.overlaps(*InnerRacewayDefect(width=1e-3, azimuth=3.14).footprints(BEARING))


@pytest.mark.parametrize(
    ("kind", "azimuth", "overlaps"),
    [
        ("notch", 2.1e-3, False),
        ("spall", 2.1e-3, False),
        ("dent", 3.9e-3, True),
        ("dent", 4.1e-3, False),
        ("scratch", 5.9e-3, True),
        ("scratch", 6.1e-3, False),
        ("brinelling", 2.0 * math.pi / 16 * BEARING.outer_raceway_radius, True),
        ("brinelling", math.pi / 16 * BEARING.outer_raceway_radius, False),
    ],
)
def test_damage_reaches_as_far_as_its_shape_and_to_all_its_places(kind: str, azimuth: float, overlaps: bool) -> None:
    """Two defects of 2 mm, a notch at an azimuth [m] from the other: a dent reaches 3 mm to each side, a scratch 5 mm."""
    notch = {"width": 2e-3, "azimuth": azimuth / BEARING.outer_raceway_radius}
    faults = Faults.model_validate({"outer_1": {"kind": kind, "width": 2e-3, "depth": 1e-5}, "outer_2": notch})
    assert any("faults.outer_2 overlaps faults.outer_1" in problem for problem in faults.problems(BEARING)) is overlaps


def test_a_broken_bar_does_not_heal() -> None:
    before, after = BrokenBars(text="row1/bar3, row1/bar4"), BrokenBars(text="row1/bar4, row2/bar1")
    assert [words.split(" ", 1)[0] for words in before.unhealed(after)] == ["row1/bar3"]
    assert list(OuterRacewayDefect(width=1e-3).unhealed(OuterRacewayDefect())) == []


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ([], "healthy"),
        (["roller_2"], "roller"),
        (["outer_1", "outer_2"], "outer_ring"),
        (["broken_bars.row1/bar15", "broken_bars.row2/bar15"], "cage"),
        (["outer_1", "inner_1"], "compound"),
        (["outer_1", "roller_1"], "compound"),
        (["sensor.stuck"], "sensor"),
        (["outer_1", "sensor.dead"], "sensor"),
    ],
)
def test_the_class_follows_from_the_names_in_the_ground_truth(names: list[str], expected: FaultClass) -> None:
    assert class_of(names) == expected


def test_an_unknown_fault_has_no_class() -> None:
    with pytest.raises(Refusal, match="names the fault 'gremlin', whose verdict is unknown"):
        class_of(["gremlin"])


def test_faults_have_words() -> None:
    assert [words_of(name, fields) for name, fields in ALL.described().items()] == [
        "outer_1: 2 mm wide",
        "inner_2: 1 mm wide",
        "roller_1: 1 mm wide on roller 5",
        "bar 3 broken",
    ]
    assert words_of("sensor.gain_drift", {"severity": 1.0, "axis": 0.0}) == "sensor gain_drift"
    assert words_of("of_another_version", {"width": 1e-3}) == "of_another_version: 1 mm wide"


def test_verdicts_are_listed_once() -> None:
    assert set(VERDICTS) == {*FAULT_CLASSES, "waiting"} == set(TITLES)
    assert set(CHARACTERISTIC) == set(COMPONENTS) < set(FAULT_CLASSES)
    assert get_args(FaultClass) == FAULT_CLASSES
    assert [verdict for verdict in VERDICTS if not is_alarm(verdict)] == ["healthy", "waiting"]


@given(st.lists(st.sampled_from(FAULT_CLASSES)), st.randoms())
def test_the_class_of_several_faults_does_not_depend_on_their_order(faults: list[FaultClass], random: object) -> None:
    shuffled = sorted(faults)
    random.shuffle(shuffled)  # type: ignore[attr-defined] # hypothesis gives a random.Random
    assert fault_class(shuffled) == fault_class(faults) == fault_class({*faults, "healthy"})


def test_two_kinds_cannot_have_the_same_key() -> None:
    with pytest.raises(TypeError, match="have the same key 'outer_1'"):
        fault_group([OuterRacewayDefect, OuterRacewayDefect])


def test_the_title_of_several_faults_names_them() -> None:
    scores = {"outer_ring": -1.0, "inner_ring": 6.6, "roller": -4.9, "cage": -2.0}
    assert title_of("compound", scores) == "several faults: inner ring defect, outer ring defect"
    assert title_of("compound", {**scores, "cage": 1.0, "outer_ring": 0.0}).endswith(": inner ring defect, cage fault, outer ring defect")
    assert title_of("compound", {}) == "several faults"
    assert title_of("cage", scores) == "cage fault"
    assert title_of("of another detector", {}) == "of another detector"
