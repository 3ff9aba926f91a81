"""`dcrb config`: what it lists, shows, checks and documents."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from dcrb_ros.cli.app import main
from dcrb_ros.cli.vehicle_parameters import vehicle_parameters
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import fields_by_key, load_configuration, parameter_fields
from dcrb_ros.vehicle.file import PLACES, vehicle_of

BEARINGS = Path(__file__).parents[1] / "bearing" / "bearings"


class Done:
    """Exit status and output of a command."""

    def __init__(self, status: int, printed: str, complained: str) -> None:
        self.status, self.out, self.err = status, printed, complained


Command = Callable[..., Done]


@pytest.fixture
def config(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Return a function that runs `dcrb config` with some words."""

    def run(*words: str) -> Done:
        monkeypatch.setattr("sys.argv", ["dcrb", "config", *words])
        monkeypatch.setenv("COLUMNS", "110")
        with pytest.raises(SystemExit) as end:
            main()
        captured = capsys.readouterr()
        return Done(int(str(end.value.code or 0)), captured.out, captured.err)

    return run


def test_every_listed_configuration_is_described_by_one_sentence(config: Command) -> None:
    lines = config("list").out.splitlines()
    assert len(lines) >= 6
    for line in lines:
        name, description = line[:20].strip(), line[21:]
        load_configuration(name)
        assert description[0].isupper()
        assert description.endswith(".")
        assert "`" not in description
        assert len(line) <= 140


@pytest.mark.parametrize("name", ["outer_ring_defect", "cage_fracture", str(BEARINGS / "nu205.yaml")])
def test_what_is_shown_is_what_runs_with_units(config: Command, tmp_path: Path, name: str) -> None:
    shown = config("show", name, "--set", "operating.speed_kmh=72").out
    again = tmp_path / "again.yaml"
    again.write_text(shown, encoding="utf-8")
    assert load_configuration(again) == load_configuration(name, ["operating.speed_kmh=72"])
    assert list(yaml.safe_load(shown)) == ["/**"]
    lines = [line.strip() for line in shown.splitlines()]
    assert f"speed: {72 / 3.6 / 0.46!r}  # rad/s" in lines
    assert sum("  # " in line for line in lines) == sum(field.unit != "-" for field in parameter_fields(Configuration))


def test_a_check_prints_what_follows_and_warns_of_masses_of_another_bearing(config: Command) -> None:
    done = config("check", "dry", "--set", "bearing.rows=1")
    assert done.status == 0
    assert done.out.startswith("dry is valid\n")
    for words in ("1 row of 16 rollers", "560 um", "1200 rpm", "BPFO 6.7234", "about 31.3 kN on the most heavily loaded roller", "dry, "):
        assert words in done.out
    warned = [line.split(" = ")[0] for line in done.err.splitlines()]
    assert warned == ["dcrb: warning: bearing.inner_ring_mass", "dcrb: warning: bearing.outer_ring_mass"]


@pytest.mark.parametrize(
    ("settings", "keys"),
    [
        (("cage.jont=x", "bearing.rows=3", "operating.load=1e9"), ["unknown parameter 'cage.jont'", "bearing.rows", "operating.load"]),
        (
            ("bearing.pitch_radius=0.11", "simulation.step=7e-6", "friction.static_coefficient=0.01", "recording.split_size=1"),
            ["bearing.pitch_radius", "simulation.step", "recording.split_size", "friction.static_coefficient"],
        ),
        (("faults.outer_1.width=0.045", "faults.broken_bars=row1/bar17"), ["faults.outer_1.width", "faults.broken_bars"]),
        (("speed=100",), ["unknown parameter 'speed'; did you mean 'operating.speed'?"]),
    ],
)
def test_a_check_lists_everything_that_is_wrong(config: Command, settings: tuple[str, ...], keys: list[str]) -> None:
    done = config("check", "dry", *(word for setting in settings for word in ("--set", setting)))
    assert (done.status, done.out) == (2, "")
    assert len(done.err.splitlines()) == len(keys)
    for line, key in zip(done.err.splitlines(), keys, strict=True):
        assert line.startswith(f"dcrb: dry: {key}")


def test_a_check_refuses_what_a_run_refuses_at_its_start(config: Command) -> None:
    films = ("thermal.law=network", "thermal.start=cold", "lubrication.law=film", "thermal.ambient=-20.0")
    level = ("structure.housing=laboratory", "structure.healthy_level=1.0", "operating.speed=0.0")
    for name, settings, sentence in (
        ("ball_bearing_6205", films, "bearing: films of "),
        ("healthy", level, "structure.healthy_level = 1 m/s^2 is a level at operating.speed, which is 0: give the speed"),
    ):
        done = config("check", name, *(word for setting in settings for word in ("--set", setting)))
        assert (done.status, done.out) == (2, "")
        assert done.err.startswith(f"dcrb: {name}: {sentence}")
        assert len(done.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("values", "rest"), [("1.0", "1 more error;"), ("1.0e-310", "1 more error;"), ("1.0, e{}: 1.0", "22 more errors;")]
)
def test_a_check_counts_the_errors_that_it_does_not_list(config: Command, tmp_path: Path, values: str, rest: str) -> None:
    file = tmp_path / "many.yaml"
    file.write_text("{" + ", ".join(f"k{number}: {values.format(number)}" for number in range(21)) + "}")
    done = config("check", str(file))
    assert (done.status, done.out) == (2, "")
    *listed, last = done.err.splitlines()
    assert len(listed) == 20
    assert f"{rest} correct these first" in last


def test_a_refusal_elsewhere_counts_what_else_is_wrong() -> None:
    with pytest.raises(ValueError, match=r"is outside 0\.09386 .* \(and 2 more\)$"):
        load_configuration("dry", ["bearing.pitch_radius=0.11", "simulation.step=7e-6", "friction.static_coefficient=0.01"])


@pytest.mark.parametrize(
    ("group", "rows"),
    [
        ("housing", 6),
        ("faults.outer_1", 10),
        ("operating.speed", 1),
        ("time_scale", 1),
        ("fault_detector", 40),
        ("fault_detector.window", 1),
        ("vehicle_detector.contrast", 1),
        ("suspension", 4),
        ("axle_1.gear", 4),
    ],
)
def test_the_parameters_of_a_group_are_a_table(config: Command, group: str, rows: int) -> None:
    lines = [line.split("│")[1].strip() for line in config("docs", group).out.splitlines() if line.startswith("│")]
    names = [line for line in lines if line]
    assert len(names) == rows or (group == "fault_detector" and len(names) > rows)
    assert group == "fault_detector" or all(f"{group}.".endswith(f"{name}.") or name.startswith(f"{group}.") for name in names)


def test_the_defaults_of_a_wheelset_are_those_of_a_vehicle_that_names_none() -> None:
    (axle,) = vehicle_of({"vehicle.bench": "dry", "axle_1.left": {}, "axle_1.right": {}}, "test").axles
    documented = fields_by_key(vehicle_parameters())
    assert {key: documented[f"axle_1.{key}"].default for key in PLACES} == {key: getattr(axle, key) for key in PLACES}


def test_units_and_ranges_are_in_the_table(config: Command) -> None:
    printed = config("docs", "operating.speed").out
    for words in ("125.664", "-1000 .. 1000", "rad/s"):
        assert words in printed


def test_an_unknown_group_is_refused_with_the_nearest(config: Command) -> None:
    done = config("docs", "bearin")
    assert (done.status, done.out) == (2, "")
    assert "give one of bearing, housing" in done.err
    assert done.err.endswith("; did you mean 'bearing'?\n")


def test_all_errors_of_a_file_are_listed_whatever_else_is_misplaced(config: Command, tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(
        "/dcrb/simulatr:\n"
        "  ros__parameters: {operating: {speed: 1e9}, operating.speed: 3.0}\n"
        "  x: 1\n"
        "bearng: {rows: 1}\n"
        "faults.outer_1.width: -1.0\n"
    )
    wrong = config("check", str(mine), "--set", "operating.load=1e99")
    assert (wrong.status, wrong.out) == (2, "")
    expected = (
        "'/dcrb/simulatr' must contain 'ros__parameters:' and nothing else",
        "'bearng' is beside the section '/dcrb/simulatr'",
        "'faults.outer_1.width' is beside the section '/dcrb/simulatr'",
        "no node of the bench reads the section '/dcrb/simulatr'",
        "operating.speed occurs twice",
        "unknown parameter 'x'",
        "unknown parameter 'bearng.rows'; did you mean 'bearing.rows'?",
        "operating.load = 1e+99",
        "faults.outer_1.width = -1.0 m",
    )
    for sentence, line in zip(expected, wrong.err.splitlines(), strict=True):
        assert line.startswith(f"dcrb: {mine}: {sentence}")


def test_the_file_of_a_vehicle_is_no_configuration(config: Command, tmp_path: Path) -> None:
    file = tmp_path / "my_bogie.yaml"
    file.write_text("/**:\n  ros__parameters:\n    vehicle: {bench: healthy, seed: 1}\n    axle_1: {right: {wheel.flat: 0.02}}\n")
    wrong = config("check", str(file))
    lines = wrong.err.splitlines()
    assert [line.partition(" belongs to a vehicle: give its file with --vehicle")[0] for line in lines] == [
        f"dcrb: {file}: the group '{group}'" for group in ("vehicle", "axle_1")
    ]


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("rpm=900", "speeds are in rad/s: 900 rpm is operating.speed=94.2478"),  # 900 rpm * 2 pi / 60
        ("operating.rpm=900", "speeds are in rad/s: 900 rpm is operating.speed=94.2478"),
        ("speed_Hz=15.0", "speeds are in rad/s: 15 Hz is operating.speed=94.2478"),
        ("rpm=fast", "speeds are in rad/s: 1 rpm is operating.speed=0.10472"),
        ("kmh=100", "did you mean 'operating.speed_kmh'?"),
    ],
)
def test_a_speed_in_another_unit_is_converted_in_the_suggestion(config: Command, setting: str, words: str) -> None:
    wrong = config("check", "healthy", "--set", setting)
    assert wrong.err == f"dcrb: healthy: unknown parameter '{setting.partition('=')[0]}'; {words}\n"
