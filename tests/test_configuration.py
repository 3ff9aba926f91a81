"""Configurations: read, checked, explained when refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.configuration import Configuration
from dcrb_ros.configuration_file import (
    ParameterField,
    flatten,
    load_configuration,
    parameter_fields,
    parameter_table,
    shipped_configurations,
    to_yaml,
    validated,
)
from dcrb_ros.refusal import Refusal

FIELDS = {field.key: field for field in parameter_fields()}


def test_healthy_is_the_default() -> None:
    assert load_configuration("healthy") == Configuration()


def test_shipped_configurations_are_valid() -> None:
    assert {"paper", "healthy", "outer_ring_defect", "inner_ring_defect"} <= set(shipped_configurations())
    for name in shipped_configurations():
        load_configuration(name)


@given(st.floats(60.0, 190.0), st.floats(0.0, 0.003), st.integers(0, 2**31 - 1), st.sampled_from(["warm", "cold"]))
def test_yaml_round_trip(tmp_path_factory: pytest.TempPathFactory, speed: float, width: float, seed: int, start: str) -> None:
    groups = {"operating": {"speed": speed, "start": start}, "faults": {"inner_1": {"width": width}}, "simulation": {"seed": seed}}
    configuration = Configuration.model_validate(groups)
    path = tmp_path_factory.mktemp("yaml") / "bench.yaml"
    path.write_text(to_yaml(configuration), encoding="utf-8")
    assert load_configuration(path) == configuration
    assert validated(flatten(configuration.model_dump()), Configuration, "round trip") == configuration


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        (
            "bearing.roller_radius=15.0",
            r"bearing.roller_radius = 15\.0 m is outside 0\.0005 \.\. 0\.2 m: .* millimetres \(did you mean 0\.015\?\)",
        ),
        ("faults.outer_1.width=2.0", r"did you mean 0\.002\?"),
        ("bearing.roler_radius=0.015", r"unknown parameter 'bearing.roler_radius'; did you mean 'bearing.roller_radius'\?"),
        ("operating.speed=.nan", r"operating.speed = nan rad/s is outside -1000 \.\. 1000 rad/s"),
        ("operating.speed=1200", r"1200 rpm is 125\.664 rad/s"),
        ("operating.load=fast", r"operating.load = 'fast' N is not a number within"),
        ("cage.joint=welded", r"cage.joint = 'welded' is not one of revolute"),
        ("simulation.step=7e-6", r"must make a whole number from 2 up: take 9\.765625e-06"),
        ("sensor.sampling_rate=44100", r"simulation.step"),
        ("faults.outer_1.width=0.045", r"is not below the pitch of 0\.04286 m"),
        ("bearing.outer_raceway_radius=0.1", r"radial gap .* is -0\.00886 m"),
        ("friction.static_coefficient=0.01", r"is below friction.kinetic_coefficient"),
        ("bearing.rollers_per_row=20", r"19 rollers at most"),
        ("bearing.roller_inertia=1.0", r"a solid roller has mass \* radius\^2 / 2"),
        ("bearing", r"write KEY=VALUE"),
    ],
)
def test_refusals_name_value_range_and_remedy(setting: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_configuration("healthy", [setting])


def test_overlapping_defects_are_refused() -> None:
    settings = ["faults.outer_1.width=0.002", "faults.outer_2.width=0.002", "faults.outer_2.azimuth=0.01"]
    with pytest.raises(Refusal, match=r"faults.outer_2 overlaps faults.outer_1: .* 0\.001091 m apart"):
        load_configuration("healthy", settings)
    load_configuration("healthy", [*settings[:2], "faults.outer_2.azimuth=0.1"])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "is not a ROS parameter file"),
        ("just words", "is not a ROS parameter file"),
        ("/**: {ros__parameters: {operating: {speed: 1772}}}", r"write 1772\.0"),
        ("/**:\n  ros__parameters:\n    a: 1\n    a: 2\n", "the key 'a' stands twice"),
        ("/**: [1, 2", "is not valid YAML"),
        ("/**: {operating: {speed: 1.0}}", "must hold 'ros__parameters:'"),
    ],
)
def test_broken_files_are_refused(tmp_path: Path, text: str, sentence: str) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(Refusal, match=sentence):
        load_configuration(path)


@given(st.binary(max_size=400))
def test_any_file_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.mktemp("fuzz") / "bench.yaml"
    path.write_bytes(content)
    with pytest.raises(Refusal):
        load_configuration(path)


def test_sections_of_the_node_win_and_other_nodes_are_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(
        "/**: {ros__parameters: {operating: {speed: 100.0}}}\n"
        "simulator: {ros__parameters: {operating.speed: 90.0}}\nother: {ros__parameters: {x: 1}}\n",
        encoding="utf-8",
    )
    assert load_configuration(path).operating.speed == 90.0


def test_misspelt_name_suggests_the_nearest() -> None:
    with pytest.raises(Refusal, match="did you mean 'healthy'"):
        load_configuration("heathy")


@pytest.mark.parametrize("field", FIELDS.values(), ids=list(FIELDS))
def test_every_parameter_explains_itself(field: ParameterField) -> None:
    assert field.description
    assert field.key in parameter_table()
    if field.kind in (int, float):
        assert field.low is not None
        assert field.high is not None
        assert field.low <= field.default <= field.high  # type: ignore[operator]


@pytest.mark.parametrize(("text", "value"), [("", ""), ("row1/bar2", "row1/bar2"), ("'row1/bar2'", "row1/bar2")])
def test_a_text_is_set_plain_quoted_or_empty(text: str, value: str) -> None:
    assert load_configuration("cage_fracture", [f"faults.broken_bars={text}"]).faults.broken_bars == value


def test_a_text_of_digits_stays_a_text() -> None:
    assert load_configuration("healthy", ["recording.path=2026"]).recording.path == "2026"
