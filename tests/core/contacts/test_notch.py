"""Notches in the raceways (Eqs. 8, 9 and 13 to 15 of Fan et al. 2025)."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.notch import (
    inner_notch_depth,
    joined,
    outer_notch_depth,
    passed,
    roller_notch_depth,
    roller_notch_under,
    turn_notches,
)
from dcrb_ros.core.contacts.raceway import linearize_raceways, locate_raceways
from dcrb_ros.core.jit import kernel, loop
from dcrb_ros.core.laws.johnson import johnson_force
from dcrb_ros.core.laws.site import NoMemory
from dcrb_ros.core.layout.state import State, empty_state
from dcrb_ros.core.layout.workspace import Workspace, workspace
from dcrb_ros.core.payload import ROLLER_NOTCH, Payload
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Bearing

pytestmark = pytest.mark.kernel

B = Bearing()
R_I, R_O, R_R = B.inner_raceway_radius, B.outer_raceway_radius, B.roller_radius
UNBOUNDED = 1.0


# Eqs. 8 and 14 of Fan et al. 2025 with Table 1, in the middle of a defect: alpha = b / (2 r).
@pytest.mark.parametrize(
    ("width", "inner", "outer"), [(1e-3, 9.9e-6, 7.2e-6), (2e-3, 39.7e-6, 28.8e-6), (3e-3, 89.4e-6, 64.9e-6), (5e-3, 249e-6, 181e-6)]
)
def test_sink_depth(width: float, inner: float, outer: float) -> None:
    assert inner_notch_depth(0.5 * width / R_I, UNBOUNDED, R_I, R_R) == pytest.approx(inner, rel=0.008)
    assert outer_notch_depth(0.5 * width / R_O, UNBOUNDED, R_O, R_R) == pytest.approx(outer, rel=0.008)


def test_depth_is_bounded_by_the_notch() -> None:
    assert inner_notch_depth(0.03, 1e-4, R_I, R_R) == 1e-4
    assert outer_notch_depth(0.03, 1e-4, R_O, R_R) == 1e-4


def under(width: float, azimuth: float, ring: str, **contact: object) -> Payload:
    """Return a bearing with a notch in a raceway; the roller that `contact` looks at is the first of row 1."""
    groups = {"faults": {f"{ring}_1": {"width": width, "azimuth": azimuth, "depth": 3e-4}}, "contact": contact}
    return build_payload(Configuration.model_validate(groups))


@loop
def touch_one(payload: Payload, state: State, work: Workspace) -> None:
    """Write the first roller's contacts with both raceways."""
    locate_raceways(payload, state, work, 1)
    linearize_raceways(payload, state, work, 1)


def touch(payload: Payload, inner: bool, azimuth: float, pressed: float, turn: float = 0.0) -> tuple[float, float, float, float]:
    """Return force without loss, normal and sink speed (at 1 rad/s) of a roller at an azimuth, pressed in by ``pressed`` [m]."""
    payload = payload._replace(loss_time=0.0, contact_damping=0.0)
    state, work = empty_state(payload), workspace(payload)
    turn_notches(payload.inner_notches, turn, work.inner_notch_direction)
    turn_notches(payload.outer_notches, turn, work.outer_notch_direction)
    distance = R_I + R_R - pressed if inner else R_O - R_R + pressed
    bound = work.bound[0]
    contact = bound.inner if inner else bound.outer
    work.row_ends[:] = 1
    bound.x[0], bound.y[0] = distance * math.sin(azimuth), -distance * math.cos(azimuth)
    bound.predicted_vx[0], bound.predicted_vy[0] = distance * math.cos(azimuth), distance * math.sin(azimuth)
    touch_one(payload, state, work)
    return float(contact.expected_force[0]), float(contact.normal_x[0]), float(contact.normal_y[0]), float(contact.sink_speed[0])


@given(st.floats(-3.0, 3.0), st.floats(-0.02, 0.02), st.floats(-10.0, 10.0))
def test_depth_seen_under_a_turned_ring(azimuth: float, offset: float, turn: float) -> None:
    width = 2e-3
    force, _, _, sink_speed = touch(under(width, azimuth, "inner"), True, azimuth + turn + offset, 1e-4, turn)
    edge = 0.5 * width / R_I - abs(offset)
    depth = inner_notch_depth(edge, 3e-4, R_I, R_R) if edge > 0.0 else 0.0
    payload = under(width, azimuth, "inner")
    assert force == pytest.approx(johnson_force(payload.normal_law, NoMemory(), 1e-4 - depth, payload.inner)[0], rel=5e-4)  # 10 urad a step
    assert sink_speed * offset <= 1e-12  # deeper towards the middle


@pytest.mark.parametrize(("ring", "raceway"), [("inner", R_I), ("outer", R_O)])
def test_sink_speed_is_the_derivative_of_the_depth(ring: str, raceway: float) -> None:
    payload, inner = under(3e-3, 0.3, ring), ring == "inner"
    depth_at = inner_notch_depth if inner else outer_notch_depth
    here, step = 0.004, 1e-7
    low, high = (depth_at(1.5e-3 / raceway - offset, 1.0, raceway, R_R) for offset in (here - step, here + step))
    assert touch(payload, inner, 0.3 + here, 1e-4)[3] == pytest.approx((high - low) / (2.0 * step), rel=1e-5)


def test_notch_of_one_row_leaves_the_other() -> None:
    payload = build_payload(Configuration.model_validate({"faults": {"outer_1": {"width": 2e-3, "row": 2}}}))
    smooth = build_payload(Configuration())
    assert touch(payload, False, 0.0, 1e-4) == touch(smooth, False, 0.0, 1e-4)


@pytest.mark.parametrize("inner", [True, False])
def test_notch_of_a_roller_turns_with_it(inner: bool) -> None:
    notches = np.array([(0, 3, 0.05, 0.0, 0.0, 0.0, 0.0, 3e-4, 0.0)], ROLLER_NOTCH).view(np.recarray)
    raceway = R_I if inner else R_O
    depth, _ = roller_notch_under(notches, 0, 3, 0.0, -1.0, 0.0, 1.0, 1e-4, raceway, R_R, inner)
    # The edges' chord on a raceway of radius r: R (1 - cos a) less or more the raceway's own sagitta.
    bulge = math.sqrt(raceway**2 - (R_R * math.sin(0.05)) ** 2) - raceway
    assert depth == pytest.approx(R_R * (1.0 - math.cos(0.05)) + (-bulge if inner else bulge), rel=1e-9)
    assert roller_notch_under(notches, 0, 3, 0.0, -1.0, math.pi, 1.0, 1e-4, raceway, R_R, inner) == (0.0, 0.0)
    assert roller_notch_under(notches, 0, 4, 0.0, -1.0, 0.0, 1.0, 1e-4, raceway, R_R, inner) == (0.0, 0.0)
    aside = roller_notch_under(notches, 0, 3, math.sin(2.03), -math.cos(2.03), 2.0, 1.0, 1e-4, raceway, R_R, inner)
    assert 0.0 < aside[0] < depth
    assert aside[1] < 0.0  # shallower further from the middle


NOTCH_KINDS = [("inner", 2e-3), ("inner", 8e-3), ("outer", 2e-3), ("outer", 5e-3), ("roller on inner", 3e-3), ("roller on outer", 8e-3)]


@kernel
def depth_in(edge: float, depth: float, inner: bool, own: bool) -> float:
    """Return the depth [m] of one of the four kinds of notch at an angle inside the nearer edge [rad]."""
    if own:
        return roller_notch_depth(edge, depth, R_I if inner else R_O, R_R, inner)
    return inner_notch_depth(edge, depth, R_I, R_R) if inner else outer_notch_depth(edge, depth, R_O, R_R)


@pytest.mark.parametrize(("kind", "width"), NOTCH_KINDS)
@given(share=st.floats(-1.2, 1.2), way=st.floats(-3e-3, 3e-3))
def test_depth_for_a_step_is_the_weighted_mean_about_it(kind: str, width: float, share: float, way: float) -> None:
    # Against a fine sum over a step before and after, with weights that fall to zero there; the fault's kinks lie anywhere in it.
    own, inner = kind.startswith("roller"), kind.endswith("inner")
    fault = {"roller_1": {"roller": 1, "width": width, "depth": 1.5e-4}} if own else {f"{kind}_1": {"width": width, "depth": 1.5e-4}}
    payload = build_payload(Configuration.model_validate({"faults": fault}))
    rings, rollers = payload.inner_notches if inner else payload.outer_notches, payload.roller_notches
    bottom, kink = (rollers.inner_bottom, rollers.inner_kink) if inner else (rollers.outer_bottom, rollers.outer_kink)
    half, bottom, kink = (rollers.half_angle, bottom, kink) if own else (rings.half_angle, rings.bottom, rings.kink)
    offset = share * (bottom[0] + abs(way))
    found, change = passed(offset, way, half[0], bottom[0], kink[0], 1.5e-4, R_I if inner else R_O, R_R, inner, own)
    places, weights = offset + way * np.linspace(-1.0, 1.0, 401), 1.0 - np.abs(np.linspace(-1.0, 1.0, 401))
    depths = np.array([depth_in(max(half[0] - abs(at), 0.0), 1.5e-4, inner, own) for at in places])
    edges, other = (R_R, R_I if inner else R_O) if own else (R_I if inner else R_O, R_R)
    curvature = edges * (edges / other + 1.0)
    assert found == pytest.approx(float(depths @ weights / weights.sum()), abs=0.12 * curvature * way**2 + 1e-9)  # which is left out
    assert change == pytest.approx(float(depths[300] - depths[100]), abs=1e-9)


@pytest.mark.parametrize("fault", ["inner_1", "outer_1", "roller_1"])
def test_notch_without_depth_is_none(fault: str) -> None:
    payload = build_payload(Configuration.model_validate({"faults": {fault: {"width": 2e-3, "depth": 1e-15}}}))
    for notches in (payload.inner_notches, payload.outer_notches):
        assert notches.bottom == pytest.approx(notches.half_angle, abs=1e-6)
        assert notches.kink == pytest.approx(0.0, abs=1e-6)
    assert payload.roller_notches.outer_bottom == pytest.approx(payload.roller_notches.half_angle, abs=1e-6)


@given(st.floats(-0.05, 0.05), st.floats(2e-6, 6e-5), st.sampled_from(["inner", "outer"]))
def test_edges_have_a_potential(offset: float, pressed: float, ring: str) -> None:
    # The force over the angle is the slope of the energy: no work on a closed path. Past the fillets it is the raceway's.
    inner = ring == "inner"
    payload = under(2e-3, 1e-15, ring, notch="edge", edge_radius=2e-4)
    smooth = touch(build_payload(Configuration()), inner, offset, pressed)
    force, nx, ny, _ = touch(payload, inner, offset, pressed)
    assert force <= smooth[0] * (1.0 + 1e-9)
    half = 0.5e-3 * 2.0 / (R_I if inner else R_O)
    if abs(offset) > half + 2e-4 / (R_I if inner else R_O) * 1.01:
        assert (force, nx, ny) == pytest.approx(smooth[:3])


@functools.cache
def notched(width: float, depth: float, ring: str) -> Payload:
    """Return a bearing with a notch with sharp edges at the load line."""
    groups = {"faults": {f"{ring}_1": {"width": width, "depth": depth}}, "contact": {"notch": "edge", "edge_radius": 1e-6}}
    return build_payload(Configuration.model_validate(groups))


@given(
    st.sampled_from([2e-5, 1e-4, 3e-4, 1e-3, 2e-3, 5e-3]),
    st.sampled_from([1e-6, 1e-5, 3e-4]),
    st.sampled_from(["inner", "outer"]),
    st.floats(-0.6, 0.6),
    st.floats(1e-6, 1.5e-4),
)
def test_no_notch_bears_more_than_the_smooth_raceway(width: float, depth: float, ring: str, place: float, pressed: float) -> None:
    inner = ring == "inner"
    offset = place * width / (R_I if inner else R_O)
    smooth = touch(build_payload(Configuration()), inner, offset, pressed)[0]
    assert touch(notched(width, depth, ring), inner, offset, pressed)[0] <= smooth * (1.0 + 1e-9)


@pytest.mark.parametrize("ring", ["inner", "outer"])
@pytest.mark.parametrize(("width", "lost"), [(1e-6, 1e-4), (1e-4, 0.01), (3e-4, 0.05)])
def test_a_narrow_notch_with_edges_is_no_bump(ring: str, width: float, lost: float) -> None:
    # Two edges without influence on each other would bear twice the force: 57.9 kN instead of 30.0 with 0.3 mm.
    inner, pressed = ring == "inner", 2e-5
    smooth = touch(build_payload(Configuration()), inner, 0.0, pressed)[0]
    assert touch(notched(width, 3e-4, ring), inner, 0.0, pressed)[0] == pytest.approx(smooth, rel=lost)


@given(st.floats(-5e-5, 1e-4), st.floats(1e-7, 1e-4), st.floats(1e-6, 1.0))
def test_joined_contacts_bear_as_their_energy_says(first: float, second: float, apart: float) -> None:
    whole, over_first, over_second = joined(first, second, apart)
    assert max(first, second) <= whole * (1.0 + 1e-12)
    assert min(over_first, over_second) >= 0.0
    if abs(min(first, second) - (1.0 - apart) * max(first, second)) < 1e-9:
        return  # where the second contact closes, the slope has a kink
    away = min(1e-11, 1e-3 * apart * max(first, second))
    slopes = (
        (joined(first + away, second, apart)[0] - joined(first - away, second, apart)[0]) / (2.0 * away),
        (joined(first, second + away, apart)[0] - joined(first, second - away, apart)[0]) / (2.0 * away),
    )
    assert slopes == pytest.approx((over_first, over_second), rel=1e-3, abs=1e-3)


def test_contacts_far_apart_add_and_one_contact_is_itself() -> None:
    whole, over_first, over_second = joined(3e-5, 4e-5, 1.0)
    assert (whole, over_first, over_second) == pytest.approx((5e-5, 0.6, 0.8))  # the energies of linear contacts add
    assert joined(3e-5, 3e-5, 0.0) == (3e-5, 1.0, 0.0)
    assert joined(-1.0, 3e-5, 0.5) == (3e-5, 0.0, 1.0)


@pytest.mark.parametrize("ring", ["inner", "outer"])
def test_edge_normal_leans_out_of_the_notch(ring: str) -> None:
    inner = ring == "inner"
    payload = under(2e-3, 1e-15, ring, notch="edge", edge_radius=1e-4)
    raceway = R_I if inner else R_O
    offset = 0.6e-3 / raceway  # within the notch, nearer to the edge ahead
    force, nx, ny, _ = touch(payload, inner, offset, 4e-5)
    along = nx * math.cos(offset) + ny * math.sin(offset)  # of the normal from ring to roller at the inner ring
    assert force > 0.0
    assert (along if inner else -along) < 0.0  # the edge ahead pushes the roller back into the notch
    assert abs(along) < math.sin(2e-3 / R_R)


def test_middle_of_a_notch_with_edges_sinks_as_the_papers() -> None:
    # Both edges bear at the sink depth of Eq. 14, with half the force's share each; the fillets add a little width.
    payload = under(2e-3, 0.0, "outer", notch="edge", edge_radius=1e-6)
    assert touch(payload, False, 0.0, 28.7e-6)[0] == 0.0
    assert touch(payload, False, 0.0, 29.1e-6)[0] > 0.0
