"""What follows from a configuration, and the masses that belong to another bearing."""

from __future__ import annotations

from pathlib import Path

import pytest

from dcrb_ros.bearing.data_sheet import data_sheet, kept_defaults
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration

NU205 = Path(__file__).parent / "bearings" / "nu205.yaml"


def test_the_data_sheet_has_the_numbers_of_the_catalogue() -> None:
    sheet = data_sheet(load_configuration(NU205))
    assert sheet["bearing"] == "1 row of 13 rollers, 7.5 mm in diameter and 8 mm long, on a pitch circle of 39.02 mm"
    assert sheet["internal clearance"].startswith("32 um,")  # the file: 32 um, the middle of the normal group
    assert sheet["speed"] == "1500 rpm, shaft frequency 25 Hz"
    # 5 (3000 N + 0.034 kg 9.81 m/s^2)/13 = 1154 N.
    assert sheet["load"] == "3 kN; about 1.15 kN on the most heavily loaded roller (Stribeck: 5 F/z)"
    assert sheet["orders"] == "FTF 0.4039, BPFO 5.2505, BPFI 7.7495, BSF 2.5050"  # docs/how-to/simulate-your-own-bearing.md
    assert sheet["frequencies"] == "FTF 10.10, BPFO 131.26, BPFI 193.74, BSF 62.62 Hz"
    assert sheet["time step"] == "3.255 us, 6 for a sample at 51.2 kHz"


def test_the_data_sheet_names_the_faults() -> None:
    assert data_sheet(load_configuration("compound"))["faults"].startswith("outer_1: 2 mm wide, inner_1: 2 mm wide, bar 15 broken")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ((), ["film of grease at 60 deg C", "profiles of individual 1", "axle box of 60 kg, axle of 600 kg"]),
        (("lubrication.lubricant=vg100", "lubrication.temperature=40.0"), ["film of vg100 at 40 deg C"]),
        (("surfaces.law=smooth", "housing.box_mass=0.0", "housing.axle_mass=0.0"), ["smooth surfaces, no axle box, no axle"]),
    ],
)
def test_the_data_sheet_names_oil_surfaces_and_masses(settings: tuple[str, ...], words: list[str]) -> None:
    found = data_sheet(load_configuration("healthy", settings))["lubrication"]
    assert [part for part in words if part not in found] == []
    assert "paper" not in found
    assert "healthy.yaml" not in found


def test_a_file_with_a_speed_alone_is_told_that_it_runs_dry(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text("operating: {speed: 100.0}")
    found = data_sheet(load_configuration(path))["lubrication"]
    assert found.startswith("dry, smooth surfaces, no axle box, no axle, the paper's clearance, beyond C5 of ISO 5753")
    assert "config/healthy.yaml" in found


@pytest.mark.parametrize(
    ("settings", "keys"),
    [
        ((), []),
        (("bearing.outer_raceway_radius=0.1092",), []),  # a clearance changes no mass
        (("bearing.rows=1",), ["inner_ring_mass", "outer_ring_mass"]),
        (("bearing.rows=1", "bearing.inner_ring_mass=3.5"), ["outer_ring_mass"]),
        (("bearing.rollers_per_row=15",), ["cage_mass", "cage_inertia"]),
        (
            ("bearing.roller_length=0.03",),
            ["roller_mass", "roller_inertia", "cage_mass", "cage_inertia", "inner_ring_mass", "outer_ring_mass"],
        ),
    ],
)
def test_masses_of_the_default_bearing_are_noticed_in_another_one(settings: tuple[str, ...], keys: list[str]) -> None:
    found = list(kept_defaults(load_configuration("dry", settings).bearing))
    assert [sentence.partition(" = ")[0] for sentence in found] == [f"bearing.{key}" for key in keys]


def test_a_solid_roller_is_proposed() -> None:
    found = list(kept_defaults(load_configuration("dry", ["bearing.roller_length=0.03"]).bearing))
    assert "this one has roller_length = 0.03, not 0.048: a roller of solid steel has 0.166 kg" in found[0]  # 7850 pi 0.015^2 0.03


def test_the_bearings_of_the_tests_have_masses_of_their_own() -> None:
    assert [*kept_defaults(load_configuration(NU205).bearing), *kept_defaults(Configuration().bearing)] == []
