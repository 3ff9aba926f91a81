"""The measures of the validation on signals with known properties, and its comparisons with correct and wrong runs."""

from __future__ import annotations

import functools
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.dry_bench import dry_bench_rows
from dcrb_ros.validation.faults import power_of_sink
from dcrb_ros.validation.healthy import healthy_rows
from dcrb_ros.validation.measures import envelope_spectrum, load_zone, passes, profile, settling_time
from dcrb_ros.validation.oiled_runs import oiled_specs
from dcrb_ros.validation.report import markdown, summary
from dcrb_ros.validation.report_row import ReportRow
from dcrb_ros.validation.runs import PaperRun, paper_spec, run_specs, simulate
from dcrb_ros.validation.validate import REPORT, report_folder


def test_envelope_line_of_a_modulated_tone() -> None:
    time = np.arange(3 * 51200) / 51200
    tone = (1.0 + 0.4 * np.cos(2.0 * np.pi * 133.0 * time)) * np.cos(2.0 * np.pi * 5000.0 * time)
    line = envelope_spectrum(tone, 51200).line(130.0, 10.0)
    assert line.frequency == pytest.approx(133.0, abs=1e-6)
    assert line.amplitude == pytest.approx(0.4, rel=1e-2)
    assert line.level > 60.0


def test_settling_of_a_first_order_lag() -> None:
    time = np.arange(0.0, 1.0, 1e-3)
    assert settling_time(time, -300.0 * (1.0 - np.exp(-time / 0.025)), 0.02) == pytest.approx(0.025 * np.log(50.0), abs=2e-3)


def test_load_zone_of_a_known_force() -> None:
    # Two rollers pass many times, loaded from -20 to 30 deg.
    azimuth = np.angle(np.exp(1j * (np.linspace(0.0, 100.0, 20001)[:, None] + np.array([0.0, 2.0]))))
    force = np.where((np.degrees(azimuth) > -20.0) & (np.degrees(azimuth) < 30.0), 1000.0, 0.0)
    zone = load_zone(azimuth, force)
    assert (zone.entry, zone.exit) == pytest.approx((-20.0, 30.0), abs=0.3)
    assert zone.asymmetry == pytest.approx(10.0, abs=0.5)
    assert len(list(passes(np.abs(azimuth[:, 0]) < 0.5 * np.pi))) == 15


def test_profile_is_the_mean_in_each_bin() -> None:
    found = profile(np.array([0.1, 0.2, 1.5, 9.0]), np.array([1.0, 3.0, 5.0, 7.0]), np.array([0.0, 1.0, 2.0, 3.0]))
    assert found[:2] == pytest.approx([2.0, 5.0])
    assert np.isnan(found[2])


def test_run_specs_are_distinct_and_valid() -> None:
    specs = run_specs()
    assert len({spec.key for spec in specs}) == len(specs)
    for spec in specs:
        assert spec.configuration().cage.joint == spec.joint


def test_the_commands_of_the_report_record_its_runs() -> None:
    folders = []
    for spec in (*run_specs(), *oiled_specs()):
        program, command, bench, *options = shlex.split(spec.command)
        assert (program, command) == ("dcrb", "simulate")
        given = list(zip(options[::2], options[1::2], strict=True))
        settings = [value for option, value in given if option == "--set"]
        keys = [setting.partition("=")[0] for setting in settings]
        assert len(set(keys)) == len(keys)  # `dcrb simulate` refuses a key that is given twice
        assert load_configuration(bench, settings) == spec.configuration()
        folders += [value for option, value in given if option == "-o"]
    assert len(set(folders)) == len(run_specs()) + len(oiled_specs())


@functools.cache
def short(name: str, *settings: str) -> PaperRun:
    return simulate(paper_spec(name, "revolute", 0.35, settings))


def verdicts(healthy: PaperRun, cold: PaperRun) -> dict[str, bool]:
    """Return whether each comparison with the revolute joint holds; the runs are used for both joints.

    The energy account is left out: over a third of a second, the energy input is smaller than the oscillation of the stored energy.
    """
    runs = {(run.spec.name, joint): run for run in (healthy, cold) for joint in ("revolute", "pocket")}
    comparisons = (c for c in healthy_rows(runs) if c.joint == "revolute")
    return {c.quantity: c.holds for c in comparisons if "Energy" not in c.quantity}


def test_comparisons_hold_for_the_paper_and_fall_short_for_a_wrong_bearing() -> None:
    healthy, cold = short("healthy"), short("cold start", "operating.start=cold")
    held = verdicts(healthy, cold)
    assert all(held.values()), held
    wrong = short("healthy", "operating.load=60000.0")
    slippery = short("cold start", "operating.start=cold", "friction.kinetic_coefficient=0.02", "friction.static_coefficient=0.02")
    missed = {quantity for quantity, holds in verdicts(wrong, slippery).items() if not holds}
    assert missed == {"Largest roller force and its azimuth", "Friction during the cold start"}


def test_a_comparison_outside_its_tolerance_falls_short() -> None:
    healthy, cold = short("healthy"), short("cold start", "operating.start=cold")
    fast = replace(healthy, cage_speed=healthy.cage_speed * 1.01, spin=healthy.spin * 1.02)
    missed = {quantity for quantity, holds in verdicts(fast, cold).items() if not holds}
    assert missed == {"Cage speed, steady", "Roller spin in the load zone, relative to the cage and absolute"}


@functools.cache
def dry_bench(*settings: str) -> dict[str, bool]:
    """Return whether each row of the dry bench holds over 1.5 s."""
    run = simulate(paper_spec("healthy", "pocket", 1.7, settings))
    return {comparison.quantity.split(",")[0]: comparison.holds for comparison in dry_bench_rows(run)}


@pytest.mark.parametrize(
    ("settings", "missed"),
    [
        ((), set()),
        (
            ("cage.pocket_clearance=0.0005", "cage.restitution=0.5"),
            {"Acceleration of the outer ring", "Share of time in which a roller presses a bar", "Force at the bars: RMS"},
        ),
        (("cage.friction_coefficient=0.1",), {"Acceleration of the outer ring", "Power lost in friction"}),
    ],
)
def test_the_rows_of_the_dry_bench_notice_another_cage(settings: tuple[str, ...], missed: set[str]) -> None:
    assert {quantity for quantity, holds in dry_bench(*settings).items() if not holds} == missed


def test_the_power_of_the_defects_law_notices_its_width() -> None:
    def holds(width: str) -> bool:
        return power_of_sink(simulate(paper_spec("outer ring defect", "revolute", 0.5, (f"faults.outer_1.width={width}",)))).holds

    assert holds("0.002")
    assert not holds("0.0018")
    assert not holds("0.0022")


def test_report_contains_every_comparison() -> None:
    met = ReportRow("Cage speed", "pocket", "52.4", "52.44", "1 %", True)
    comparisons = [met, ReportRow("Friction", "revolute", "1.5 kN", "9 kN", "2 kN", False)]
    text = markdown(comparisons, run_specs(), ["figure_8_pocket.png"])
    assert summary(comparisons) == "1 of 2 comparisons fall short."
    assert "| Friction | revolute | 1.5 kN | 9 kN | 2 kN | falls short |" in text
    assert "](figure_8_pocket.png)" in text
    assert "Differences from the paper" in text
    assert "dcrb simulate paper --duration 3 --set operating.speed=124.8" in text


def test_a_folder_with_other_files_is_refused(tmp_path: Path) -> None:
    assert report_folder(tmp_path / "new") == tmp_path / "new"
    (tmp_path / "thesis.txt").write_text("three years of work")
    with pytest.raises(Refusal, match="contains files that are not a report"):
        report_folder(tmp_path)
    with pytest.raises(Refusal, match="is a file"):
        report_folder(tmp_path / "thesis.txt")
    with pytest.raises(Refusal, match="cannot be created: Not a directory"):
        report_folder(tmp_path / "thesis.txt" / "report")
    (tmp_path / REPORT).write_text("an earlier report")
    assert report_folder(tmp_path) == tmp_path
    (tmp_path / "killed" / ".writing-0123456789abcdef").mkdir(parents=True)
    assert not list(report_folder(tmp_path / "killed").iterdir())
