"""The chapters on oil film, surfaces and friction: their rows hold, and a changed bench or result makes them fall short."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from dcrb_ros.validation import friction_moment, oiled_bench, surface_rows
from dcrb_ros.validation.oiled_runs import OiledRun, oiled_spec, oiled_specs, simulate_oiled
from dcrb_ros.validation.report import chapters, markdown
from dcrb_ros.validation.report_row import ReportRow, about, between

VISCOSITY = 39.5  # mm^2/s, 100 at 40 and 11 at 100 deg C by Walther, at 60 deg C


def short(rows: Iterable[ReportRow]) -> set[str]:
    """Return the quantities of the rows that fall short."""
    return {row.quantity for row in rows if not row.holds}


def test_ranges_and_tolerances_end_where_they_say() -> None:
    assert about("x", "q", (1.0, 2.0), (1.009, 2.0), 0.01).holds
    assert not about("x", "q", (1.0, 2.0), (1.0, 2.03), 0.01).holds
    assert [between("x", "q", value, 1.0, 2.0).holds for value in (0.99, 1.0, 2.0, 2.01, float("nan"))] == [False, True, True, False, False]


@functools.cache
def steady() -> OiledRun:
    """Return a short run of the lubricated bench at constant speed."""
    (spec,) = (spec for spec in oiled_specs() if spec.name == "steady")
    return simulate_oiled(replace(spec, duration=0.3))


def test_friction_balances_and_a_wrong_one_falls_short() -> None:
    run = steady()
    assert short(oiled_bench.balance_rows(run)) == set()
    assert short(oiled_bench.friction_rows(run)) == set()
    doubled = replace(run, change=replace(run.change, drive=2.2 * run.change.drive))
    assert len(short(oiled_bench.balance_rows(doubled))) == 2
    assert short(oiled_bench.friction_rows(doubled)) >= {"The same by Palmgren, the ends of his factors and 40 % beyond"}
    dry = replace(run, change=replace(run.change, drive=0.1 * run.change.drive))
    assert len(short(oiled_bench.friction_rows(dry))) == 2


def test_a_lossless_source_is_noticed() -> None:
    run = steady()
    silent = tuple(replace(state, friction_loss=state.friction_loss * np.array([1.0, 1.0, 1.0, 1.0, 0.0, 1.0])) for state in run.states)
    assert "Power of all sources over that of the shaft at constant speed" in short(oiled_bench.balance_rows(replace(run, states=silent)))


def test_a_cold_start_notices_another_limiting_friction() -> None:
    (spec,) = (spec for spec in oiled_specs() if spec.name == "cold start")
    for changes, missed in (((), set()), (("lubrication.limiting_friction=0.09",), {True})):
        run = simulate_oiled(spec, changes)
        assert {not row.holds for row in oiled_bench.cold_rows(run)} - {False} == missed


def waves(*changes: str) -> set[str]:
    """Return the rows of waviness alone that fall short with changed parameters."""
    runs = {spec.name: simulate_oiled(replace(spec, duration=0.3), changes) for spec in oiled_specs() if spec.name.startswith("waves")}
    rows = surface_rows.wave_rows(runs["waves"], runs["waves with box"])
    return {row.quantity.split(",")[0] for row in rows if not row.holds}


@pytest.mark.slow
def test_the_level_of_waviness_is_noticed_and_what_an_axle_box_takes_of_it() -> None:
    assert waves() == set()
    assert waves("surfaces.waviness=1.5e-7") == {"RMS by waviness of 0.1 um alone"}
    assert waves("housing.box_mass=40") == waves("housing.box_mass=80") == {"The same with an axle box of 60 kg"}


def test_palmgren_is_the_sum_of_a_viscous_and_a_load_moment() -> None:
    # M_0 = 1e-7 f_0 (nu n)^(2/3) d_m^3 and M_1 = f_1 P d_m, in N mm, by hand: 719 and 2850
    given = 0.130, 0.250, 50e3, 125.664, VISCOSITY
    assert friction_moment.palmgren_moment(*given) == pytest.approx(3.569, rel=1e-3)
    unloaded = friction_moment.palmgren_moment(*given[:2], 0.0, *given[3:])
    assert unloaded == pytest.approx(0.719, rel=2e-3)
    slow = [friction_moment.palmgren_moment(*given[:2], 0.0, speed, VISCOSITY) for speed in (1.0, 2.0)]
    assert slow[0] == slow[1] == pytest.approx(1e-10 * 0.8 * 2000.0 ** (2.0 / 3.0) * 190.0**3, rel=1e-9)


def test_the_report_has_a_table_for_each_chapter() -> None:
    rows = [ReportRow("spin", "both", "-", "1", "1", True), ReportRow("film", "pocket", "-", "2", "2", True, "Oil")]
    assert list(chapters(rows)) == ["The paper", "Oil"]
    text = markdown(rows, [oiled_spec("healthy", 1.0)], [])
    assert text.index("### The paper") < text.index("| spin |") < text.index("### Oil") < text.index("| film |")
    assert "dcrb simulate healthy --duration 1.2 --set sensor.noise_density=0" in text


def test_oiled_runs_are_distinct_and_valid() -> None:
    specs = oiled_specs()
    assert len({spec.name for spec in specs}) == len(specs)
    for spec in specs:
        assert spec.configuration().lubrication.law == "film_with_cages"
