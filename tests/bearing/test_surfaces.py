"""Heights along the path of a contact; the numbers are those of docs/explanation/surfaces.md."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from even_surfaces import EVEN
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import j1

from dcrb_ros.bearing.contact_path import EDGE_AVERAGE, averaged, contact_path, envelope, half_width, notch_heights, reduced_radii
from dcrb_ros.bearing.damage_tables import RACEWAY_NODES
from dcrb_ros.bearing.surfaces import build_surfaces, raceway_waves, short_waves
from dcrb_ros.core.contacts.heights import Profile, Smooth, curve, marked, packed, place_of, unpacked
from dcrb_ros.core.layout.records import Integers
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration

OUTER_RADIUS, INNER_RADIUS = 17.390e-3, 12.603e-3
"""Reduced radii of the default bearing [m]."""


def surfaces(*, faults: dict[str, Any] | None = None, **changes: Any) -> Profile:
    made = Configuration.model_validate({"surfaces": EVEN | changes, "faults": faults or {}})
    found, _ = build_surfaces(made, made.faults.damage(made.bearing))
    assert isinstance(found, Profile)
    return found


def read_at(table: Integers, angle: float) -> tuple[float, float]:
    """Return height [m] and slope [m/rad] at an angle [rad] of a table of nodes."""
    nodes = len(table) - 1
    node, way = place_of(angle, nodes)
    height, slope = curve(int(table[node]), int(table[node + 1]), 2.0 * math.pi / nodes, way)
    return float(height), float(slope)


def test_the_reduced_radii_are_those_of_the_default_bearing() -> None:
    assert reduced_radii(Configuration()) == pytest.approx((INNER_RADIUS, OUTER_RADIUS), rel=1e-4)


@pytest.mark.parametrize(("radius", "depth"), [(OUTER_RADIUS, 28.75e-6), (INNER_RADIUS, 39.67e-6)])
def test_a_rigid_roller_sinks_into_a_notch_as_the_paper_says(radius: float, depth: float) -> None:
    """(b/2)^2/(2 R) for b = 2 mm: Eqs. 8 and 14 of Fan et al. 2025 to second order."""
    for spacing in (1e-6, 2.3e-5):
        heights, distance = notch_heights(2e-3, 3e-4, spacing)
        path = envelope(np.pad(heights, 4000), distance, radius)
        assert path.min() == pytest.approx(-depth, rel=1e-3)


def test_a_contact_reaches_the_floor_of_a_shallow_notch() -> None:
    heights, distance = notch_heights(5e-3, 1e-4, 5e-6)
    assert envelope(np.pad(heights, 1000), distance, OUTER_RADIUS).min() == -1e-4


@given(st.lists(st.floats(-1e-4, 1e-4), min_size=3, max_size=40), st.floats(1e-3, 0.05))
def test_the_envelope_covers_the_surface_keeps_its_order_and_a_flat_one(values: list[float], radius: float) -> None:
    heights, spacing = np.array(values), 2e-5
    path = envelope(heights, spacing, radius)
    assert (path >= heights).all()
    assert path.max() == heights.max()
    assert (envelope(heights - 1e-6, spacing, radius) <= path).all()
    assert np.array_equal(envelope(np.full(9, values[0]), spacing, radius), np.full(9, values[0]))


@given(st.floats(0.1e-3, 5e-3), st.floats(0.1e-3, 0.5e-3))
def test_a_wave_is_averaged_over_the_contact(length: float, width: float) -> None:
    """A wave of the number k keeps 2 J_1(k b)/(k b) of its amplitude."""
    spacing, k = length / 64, 2.0 * math.pi / length
    x = spacing * np.arange(-4096, 4097)
    found, slope = averaged(np.cos(k * x), spacing, width)
    middle = slice(3000, 5000)
    expected = 2.0 * j1(k * width) / (k * width)
    if width < 20.0 * length:  # the ends of the samples lie outside of the contact
        assert found[middle] == pytest.approx(expected * np.cos(k * x[middle]), abs=5e-3)
        assert slope[middle] / k == pytest.approx(-expected * np.sin(k * x[middle]), abs=5e-3)


@pytest.mark.parametrize("half_width", [0.05e-3, 0.2845e-3, 0.6e-3])
@pytest.mark.parametrize("width", [0.3e-3, 1e-3, 2e-3])
def test_a_loaded_roller_feels_the_whole_sag_into_a_notch(width: float, half_width: float) -> None:
    """c^2/(2 R) at every load, by the elastic energy of a gap in a contact, and nothing beside it."""
    heights, distance = notch_heights(width, 3e-4, 2e-6)
    path = contact_path(heights, distance, OUTER_RADIUS, half_width)
    assert path.height.min() == pytest.approx(-((0.5 * width) ** 2) / (2.0 * OUTER_RADIUS), rel=2e-3)
    assert path.height.max() < 1e-9
    assert np.cumsum(path.slope) * path.spacing == pytest.approx(path.height, abs=1e-7)
    # It is felt as long as any part of the gap is within the contact.
    places = path.spacing * (np.arange(len(path.height)) - len(path.height) // 2)
    felt = np.abs(places[path.height < 0.5 * path.height.min()]).max()
    assert half_width < felt < half_width + 0.5 * width


@pytest.mark.parametrize(("width", "quarter", "whole"), [(2e-3, 0.08, -0.16), (0.5e-3, 0.44, -0.46)])
def test_the_average_of_edges_affects_their_slope_but_not_the_depth(
    width: float, quarter: float, whole: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights, distance = notch_heights(width, 3e-4, 2e-6)

    def path_with(share: float) -> tuple[float, float]:
        monkeypatch.setattr("dcrb_ros.bearing.contact_path.EDGE_AVERAGE", share)
        path = contact_path(heights, distance, OUTER_RADIUS, half_width(Configuration(), OUTER_RADIUS))
        return float(path.height.min()), float(np.abs(path.slope).max())

    depth, slope = path_with(EDGE_AVERAGE)
    for share, change in ((0.5 * EDGE_AVERAGE, quarter), (2.0 * EDGE_AVERAGE, whole)):
        other, steeper = path_with(share)
        assert other == pytest.approx(depth, rel=1e-4)
        assert steeper / slope - 1.0 == pytest.approx(change, abs=0.006)


def test_a_smaller_bearing_averages_over_the_half_width_of_the_same_pressure() -> None:
    """p = E* b/(2 R): half-widths have the ratio of the reduced radii, however long the rollers."""
    small = load_configuration("spherical_22205")
    widths, radii = [], []
    for c in (Configuration(), small):
        radii.append(c.bearing.roller_radius)
        widths.append(half_width(c, 0.5 * c.bearing.roller_radius))
    assert widths[1] / widths[0] == pytest.approx(radii[1] / radii[0] / math.sqrt(math.cos(small.bearing.contact_angle)), rel=0.01)


def test_waviness_has_its_root_mean_square_and_falls_with_the_order() -> None:
    heights, slopes = raceway_waves(3, "raceway", 0.109, 1e-6, 0.0, 1e-7, 1.5)
    level = np.abs(np.fft.rfft(heights)) / RACEWAY_NODES
    assert math.sqrt(2.0 * float((level[15:151] ** 2).sum())) == pytest.approx(1e-7, rel=0.2)
    low, high = (float(np.mean(level[band] ** 2)) for band in (slice(80, 121), slice(800, 1201)))
    assert 10.0 * math.log10(low / high) == pytest.approx(30.0, abs=1.5)
    assert level[:15].max() < 1e-15
    assert np.gradient(heights, 2.0 * math.pi / RACEWAY_NODES)[1:-1] == pytest.approx(slopes[1:-1], abs=0.06 * np.abs(slopes).max())


def test_short_waves_have_their_root_mean_square_at_the_contact_and_none_below_their_orders() -> None:
    heights, slopes = short_waves(1, "short waves of outer raceway of row 1", 0.109, (2.8e-4,), 5e-9, (150, 2000), RACEWAY_NODES)
    # 1850 amplitudes whose squares are exponential: 1 standard deviation is 2 %.
    assert heights.std() == pytest.approx(5e-9, rel=0.06)
    amplitudes = np.abs(np.fft.rfft(heights))
    assert amplitudes[:151].max() < 1e-9 * amplitudes.max()
    assert amplitudes[2001:].max() < 1e-9 * amplitudes.max()
    assert slopes == pytest.approx(np.fft.irfft(1j * np.arange(RACEWAY_NODES // 2 + 1) * np.fft.rfft(heights), RACEWAY_NODES), abs=1e-12)


def test_short_waves_leave_the_other_heights_as_they_are_and_are_half_as_high_on_rollers() -> None:
    without, rough = surfaces(waviness=1e-7), surfaces(waviness=1e-7, short_waves=2e-8)
    raceway = unpacked(rough.raceways[1, 0])[0] - unpacked(without.raceways[1, 0])[0]
    rollers = unpacked(rough.rollers[1])[0] - unpacked(without.rollers[1])[0]
    assert raceway.std() == pytest.approx(2e-8, rel=0.06)
    assert rollers.std() == pytest.approx(1e-8, rel=0.06)


def test_between_nodes_a_height_is_continuous_with_its_slope() -> None:
    table = surfaces(waviness=1e-7).raceways[1, 0]
    spacing = 2.0 * math.pi / RACEWAY_NODES
    for node in (0, 1, 7000, RACEWAY_NODES - 1):
        before, after = (read_at(table, node * spacing + side * 1e-9 * spacing) for side in (-1.0, 1.0))
        assert before == pytest.approx(after, abs=1e-12)
    angles = np.linspace(-7.0, 7.0, 301)
    rise = [(read_at(table, angle + 1e-6)[0] - read_at(table, angle - 1e-6)[0]) / 2e-6 for angle in angles]
    assert rise == pytest.approx([read_at(table, angle)[1] for angle in angles], abs=1e-6)


@given(st.lists(st.floats(-3e-4, 3e-5), min_size=4, max_size=4), st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4))
def test_packed_nodes_are_heights_and_slopes_in_single_precision(heights: list[float], slopes: list[float]) -> None:
    found = unpacked(packed(np.array(heights), np.array(slopes)))
    assert np.array_equal(found[0], np.array([*heights, heights[0]], np.float32))
    assert found[1] == pytest.approx([*slopes, slopes[0]], rel=3e-7, abs=1e-44)  # the last bit is a mark


def test_nodes_are_marked_from_the_one_before_a_defect_to_its_last_one() -> None:
    shares = np.array([0.0, 0.0, 0.3, 0.3, 0.0, 0.0])
    nodes = packed(np.zeros(6), np.full(6, 0.1), shares)
    assert [marked(int(node)) for node in nodes] == [0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]


@given(st.floats(-1e6, 1e6))
def test_an_angle_lies_between_its_nodes_after_any_number_of_turns(angle: float) -> None:
    node, way = place_of(angle, 1024)
    assert 0 <= node < 1024
    assert 0.0 <= way <= 1.0  # 1 by rounding, just below a node
    assert math.remainder((node + way) * 2.0 * math.pi / 1024 - angle, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-8)


def test_the_same_seed_makes_the_same_bearing_and_one_item_changes_no_other() -> None:
    full = {"waviness": 1e-7, "roundness": 1e-6, "roller_spread": 4e-7}
    one, again, other = surfaces(**full, seed=7), surfaces(**full, seed=7), surfaces(**full, seed=8)
    for name in ("raceways", "rollers"):
        assert np.array_equal(getattr(one, name), getattr(again, name))
        assert not np.array_equal(getattr(one, name), getattr(other, name))
    thicker = surfaces(**full | {"roller_spread": 8e-7}, seed=7)
    assert np.array_equal(thicker.raceways, one.raceways)
    difference = unpacked(thicker.rollers[0])[0] - unpacked(one.rollers[0])[0]
    assert 2.0 * difference[:, 0].std() == pytest.approx(4e-7, rel=0.4)
    assert difference == pytest.approx(np.tile(difference[:, :1], 1025), abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "width", "depth", "lowest", "highest", "share"),
    [
        ("notch", 1e-3, 3e-4, -7.19, 0.0, 0.0),
        ("spall", 2e-3, 6e-5, -28.75, 0.0, 0.3),
        ("dent", 4e-4, 1e-5, 0.0, 1.19, 4e-4 / 0.048),
        ("brinelling", 1.2e-3, 3e-5, -9.07, 0.0, 0.0),
        ("fluting", 0.02, 4e-6, -4.0, 0.0, 0.0),
        ("corrosion", 0.02, 4e-5, -7.9, 0.0, 0.1),
        ("scratch", 1e-4, 1e-5, -0.19, 0.0, 0.0),
    ],
)
def test_each_kind_of_damage_is_read_at(kind: str, width: float, depth: float, lowest: float, highest: float, share: float) -> None:
    found = surfaces(faults={"outer_1": {"kind": kind, "width": width, "depth": depth}})
    total = 1e6 * (unpacked(found.raceways[1, 0])[0][:-1] + found.parts[1, 0, :, 0])
    assert (total.min(), total.max()) == pytest.approx((lowest, highest), abs=0.1)
    assert found.parts[1, 0, :, 2].max() == pytest.approx(share, rel=1e-6)
    assert found.partial == (share > 0.0)
    assert np.array_equal(found.raceways[1, 0], found.raceways[1, 1])
    assert not found.raceways[0].any()


def test_two_defects_over_parts_of_the_length_keep_their_shares() -> None:
    spalls = {"kind": "spall", "width": 2e-3, "depth": 6e-5}
    found = surfaces(faults={"outer_1": spalls | {"share": 0.6}, "outer_2": spalls | {"azimuth": 0.3}}).parts[1, :, :, 2]
    assert set(np.unique(found)) == {0.0, np.float32(0.3), np.float32(0.6)}
    assert found[0, [0, round(0.3 / (2.0 * math.pi) * RACEWAY_NODES)]] == pytest.approx((0.6, 0.3))


def test_a_scratch_vanishes_with_its_width() -> None:
    """A burr that is no higher than a thousandth of its width is rolled down; at 0.1 mm it raises no roller by a nanometre."""
    heights = []
    for width in (1e-3, 3e-4, 1e-4, 3e-5, 1e-5):
        table = unpacked(surfaces(faults={"outer_1": {"kind": "scratch", "width": width}}).raceways[1, 0])[0]
        heights.append((float(table.max()), float(-table.min())))
    rises, depths = zip(*heights, strict=True)
    assert sorted(depths, reverse=True) == list(depths)
    assert rises[0] < 1e-6
    assert max(rises[2:]) < 1e-9
    assert depths[-1] < 2e-8


def test_brinelling_lies_under_every_roller_of_the_load_zone() -> None:
    found = surfaces(faults={"outer_1": {"kind": "brinelling", "width": 1e-3, "depth": 5e-6}}).raceways[1, 0]
    found = unpacked(found)[0][:-1]
    pitch = RACEWAY_NODES // 16
    assert [found[k * pitch] < -1e-7 for k in range(-4, 5)] == [False, *[True] * 7, False]
    assert found[pitch] == pytest.approx(found[-pitch], rel=1e-3)
    assert found[0] < found[pitch] < found[2 * pitch] < found[3 * pitch] < 0.0


def test_a_roller_defect_meets_both_raceways_with_its_own_depth() -> None:
    found = surfaces(faults={"roller_1": {"width": 2e-3, "row": 2, "roller": 3, "azimuth": 0.5}}).rollers
    damaged = unpacked(found[:, 16 + 2])[0]
    assert damaged.min(axis=1) == pytest.approx((-39.67e-6, -28.75e-6), rel=0.01)
    assert np.argmin(damaged[0]) == pytest.approx(0.5 / (2.0 * math.pi) * 1024, abs=2)
    assert not np.delete(found, 18, axis=1).any()


def test_smooth_surfaces_have_no_heights_and_refuse_damage_that_has() -> None:
    assert build_surfaces(Configuration(), []) == (Smooth(), 0.0)
    with pytest.raises(ValueError, match=r"faults\.outer_1\.kind = spall needs surfaces\.law = profile, and it is smooth"):
        Configuration.model_validate({"faults": {"outer_1": {"kind": "spall", "width": 2e-3}}})
