"""Profiles of surfaces: interpolation, where they lie, and that one with the shape of a notch does what the notch does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.equilibrium import static_equilibrium
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.bearing.profiles import profile_records
from dcrb_ros.core.contacts.notch import inner_notch_depth, outer_notch_depth
from dcrb_ros.core.contacts.profile import profile_depth, profiles_under
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.faults.geometry import SurfaceProfile
from dcrb_ros.settings.configuration import Configuration

SAMPLES = (0.0, 1e-6, 4e-6, 3e-6, -1e-6, 0.0)
under = getattr(profiles_under, "py_func", profiles_under)


def with_profiles(payload: Payload, profiles: Sequence[SurfaceProfile]) -> Payload:
    """Return a bearing with profiles on its surfaces."""
    records, depths, height = profile_records(profiles)
    return payload._replace(profiles=records, profile_depths=depths, profile_height=height, any_defect=True)


@pytest.mark.kernel
@pytest.mark.parametrize("spacing", [0.0, 0.01])
def test_interpolation_meets_the_samples(spacing: float) -> None:
    records, depths, _ = profile_records([SurfaceProfile("outer_ring", SAMPLES, spacing=spacing)])
    count, apart = len(SAMPLES), spacing or 2.0 * math.pi / len(SAMPLES)
    begin = 0.0 if spacing == 0.0 else -0.5 * (count - 1) * spacing
    for turn in (0.0, 2.0 * math.pi, -4.0 * math.pi):
        found = [profile_depth(records, depths, 0, begin + i * apart + turn) for i in range(count)]
        assert found == pytest.approx(SAMPLES, abs=1e-15)


@pytest.mark.kernel
@pytest.mark.parametrize("spacing", [0.0, 0.01])
@given(angle=st.floats(-0.06, 0.06))
def test_depth_and_slope_are_continuous(spacing: float, angle: float) -> None:
    records, depths, _ = profile_records([SurfaceProfile("outer_ring", SAMPLES, spacing=spacing)])
    step = 1e-7
    at = [profile_depth(records, depths, 0, angle + n * step) for n in (-1, 0, 1)]
    steepest = 2.0 * 5e-6 / 0.01
    assert abs(at[2] - at[0]) <= 2.0 * step * steepest
    assert abs(at[2] - 2.0 * at[1] + at[0]) <= step**2 * 40.0 * 5e-6 / 0.01**2 + 1e-20


@pytest.mark.kernel
def test_a_window_ends() -> None:
    records, depths, _ = profile_records([SurfaceProfile("outer_ring", (1e-6,) * 4, azimuth=0.5, spacing=0.01)])
    assert profile_depth(records, depths, 0, 0.036) == 0.0
    assert profile_depth(records, depths, 0, -0.036) == 0.0
    assert profile_depth(records, depths, 0, 0.0) == pytest.approx(1e-6)


HEALTHY = build_payload(Configuration())


@pytest.mark.kernel
def test_profile_lies_where_it_was_put() -> None:
    window = (1e-6,) * 4
    profiles = [
        SurfaceProfile("inner_ring", window, azimuth=0.3, spacing=0.01, row=1),
        SurfaceProfile("roller", window, azimuth=0.2, spacing=0.01, row=0, roller=3),
    ]
    payload = with_profiles(HEALTHY, profiles)

    def depth(row: int, i: int, azimuth: float, turn: float, angle: float, inner: bool) -> float:
        return float(under(payload, row, i, math.sin(azimuth), -math.cos(azimuth), 0.0, 0.0, turn, 0.0, angle, inner)[0])

    assert depth(1, 0, 0.3 + 1.0, 1.0, 0.0, True) == pytest.approx(1e-6)  # turns with the shaft
    assert depth(0, 0, 0.3 + 1.0, 1.0, 0.0, True) == 0.0
    assert depth(1, 0, 0.3, 0.0, 0.0, False) == 0.0
    assert depth(0, 3, 0.2 + 2.0, 0.0, 2.0, False) == pytest.approx(1e-6)  # turns with the roller
    assert depth(0, 3, 0.2 + 2.0 + math.pi, 0.0, 2.0, True) == pytest.approx(1e-6)  # the inner raceway is on its other side
    assert depth(0, 4, 0.2 + 2.0, 0.0, 2.0, False) == 0.0


@pytest.mark.kernel
def test_growth_is_the_chord_over_the_way() -> None:
    payload = with_profiles(HEALTHY, [SurfaceProfile("outer_ring", SAMPLES, spacing=0.01)])
    orbit = 50.0
    way = payload.step * orbit
    _, change = under(payload, 0, 0, math.sin(0.004), -math.cos(0.004), orbit, 0.0, 0.0, 0.0, 0.0, False)
    before, after = (profile_depth(payload.profiles, payload.profile_depths, 0, 0.004 + sign * 0.5 * way) for sign in (-1.0, 1.0))
    assert change == pytest.approx(after - before, rel=1e-6)


def run(payload: Payload, steps: int, groups: dict[str, Any]) -> npt.NDArray[np.float64]:
    """Return the outer ring's acceleration, from the static equilibrium of a bearing."""
    state = initial_state(Configuration.model_validate(groups), payload)
    acceleration = np.empty((steps, 2))
    advance(payload, state, workspace(payload), acceleration, np.empty(steps))
    return acceleration


@pytest.mark.parametrize("joint", ["revolute", "pocket"])
def test_profile_without_depth_changes_no_bit(joint: str) -> None:
    groups = {"cage": {"joint": joint}}
    payload = build_payload(Configuration.model_validate(groups))
    flat = with_profiles(payload, [SurfaceProfile("outer_ring", (0.0,) * 8), SurfaceProfile("inner_ring", (0.0,) * 8)])
    assert np.array_equal(run(flat, 1500, groups), run(payload, 1500, groups))


@pytest.mark.parametrize(("joint", "ring"), [("revolute", "outer"), ("pocket", "outer"), ("revolute", "inner")])
def test_profile_with_the_shape_of_a_notch_strikes_like_it(joint: str, ring: str) -> None:
    width, azimuth, cage = 2e-3, 0.05 if ring == "outer" else -0.05, {"cage": {"joint": joint}}
    notched = build_payload(Configuration.model_validate({**cage, "faults": {f"{ring}_1": {"width": width, "azimuth": azimuth}}}))
    smooth = build_payload(Configuration.model_validate(cage))
    raceway = smooth.outer_raceway_radius if ring == "outer" else smooth.inner_raceway_radius
    law = outer_notch_depth if ring == "outer" else inner_notch_depth
    spacing, half = 2e-5, 0.5 * width / raceway
    count = 2 * math.floor(half / spacing) + 1
    angles = spacing * (np.arange(count) - 0.5 * (count - 1))
    depths = tuple(law(half - abs(angle), 1.0, raceway, smooth.roller_radius) for angle in angles)
    profiled = with_profiles(smooth, [SurfaceProfile(f"{ring}_ring", depths, azimuth=azimuth, spacing=spacing)])  # type: ignore[arg-type]
    # The impact and some steps after it; later on idle rollers amplify the difference at the kink in the middle of the notch.
    found, expected = run(profiled, 150, cage), run(notched, 150, cage)
    assert np.abs(expected).max() > 100.0
    assert np.linalg.norm(found - expected) < 0.03 * np.linalg.norm(expected)


def test_equilibrium_rests_in_profiles() -> None:
    # The outer raceway 10 um wider all round: the rings move apart by so much, and the forces stay.
    wide = with_profiles(HEALTHY, [SurfaceProfile("outer_ring", (1e-5,) * 8)])
    load = np.array([0.0, -100e3])
    apart = [rest.inner - rest.outer for rest in (static_equilibrium(HEALTHY, load), static_equilibrium(wide, load))]
    assert apart[1][1] - apart[0][1] == pytest.approx(-1e-5, abs=1e-6)


def test_idle_rollers_lie_on_the_profile() -> None:
    # The centrifugal force of 65 N: 0.248 kg at 52.8 rad/s and 93.9 mm.
    wide = with_profiles(HEALTHY, [SurfaceProfile("outer_ring", (1e-5,) * 8)])
    state = initial_state(Configuration(), wide)
    advance(wide, state, workspace(wide), np.empty((40, 2)), np.empty(40))
    assert state.outer_force[:, 5:12] == pytest.approx(65.0, abs=15.0)


@pytest.mark.parametrize(
    ("profile", "message"),
    [
        (SurfaceProfile("outer_ring", (0.0,) * 3), "has 3 samples: give at least 4"),
        (SurfaceProfile("roller", (0.0, math.nan, 0.0, 0.0)), "all of them finite"),
        (SurfaceProfile("inner_ring", (0.0,) * 100, spacing=0.1), "make it periodic or shorter"),
    ],
)
def test_impossible_profiles_are_refused(profile: SurfaceProfile, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        profile_records([profile])
