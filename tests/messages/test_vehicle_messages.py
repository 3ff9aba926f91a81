"""The messages of a vehicle: frames, motion, ground truth and verdicts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up_blocks import BODIES, blocks

from dcrb_ros.messages.cdr import decoded, stamp_of
from dcrb_ros.messages.statuses import ERROR, OK, WARN, decode_diagnostics
from dcrb_ros.messages.topics.transforms import TF
from dcrb_ros.messages.topics.vehicle import VEHICLE_STATE
from dcrb_ros.messages.vehicle import (
    Pose,
    decode_vehicle_commands,
    encode_frames,
    encode_state,
    encode_vehicle_diagnosis,
    encode_vehicle_truth,
)
from dcrb_ros.messages.vehicle_encoder import VehicleEncoder
from dcrb_ros.stream.vehicle_diagnosis import Status, VehicleDiagnosis
from dcrb_ros.vehicle.block import VehicleBlock, VehicleTruth
from dcrb_ros.vehicle.file import read_vehicle, vehicle_of
from dcrb_ros.vehicle.frame import TrackEvent

BOXES = ("axle_1/left", "axle_1/right", "axle_2/left", "axle_2/right")


def turned(quaternion: Any, vector: tuple[float, float, float]) -> np.ndarray:
    """Return a vector of the child's frame in that of the parent."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    axis, v = np.array([x, y, z]), np.array(vector)
    return v + 2.0 * np.cross(axis, np.cross(axis, v) + w * v)


def test_frames_lead_from_the_vehicle_to_bearings_that_are_seen_from_the_left() -> None:
    transforms = {t.child_frame_id: t for t in decoded(encode_frames(read_vehicle("bogie")), TF).transforms}
    parents = {child: transform.header.frame_id for child, transform in transforms.items()}
    assert parents["bogie"] == "base_link"
    assert parents["axle_1"] == parents["axle_2"] == "bogie"
    assert {parents[box] for box in BOXES} == {"axle_1", "axle_2"}
    assert all(parents[f"{box}/outer_ring"] == box for box in BOXES)
    last = transforms["axle_1/left/outer_ring"].transform.rotation
    assert (last.x, last.y, last.z, last.w) == pytest.approx((0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0))
    # X = -x, Y = z: forward travel turns every shaft positively about Z, to the left (bogie.md, section 2).
    assert turned(last, (1.0, 0.0, 0.0)) == pytest.approx([-1.0, 0.0, 0.0])
    assert turned(last, (0.0, 1.0, 0.0)) == pytest.approx([0.0, 0.0, 1.0])
    assert turned(last, (0.0, 0.0, 1.0)) == pytest.approx([0.0, 1.0, 0.0])
    assert transforms["axle_1/left"].transform.translation.y == -transforms["axle_1/right"].transform.translation.y == 1.0
    assert transforms["axle_1"].transform.translation.x == 1.28
    # Every axle is as high over the rails as its wheels are large.
    above = transforms["bogie"].transform.translation.z
    heights = [above + transforms[axle].transform.translation.z for axle in ("axle_1", "axle_2")]
    assert heights == pytest.approx([0.46, 0.459])


@given(st.floats(-0.01, 0.01), st.integers(1, 50))
def test_a_curve_closes_at_its_radius(curvature: float, steps: int) -> None:
    pose, distance = Pose(0.0, 0.0, 0.0), 100.0
    for _ in range(steps * 100):
        pose = pose.moved(distance / (steps * 100), curvature)
    assert pose.yaw == pytest.approx(curvature * distance, abs=1e-9)
    radius = 1.0 / curvature if abs(curvature) > 1e-6 else math.inf
    sagitta = radius * (1.0 - math.cos(distance / radius)) if math.isfinite(radius) else 0.0
    assert pose.y == pytest.approx(sagitta, abs=0.01)


def test_the_state_is_an_odometry() -> None:
    state = VEHICLE_STATE.decoded(encode_state(20_000_000, Pose(3.0, 1.0, math.pi / 2.0), 30.0, 0.03))
    assert (state.header.frame_id, state.child_frame_id, state.twist.twist.linear.x, state.twist.twist.angular.z) == (
        "odom",
        "base_link",
        30.0,
        0.03,
    )
    assert turned(state.pose.pose.orientation, (1.0, 0.0, 0.0)) == pytest.approx([0.0, 1.0, 0.0])


@pytest.mark.parametrize(("start", "places"), [(0, (0.7, 1.3, 2.0)), (10**9, (5.0, 6.0, 7.0))])
def test_a_vehicle_in_a_curve_to_the_left_turns_to_the_left(start: int, places: tuple[float, ...]) -> None:
    """Odometry begins at the start of the run, or with the first block of a recording that begins later."""
    vehicle = vehicle_of({"vehicle.bench": "dry", "axle_1.left": {}, "axle_1.right": {}}, "two boxes")
    encoder = VehicleEncoder(vehicle, dict.fromkeys((box.name for box in vehicle.boxes), BODIES))
    found: dict[str, Any] = {}
    for place, made in zip(places, blocks(3), strict=True):
        parts = {box.name: (0.0, 0.0, 0.0) for box in vehicle.boxes}
        about = truth(time_ns=start + made.stamp_ns, place=place, load={}, parts=parts, creep={}, events=(), curvature=0.01)
        block = VehicleBlock(dict.fromkeys(parts, made), about, made.end_ns)
        found = {message.topic.name: message for message in encoder.encode(block)}
        assert found["/tf"].time_ns == found["vehicle/state"].time_ns == made.end_ns
    state, (moved,) = found["vehicle/state"].content, found["/tf"].content.transforms
    assert stamp_of(moved.header) == stamp_of(state.header) == made.end_ns
    assert (moved.header.frame_id, moved.child_frame_id) == ("odom", "base_link")
    for x, y, turn in (
        (state.pose.pose.position.x, state.pose.pose.position.y, state.pose.pose.orientation),
        (moved.transform.translation.x, moved.transform.translation.y, moved.transform.rotation),
    ):
        assert (x, y) == pytest.approx((2.0, 0.02), rel=1e-3)  # two metres on a radius of 100 m
        assert turned(turn, (1.0, 0.0, 0.0)) == pytest.approx([math.cos(0.02), math.sin(0.02), 0.0])
    assert state.twist.twist.angular.z == pytest.approx(30.0 * 0.01)


def test_descriptions_and_frames_are_repeated_every_second() -> None:
    vehicle = vehicle_of({"vehicle.bench": "dry", "axle_1.left": {}, "axle_1.right": {}}, "two boxes")
    names = [box.name for box in vehicle.boxes]
    encoder = VehicleEncoder(vehicle, dict.fromkeys(names, BODIES))
    first = {message.topic: message.data for message in encoder.start()}
    repeated = []
    for made in list(blocks(51))[-2:]:  # the last one begins at a second
        about = truth(time_ns=made.stamp_ns, load={}, parts={}, creep={}, events=())
        messages = encoder.encode(VehicleBlock(dict.fromkeys(names, made), about, made.end_ns))
        repeated.append({message.topic: message.data for message in messages if message.topic in first})
    assert repeated == [{}, first]


def truth(**changes: Any) -> VehicleTruth:
    about: dict[str, Any] = {
        "time_ns": 40_000_000,
        "speed": 30.0,
        "place": 1.2,
        "load": {"axle_1.left": 45e3},
        "parts": {"axle_1.left": (3.0, 2.0, 1.0)},
        "creep": {"axle_1": 0.0},
        "events": (TrackEvent(0.0412, 25.0, "axle_1.left", "joint", 0.24),),
        "silent": {},
        "commanded": {"speed_kmh": 108.0},
    }
    return VehicleTruth(**{**about, **changes})


def test_the_truth_names_boxes_levels_and_events() -> None:
    time_ns, statuses = decode_diagnostics(encode_vehicle_truth(truth()))
    by_name = {status.name: status for status in statuses}
    assert time_ns == 40_000_000
    assert float(by_name["axle_1/left"].values["other_bearings [m/s^2]"]) == 2.0
    assert (by_name["events/0"].message, by_name["events/0"].values["box"], by_name["events/0"].values["place"]) == (
        "joint",
        "axle_1/left",
        "25.0",
    )
    reason = "its sensor is swapped with that of axle_2.left"
    _, statuses = decode_diagnostics(encode_vehicle_truth(truth(silent={"axle_1.left": reason})))
    (silent,) = (status for status in statuses if status.name == "axle_1/left")
    assert (silent.level, silent.message) == (ERROR, f"{reason}: silent")


@given(st.lists(st.tuples(st.text(min_size=1), st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.text())), max_size=5))
def test_commands_are_read_back_from_the_truth(commands: list[tuple[str, float | str]]) -> None:
    plain = [(name.replace("\0", ""), value.replace("\0", "") if isinstance(value, str) else value) for name, value in commands]
    assert decode_vehicle_commands(encode_vehicle_truth(truth(commands=tuple(plain)))) == plain


def test_verdicts_have_levels_by_what_they_mean() -> None:
    statuses = {
        "axle_1/left/bearing": Status("outer_ring", "lines", 0.9, 12.0),
        "axle_1/right/bearing": Status("undecided", "alike"),
        "axle_1/left/sensor": Status("swapped", "curve"),
        "axle_2/left/wheel": Status("flat", "angle"),
        "axle_2/left/bearing": Status("healthy", "no lines"),
        "axle_1/gear": Status("gear", "mesh"),
        "track": Status("joint", "lag"),
    }
    found = {s.name: s.level for s in decode_diagnostics(encode_vehicle_diagnosis(VehicleDiagnosis(0, 1.0, statuses, {})))[1]}
    assert found == {
        "axle_1/left/bearing": ERROR,
        "axle_1/right/bearing": WARN,
        "axle_1/left/sensor": WARN,
        "axle_2/left/wheel": ERROR,
        "axle_2/left/bearing": OK,
        "axle_1/gear": OK,
        "track": OK,
    }
