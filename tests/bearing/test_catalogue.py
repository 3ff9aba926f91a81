"""A configuration from catalogue data is valid at once, and its masses are those of bearings whose masses are known."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from same_process import dcrb

from dcrb_ros.bearing.catalogue import CatalogueBearing, configuration_of, described_yaml, normal_clearance
from dcrb_ros.bearing.data_sheet import kept_defaults
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import checked, load_configuration, nest
from dcrb_ros.settings.parameters import Bearing

NU_205 = CatalogueBearing(
    inner_raceway=31.5,
    outer_raceway=46.5,
    rollers=13,
    roller_diameter=7.5,
    roller_length=8.0,
    rpm=1500.0,
    bore=25.0,
    outside=52.0,
    width=15.0,
)
AXLE_BOX = CatalogueBearing(
    inner_raceway=158.0, rollers=16, roller_diameter=30.0, roller_length=48.0, rpm=1200.0, rows=2, bore=130.0, outside=250.0, width=160.0
)


def parameters_of(bearing: CatalogueBearing) -> Bearing:
    parameters, _ = configuration_of(bearing)
    return Configuration.model_validate(nest(parameters)).bearing


def test_masses_of_the_paper_s_bearing_follow_from_its_catalogue_data() -> None:
    # Fan et al. 2025, Table 1: 7.316, 13.49, 0.248 and 2.459 kg, and 2.19e-2 kg m^2.
    bearing, default = parameters_of(AXLE_BOX), Bearing()
    for name in ("inner_ring_mass", "outer_ring_mass", "roller_mass", "cage_mass", "cage_inertia", "roller_inertia"):
        assert getattr(bearing, name) == pytest.approx(getattr(default, name), rel=0.12), name


def test_a_bearing_of_an_electric_motor_has_the_mass_of_the_catalogue() -> None:
    bearing = parameters_of(NU_205)
    rings = bearing.inner_ring_mass + bearing.outer_ring_mass + bearing.rollers_per_row * bearing.roller_mass
    assert rings + 0.55 * bearing.cage_mass == pytest.approx(0.13, abs=0.015)  # catalogues print 0.13 kg
    assert 2e6 * bearing.radial_gap == pytest.approx(32.5, rel=1e-2)
    assert not list(kept_defaults(bearing))


@pytest.mark.parametrize(("bore", "middle"), [(25.0, 32.5), (50.0, 45.0), (50.1, 55.0), (130.0, 82.5), (500.0, 275.0)])
def test_clearances_are_those_of_the_standard(bore: float, middle: float) -> None:
    assert normal_clearance(bore) == middle  # ISO 5753-1


@settings(max_examples=40, deadline=None)
@given(
    diameter=st.floats(4.0, 60.0),
    ratio=st.floats(3.5, 12.0),
    slenderness=st.floats(0.8, 2.0),
    fill=st.floats(0.6, 0.85),
    rpm=st.floats(20.0, 3000.0),
    rows=st.integers(1, 2),
)
def test_the_first_round_is_valid(diameter: float, ratio: float, slenderness: float, fill: float, rpm: float, rows: int) -> None:
    pitch = ratio * diameter
    rollers = int(fill * 3.14159 * ratio)
    assume(6 <= rollers <= 60 and pitch - 2.0 * diameter < 480.0)
    bearing = CatalogueBearing(
        inner_raceway=pitch - diameter, rollers=rollers, roller_diameter=diameter, roller_length=slenderness * diameter, rpm=rpm, rows=rows
    )
    parameters, filled = configuration_of(bearing)
    assert checked(parameters, Configuration)[1] == []
    assert {entry.key for entry in filled} <= parameters.keys()
    steps = 1.0 / (51200.0 * parameters["simulation.step"])
    assert steps == pytest.approx(round(steps), abs=1e-9)


def test_the_file_is_read_back_as_it_was_meant() -> None:
    parameters, filled = configuration_of(NU_205)
    text = described_yaml(parameters, filled, "NU 205")
    assert yaml.safe_load(text)["/**"]["ros__parameters"] == nest(parameters)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"outer_raceway": 48.0}, "the outer raceway of 48 mm does not fit an inner raceway of 31.5 mm and rollers of 7.5 mm"),
        ({"bore": 33.0}, "bore 33 mm is not below inner raceway 31.5 mm"),
        ({"roller_length": -8.0}, r"roller length = -8 mm is outside 0\.5 \.\. 10000 mm"),
        ({"inner_raceway": 0.0315}, r"inner raceway = 0\.0315 mm is outside 0\.5 \.\. 10000 mm: .* in millimetres"),
        ({"roller_diameter": float("nan")}, "roller diameter = nan mm is outside"),
        ({"rollers": -7}, "1 x -7 rollers: give 1 or 2 rows"),
        ({"rows": -1}, "-1 x 13 rollers: give 1 or 2 rows"),
        ({"rpm": float("nan")}, "the speed of nan rpm is not a finite number"),
        ({"clearance": 0.0}, r"clearance = 0 um is outside 1 \.\. 1000 um: give the radial internal clearance in micrometres"),
        ({"clearance": 0.045}, r"clearance = 0\.045 um is outside"),
        ({"width": 7.9}, "width = 7.9 mm is below the 8 mm of its rollers"),
        ({"width": 15.0, "rows": 2}, "width = 15 mm is below the 16 mm of its rollers"),
    ],
)
def test_data_that_cannot_be_true_are_refused(change: dict[str, float], sentence: str) -> None:
    data = {name: getattr(NU_205, name) for name in NU_205.__dataclass_fields__}
    with pytest.raises(Refusal, match=sentence):
        CatalogueBearing(**data | change)


def test_rollers_that_do_not_fit_are_refused() -> None:
    crowded = CatalogueBearing(inner_raceway=31.5, rollers=26, roller_diameter=7.5, roller_length=8.0, rpm=1500.0)
    with pytest.raises(Refusal, match=r"26 rollers of 7\.5 mm do not fit on a pitch circle of 39 mm"):
        configuration_of(crowded)


def test_the_command_writes_a_file_that_its_check_accepts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "nj2210.yaml"
    words = f"config new -o {file} -F 59.5 -E 81.5 -Z 16 --roller-diameter 11 --roller-length 16 --rpm 1500 -d 50 -D 90 -B 23".split()
    assert dcrb(*words) == 0
    printed = capsys.readouterr().out
    assert "bearing.roller_inertia" in printed
    assert dcrb("config", "check", str(file)) == 0
    assert "warning" not in capsys.readouterr().err
    assert load_configuration(file).bearing.roller_inertia == pytest.approx(1.8e-7, rel=0.01)
    assert dcrb(*words) == 2
    assert "exists" in capsys.readouterr().err
