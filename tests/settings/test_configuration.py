"""Configurations: reading, checking, and the sentences with which they are refused."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.documentation import parameter_table
from dcrb_ros.settings.files import fields_by_key, flatten, load_configuration, to_yaml, validated
from dcrb_ros.settings.shipped import shipped
from dcrb_ros.settings.simulation import SHORTEST_STEP, SimulationParameters
from dcrb_ros.settings.step_limits import whole_steps

FIELDS = fields_by_key()


def test_the_dry_bench_has_the_defaults() -> None:
    assert load_configuration("dry") == Configuration()


LUBRICATED = ("healthy", "outer_ring_defect", "inner_ring_defect", "roller_defect", "cage_fracture", "compound")
ANGLED = ("tapered_352213", "spherical_22205", "za2115")


def test_shipped_configurations_are_valid() -> None:
    assert set(shipped("configuration")) == {"paper", "dry", "ball_bearing_6205", *ANGLED, *LUBRICATED}
    for name in shipped("configuration"):
        load_configuration(name)


@pytest.mark.parametrize("name", LUBRICATED)
def test_the_lubricated_benches_differ_in_their_faults_alone(name: str) -> None:
    healthy, bench = load_configuration("healthy"), load_configuration(name)
    assert bench.model_copy(update={"faults": healthy.faults}) == healthy
    assert bool(bench.described_faults()) == (name != "healthy")


def test_the_lubricated_benches_have_the_clearance_oil_surfaces_and_masses_of_an_axle_box() -> None:
    healthy = load_configuration("healthy")
    assert 0.10e-3 <= 2.0 * healthy.bearing.radial_gap <= 0.19e-3  # ISO 5753, C3 and C4 for bores of 120 to 140 mm
    assert (healthy.lubrication.law, healthy.lubrication.lubricant, healthy.surfaces.law) == ("film_with_cages", "grease", "profile")
    assert (healthy.housing.box_mass, healthy.housing.axle_mass, healthy.operating.start) == (60.0, 600.0, "settled")


def test_the_bench_of_the_paper_keeps_its_table() -> None:
    printed = {"bearing.roller_inertia": 6.15e-5, "contact.loss_time": 0.0, "cage.joint": "revolute", "operating.speed": 124.8}
    assert load_configuration("paper") == load_configuration(Configuration(), printed)


@given(st.floats(60.0, 190.0), st.floats(0.0, 0.003, allow_subnormal=False), st.integers(0, 2**31 - 1), st.sampled_from(["warm", "cold"]))
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
        ("operating.speed=5.0e-324", r"operating.speed = 5e-324 is too close to zero: give 0\.0, or a magnitude of at least 2\.22507e-308"),
        ("operating.speed=.nan", r"operating.speed = nan rad/s is not a finite number"),
        ("operating.speed=1200", r"1200 rpm is 125\.664 rad/s"),
        ("operating.load=fast", r"operating.load = 'fast' N is not a number within"),
        ("cage.joint=welded", r"cage.joint = 'welded' is not one of revolute"),
        ("simulation.step=7e-6", r"must be a whole number, at least 2: take 9\.765625e-06"),
        ("sensor.sampling_rate=44100", r"simulation.step"),
        ("bearing.outer_raceway_radius=0.1", r"radial gap .* is -0\.00886 m"),
        ("friction.static_coefficient=0.01", r"is below friction.kinetic_coefficient"),
        ("sensor.sampling_rate=25600.0", r"sensor.sampling_rate = 25600\.0 Hz is written with a decimal point: write 25600"),
        ("bearing.rows=1.5", r"bearing.rows = 1\.5 is not a whole number within 1 \.\. 2"),
        ("publishing.clean=1", r"publishing.clean = 1 is not true or false \(also publish"),
        ("bearing.roller_inertia=1.0", r"a solid roller has mass \* radius\^2 / 2"),
        ("time_scale=-1", r"time_scale = -1\.0 is outside 0 \.\. 1000: give 0 for as fast as possible, 1 for real time$"),
        (
            "publishing.state_rate=0",
            r"is outside 1 \.\. 10000 Hz \(rate of roller_states in simulated time, use 100 to 1000 for a live topic\)$",
        ),
        ("bearing", r"write KEY=VALUE"),
        ("speed=100", r"unknown parameter 'speed'; did you mean 'operating.speed'\?"),
        ("outer_1.width=0.002", r"unknown parameter 'outer_1.width'; did you mean 'faults.outer_1.width'\?"),
        ("operating.outer_1.width=0.002", r"did you mean 'faults.outer_1.width'\?"),
        ("bearing.joint=pocket", r"did you mean 'cage.joint'\?"),
        ("sped=100", r"unknown parameter 'sped'; did you mean 'operating.speed'\?"),
        ("width=0.002", r"did you mean 'faults.outer_1.width', 'faults.outer_2.width' or 'faults.inner_1.width'\?"),
        ("faults.outer_1={}", r"faults.outer_1 is a group of parameters: give them below it, such as faults.outer_1\.\w+, or leave it out"),
        ("faults.outer_3={}", r"unknown parameter 'faults.outer_3'; did you mean"),
        ("operating=100", r"operating is a group of parameters: give them below it, such as operating.speed, or leave it out"),
        ("lubrication.temperature=300.0", r"lubrication.temperature = 300.* is outside -40.* \.\. 250"),
        ("lubrication.density=0.89", r"lubrication.density = 0\.89 kg/m\^3 is outside 700 \.\. 1200"),
        ("lubrication.viscosity_40=0.0001", r"lubrication.viscosity_40 = 0\.0001 mm\^2/s is outside 2 \.\. 2000"),
        ("lubrication.layer=5.0", r"lubrication.layer = 5\.0 m is outside 0 \.\. 0\.001 m: .* millimetres"),
    ],
)
def test_refusals_name_value_range_and_remedy(setting: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_configuration("dry", [setting])


NOTCH = ("faults.outer_1.width=0.002",)
NOTCHES = (*NOTCH, "faults.outer_2.width=0.002", "faults.outer_2.azimuth=0.01")
ROLLER_NOTCHES = ("faults.roller_1.width=0.002", "faults.roller_2.width=0.002", "faults.roller_2.azimuth=0.05")


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (
            ("publishing.block_size=65536", "sensor.sampling_rate=12800"),
            r"publishing.block_size = 65536 lasts 5.12 s at .* give 54912 or fewer",
        ),
        (
            ("sensor.sampling_rate=8192", f"simulation.step={1 / (13 * 8192)}"),
            r"publishing.preview_rate = \d+ Hz does not divide sensor.sampling_rate = 8192 Hz; take a divisor, such as 256",
        ),
        (
            ("sensor.sampling_rate=12007", f"simulation.step={1 / (9 * 12007)}"),
            r"sensor.sampling_rate = 12007 Hz has no divisor from 10 to 1000 Hz, .*: take a multiple of 100 Hz, and resample",
        ),
        (NOTCHES, r"faults.outer_2 overlaps faults.outer_1: .* 0\.001091 m apart; move an azimuth or join them"),
        ((*NOTCHES[:2], "faults.outer_1.azimuth=3.14", "faults.outer_2.azimuth=-3.14"), r"0\.0003476 m apart"),
        ((*NOTCHES, "faults.outer_2.row=2"), r"faults.outer_2 overlaps faults.outer_1"),
        (ROLLER_NOTCHES, r"faults.roller_2 overlaps faults.roller_1"),
        (("faults.outer_1.width=0.045",), r"faults.outer_1.width = 0\.045 m is not below the pitch of 0\.04286 m"),
        (("faults.inner_2.width=0.032",), r"faults.inner_2.width = 0\.032 m is not below the pitch of 0\.03097 m"),
        (("faults.roller_1.width=0.015",), r"faults.roller_1.width = 0\.015 m is not below the roller's radius of 0\.015 m"),
        (("faults.broken_bars=row1/bar17",), r"row1/bar17 is outside row1/bar1 \.\. row2/bar16: bar k is between"),
        (("faults.broken_bars=row1/bar0",), r"row1/bar0 is outside row1/bar1"),
        (("faults.broken_bars=row3/bar1",), r"row3/bar1 is outside .* row2/bar16"),
        (("faults.broken_bars=row2/bar3, row2/bar03",), r"'row2/bar3, row2/bar03' names a bar twice: name each once"),
        (("faults.broken_bars=row1-bar15",), r"'row1-bar15' is not a bar; write row1/bar15"),
        (("faults.broken_bars=row1/bar15; row2/bar15",), r"'row1/bar15;' is not a bar"),
        (("faults.broken_bars=" + " ".join(f"row1/bar{k}" for k in range(1, 16)),), r"fewer than two bars in row 1"),
        (("cage.pocket_clearance=-0.0001",), r"cage.pocket_clearance = -0\.0001 m is outside 5e-06 \.\. 0\.005 m"),
        (("cage.land_clearance=-0.0003",), r"cage.land_clearance = -0\.0003 m is outside"),
        (("cage.pocket_clearance=0.004",), r"leaves no bar in the 0\.00668 m between two rollers: it must be below 0\.00334 m"),
        (
            ("cage.land_clearance=2e-05", "cage.pocket_clearance=0.0001"),
            r"land_clearance \+ cage.pocket_clearance = 0\.00012 m is below 0\.00016 m, the offset of the cage",
        ),
        (
            ("cage.joint=revolute", "cage.land_clearance=0.0001"),
            r"cage.land_clearance = 0\.0001 m is below .* the cage would carry the load",
        ),
        (
            ("operating.load=5e6",),
            r"operating.load = 5e\+06 N with the weight presses .* the cage leaves 0\.00026 m: at most about 1\.7\de\+06 N",
        ),
        (("cage.land_radius=0.05",), r"cage.land_radius = 0\.05 m is outside 0\.094 \.\. 0\.12414 m"),
        (("bearing.outer_raceway_radius=0.1088",), r"the radial gap .* is -6e-05 m, outside 0 \.\. 0\.0015 m: check the three radii"),
        (("bearing.inner_raceway_radius=0.12",), r"the radial gap .* check the three radii"),
        (("bearing.pitch_radius=0.11",), r"bearing.pitch_radius = 0\.11 m is outside 0\.09386 \.\. 0\.09414 m"),
        (("bearing.rollers_per_row=20",), r"bearing.rollers_per_row = 20 do not fit around the pitch circle: use at most 19"),
        (("faults.roller_1.width=0.002", "faults.roller_1.roller=17"), r"no roller 17 in row 1; the bearing has 2 row\(s\) of 16 rollers"),
        (("bearing.rows=1", *NOTCH, "faults.outer_1.row=2"), r"faults.outer_1.row = 2 is outside 0 \.\. 1: the bearing has 1 row"),
        (("bearing.rows=1", "faults.roller_1.width=0.002", "faults.roller_1.row=2"), r"no roller 1 in row 2; the bearing has 1 row"),
        (("bearing.rows=1", "faults.broken_bars=row2/bar1"), r"row2/bar1 is outside row1/bar1 \.\. row1/bar16"),
    ],
)
def test_contradicting_parameters_are_refused(settings: tuple[str, ...], sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_configuration("dry", settings)


@pytest.mark.parametrize(
    "settings",
    [
        (*NOTCHES[:2], "faults.outer_2.azimuth=0.1"),
        (*NOTCHES, "faults.outer_1.row=1", "faults.outer_2.row=2"),
        (*ROLLER_NOTCHES, "faults.roller_2.roller=2"),
        (*ROLLER_NOTCHES, "faults.roller_2.row=2"),
        ("faults.broken_bars=row1/bar1,row2/bar16 row2/bar1",),
        ("bearing.rows=1", *NOTCH, "faults.outer_1.row=1"),
    ],
)
def test_parameters_that_just_fit_together_are_accepted(settings: tuple[str, ...]) -> None:
    load_configuration("dry", settings)


LIGHT_ROLLERS = ("bearing.roller_mass=0.02", "bearing.roller_inertia=2.25e-6")
LIGHT_CAGE = ("bearing.cage_mass=0.01", "bearing.cage_inertia=1e-4")


def proposed_step(refused: pytest.ExceptionInfo[Refusal]) -> str:
    """Return the step that a refusal proposes."""
    found = re.search(r"(?:such as|take) ([\d.e-]+)", str(refused.value))
    assert found
    return found[1]


@pytest.mark.parametrize(
    ("settings", "mode"),
    [
        (LIGHT_ROLLERS, "a roller between the raceways, a mode at"),
        ((*LIGHT_ROLLERS, "sensor.sampling_rate=25600", "simulation.step=1.953125e-05"), "a roller between the raceways"),
        (("sensor.sampling_rate=25600", "simulation.step=1.953125e-05"), "rollers against the bars of a cage"),
        (("cage.joint=revolute", "bearing.inner_ring_mass=0.1"), "the rings against each other"),
        (("cage.joint=revolute", *LIGHT_CAGE, "bearing.roller_mass=0.002", "bearing.roller_inertia=2.25e-7"), "a cage with its rollers"),
        (LIGHT_CAGE, "rollers against the bars of a cage"),
        (("cage.pocket_clearance=1e-05", "bearing.cage_mass=1.0"), "rollers against the bars of a cage"),
        ((*LIGHT_ROLLERS, "faults.broken_bars=row1/bar1", "cage.joint=revolute"), "two rollers beside a broken bar"),
        (("housing.stiffness=1e12",), "the outer ring in the housing"),
        (("contact.law=power", "contact.power_coefficient=1e12"), "a roller between the raceways"),
    ],
)
def test_a_step_that_is_too_long_is_refused_with_the_mode_and_a_shorter_step(settings: tuple[str, ...], mode: str) -> None:
    with pytest.raises(Refusal, match=mode) as refused:
        load_configuration("dry", settings)
    load_configuration("dry", [*settings, f"simulation.step={proposed_step(refused)}"])


@pytest.mark.parametrize("rate", [44100, 48000, 51200])
def test_a_step_that_does_not_divide_the_sampling_interval_is_refused_with_one_that_does(rate: int) -> None:
    settings = (f"sensor.sampling_rate={rate}", "publishing.preview_rate=100", "simulation.step=1.1e-05")
    with pytest.raises(Refusal, match="must be a whole number, at least 2") as refused:
        load_configuration("dry", settings)
    load_configuration("dry", [*settings, f"simulation.step={proposed_step(refused)}"])


@pytest.mark.parametrize(("rate", "step"), [(20000, 1.9e-5), (51200, SHORTEST_STEP), (204800, 2e-5), (1000, 1.95e-5)])
def test_every_step_that_is_proposed_for_a_sampling_rate_is_within_the_range_of_the_step(rate: int, step: float) -> None:
    (words,) = whole_steps(step, rate)
    steps = re.findall(r"\d[\d.]*e-\d+", words.partition("take ")[2])
    assert steps
    for proposed in steps:
        SimulationParameters(step=float(proposed))
        assert not list(whole_steps(float(proposed), rate))


def test_modes_too_fast_for_any_step_are_refused_with_what_to_check() -> None:
    with pytest.raises(Refusal, match=r"even a step of 1e-07 s is too long; check masses in kg"):
        load_configuration(
            "dry", ["bearing.cage_mass=0.0001", "bearing.cage_inertia=9e-7", "contact.law=power", "contact.power_coefficient=1e15"]
        )


DOUBLINGS = "a: &x0 {x: 1}\n" + "".join(f"a{k}: &x{k} {{x: *x{k - 1}, y: *x{k - 1}}}\n" for k in range(1, 26))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "is not a file of parameters"),
        ("just words", "is not a file of parameters"),
        ("/**: {ros__parameters: {operating: {speed: 1772}}}", r"outside -1000 \.\. 1000 rad/s"),
        ("/**:\n  ros__parameters:\n    a: 1\n    a: 2\n", "in line 4: the key 'a' occurs twice"),
        ("/**: [1, 2", "is not valid YAML"),
        ("/**:\n  speed: 2026-13-45", r"not valid YAML in line 2: '2026-13-45' cannot be read as timestamp; put a text in quotes"),
        ("/**: {? [1, 2] : 3}", "in line 1: a key is a list or a mapping"),
        ("/**: " + 5000 * "9", "'9{40}' cannot be read as int"),
        ("/**: 0x" + 5000 * "f", "'0xf{38}...' is too large a number"),
        ("/**: !!int ''", "'' cannot be read as int"),
        ('/**: "\\UFFFFFFFF"', "is not valid YAML( in line 1)?: .*character"),
        (1000 * "[", "nested too deeply"),
        (DOUBLINGS, "its aliases expand to more than 200000 values"),
        ("/**: {ros__parameters: {faults: {broken_bars: 15}}}", r"faults.broken_bars = 15 is not a text \(broken cage bars"),
        ("/**: {operating: {speed: 1.0}}", "must contain 'ros__parameters:'"),
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


def test_the_section_of_the_node_overrides_the_common_one(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(
        "/**: {ros__parameters: {operating: {speed: 100.0}}}\n"
        "simulator: {ros__parameters: {operating.speed: 90.0}}\nreplayer: {ros__parameters: {rate: 1.0}}\n",
        encoding="utf-8",
    )
    assert load_configuration(path).operating.speed == 90.0


@pytest.mark.parametrize("value", ["2026-13-45", 400 * "9", 5000 * "9", 1000 * "[", '"\\UFFFFFFFF"'])
def test_broken_settings_are_refused(value: str) -> None:
    with pytest.raises(Refusal, match="the value is not a plain number or text"):
        load_configuration("dry", [f"operating.speed={value}"])


def test_aliases_are_expanded(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text("/**: {ros__parameters: {faults: {outer_1: &notch {width: 0.002}, inner_1: *notch}}}", encoding="utf-8")
    assert load_configuration(path).faults.inner_1.width == 0.002


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
    assert load_configuration("dry", ["recording.path=2026"]).recording.path == "2026"


FILM = ("lubrication.law=film",)
CUSTOM_OIL = (*FILM, "lubrication.lubricant=custom")


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ((*CUSTOM_OIL, "lubrication.viscosity_100=100.0"), r"viscosity_100 = 100 mm\^2/s is not below .*viscosity_40 = 100 mm\^2/s"),
        ((*CUSTOM_OIL, "lubrication.viscosity_40=5.0"), r"viscosity_100 = 11 mm\^2/s is not below .* 5 mm\^2/s: .*exchange the values"),
        ((*FILM, "lubrication.viscosity_40=220.0"), r"viscosity_40 = 220 describes a custom lubricant, but .*lubricant = 'grease'"),
        ((*FILM, "lubrication.density=900.0"), r"lubrication.density = 900 describes a custom lubricant"),
        (
            (*FILM, "lubrication.temperature=-40.0"),
            r"temperature = -40 deg C .* a viscosity of 545 Pa s, outside 0.001 \.\. 100 Pa s: raise",
        ),
        (
            ("lubrication.law=film_with_cages", "lubrication.temperature=-25.0"),
            r"temperature = -25 deg C .* a viscosity of 37.6 Pa s, outside 0.001 \.\. 30 Pa s: raise",
        ),
        (
            (*CUSTOM_OIL, "lubrication.viscosity_40=10.0", "lubrication.viscosity_100=2.5", "lubrication.temperature=250.0"),
            r"temperature = 250 deg C .* a viscosity of at most 0\.001 Pa s, .* lower the temperature",
        ),
        (
            (*CUSTOM_OIL, "lubrication.viscosity_40=2000.0", "lubrication.viscosity_100=1.0", "lubrication.temperature=-40.0"),
            r"raise the temp",
        ),
        (
            (*CUSTOM_OIL, "lubrication.pressure_coefficient=5e-9"),
            r"pressure_coefficient = 5e-09 1/Pa .* exponent 0\.1.*, outside 0\.2 \.\. 1\.1",
        ),
        ((*FILM, "contact.notch=edge"), r"contact.notch = 'edge' has no oil film: take sink"),
        (
            (
                *FILM,
                "lubrication.lubricant=vg220",
                "lubrication.temperature=-20.0",
                "bearing.outer_raceway_radius=0.10902",
                "bearing.inner_raceway_radius=0.07899",
            ),
            r"films of 1\.\d+e-05 m, 1\.\d+e-05 m at .* -20 deg C fill the radial gap of 3e-05 m: raise the temperature",
        ),
    ],
)
def test_oils_that_the_film_does_not_describe_are_refused(settings: tuple[str, ...], sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_configuration("dry", settings)
    if settings[0] == FILM[0]:
        load_configuration("dry", ("lubrication.law=dry", *settings[1:]))


@given(st.sampled_from(["grease", "vg100", "vg220"]), st.floats(-20.0, 200.0), st.floats(1e-9, 1e-4), st.floats(-300.0, 300.0))
def test_shipped_oils_are_accepted_where_they_flow(lubricant: str, temperature: float, layer: float, speed: float) -> None:
    oil = {"law": "film", "lubricant": lubricant, "temperature": temperature, "layer": layer}
    Configuration.model_validate({"lubrication": oil, "operating": {"speed": speed}})


def test_box_and_axle_slow_the_rings() -> None:
    light = ("bearing.outer_ring_mass=0.2", "bearing.inner_ring_mass=0.2")
    with pytest.raises(Refusal, match="is too long for the rings against each other"):
        load_configuration("dry", light)
    load_configuration("dry", (*light, "housing.box_mass=60.0", "housing.axle_mass=600.0"))


def test_the_friction_of_asperities_presses_rollers_against_the_bars() -> None:
    light = ("bearing.cage_mass=0.8",)
    load_configuration("dry", light)
    with pytest.raises(Refusal, match="is too long for rollers against the bars of a cage"):
        load_configuration("dry", (*light, *FILM, "lubrication.boundary_friction=1.0"))


def test_a_folder_does_not_hide_the_shipped_configuration_of_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "healthy").mkdir()  # the default name of a recording of this configuration
    assert load_configuration("healthy") == load_configuration("healthy.yaml") == load_configuration("config/healthy.yaml")
