"""Sweeps of lives: their plan, their truth, their data sets, and recipes whose lives cannot end."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from data_sets import made
from folder_contents import contents
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, weibull_min

from dcrb_ros.prognosis.rating_life import dynamic_load_rating, rating_life
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.settings.shipped import shipped_folder
from dcrb_ros.sweep.cluster import ClusterWorkers
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.lives.card import design_text
from dcrb_ros.sweep.lives.plan import LifePlan
from dcrb_ros.sweep.lives.sweep import LifeSweep
from dcrb_ros.sweep.loader import read_sweep, sweep_of
from dcrb_ros.sweep.store import Store

SPECTRUM = [
    {"name": "fast", "share": 0.6, "speed_kmh": 160.0, "load": 1.2e5},
    {"name": "slow", "share": 0.3, "speed_kmh": 60.0, "load": 9e4},
    {"name": "stand", "share": 0.1},
]
QUICK: dict[str, Any] = {
    "kind": "life",
    "base": "dry",
    "set": {"cage.joint": "revolute"},
    "lives": 4,
    "spectrum": SPECTRUM,
    "inspection": {"every": 5000.0, "overhaul": 20000.0},
    "start": {"in_service": True},
    "growth": {"law": "paris", "revolutions": 2e8},
    "duration": 0.01,
}


def sweep(**changes: Any) -> LifeSweep:
    found = sweep_of({**QUICK, **changes}, "life.yaml")
    assert isinstance(found, LifeSweep)
    return found


# Lives


@given(st.integers(0, 2**31 - 1), st.sampled_from(["paris", "exponential", "gamma"]))
def test_the_truth_of_a_life_is_consistent(seed: int, law: str) -> None:
    population = sweep(seed=seed, growth={"law": law}).population
    for life in population.lives():
        hours = list(life.inspections(1000.0))
        assert hours == sorted(set(hours))
        assert life.count(1000.0) == len(hours)
        assert hours[0] == 0.0
        assert life.start < 20000.0
        assert hours[-1] == (life.failure if not life.censored else hours[-1])
        assert max(hours) <= life.end <= 20000.0
        widths = [life.width(hour) for hour in hours]
        assert widths == sorted(widths)
        assert all((width > 0.0) == (hour >= life.start) for hour, width in zip(hours, widths, strict=True))
        assert life.width(life.failure) == pytest.approx(0.014)


def test_starts_of_damage_have_the_distribution_of_the_rating_life() -> None:
    population = sweep(lives=2000, start={"slope": 1.5}).population
    starts = [life.start for life in population.lives()]
    scale = population.rating_hours / np.log(1.0 / 0.9) ** (1.0 / 1.5)
    assert kstest(starts, weibull_min(1.5, scale=scale).cdf).pvalue > 0.01


def test_damage_before_the_overhaul_is_drawn_from_the_same_distribution() -> None:
    population = sweep(lives=2000, start={"slope": 1.5, "in_service": True}).population
    starts = np.array([life.start for life in population.lives()])
    whole = weibull_min(1.5, scale=population.rating_hours / np.log(1.0 / 0.9) ** (1.0 / 1.5))
    assert starts.max() < 20000.0
    assert kstest(starts, lambda hour: whole.cdf(hour) / whole.cdf(20000.0)).pvalue > 0.01


def test_a_life_does_not_depend_on_the_number_of_lives() -> None:
    few, many = sweep(lives=3).population, sweep(lives=300).population
    for number in range(3):
        one, same = (
            (life.individual, life.component, life.location, life.start, life.failure) for life in (few.life(number), many.life(number))
        )
        assert one == same


def test_growth_takes_as_many_revolutions_as_under_the_reference_load() -> None:
    light, heavy = (
        sweep(spectrum=[{"name": "run", "share": 1.0, "speed_kmh": 100.0, "load": load}], growth={"reference_load": 1e5}).population
        for load in (1e5, 2e5)
    )
    assert light.growth_hours * light.duty.revolutions_per_hour == pytest.approx(5e7)
    assert light.growth_hours / heavy.growth_hours == pytest.approx(2.0 ** (10.0 / 3.0))


def test_the_data_card_states_the_median_growth_of_the_drawn_bearings() -> None:
    jumping = sweep(lives=201, growth={"law": "gamma", "jumps": 1.0, "scatter": 0.0})
    hours = sorted(life.failure - life.start for life in jumping.population.lives())
    assert f"The median of these bearings, overhaul\n  aside, is {hours[100]:.4g} h." in design_text(jumping)
    assert hours[100] > 1.05 * jumping.population.growth_hours


def test_clearance_shortens_the_rating_life() -> None:
    """A bearing nearly without clearance has the life of ISO 281 under the equivalent load, one with 0.14 mm a third."""
    pitch = Bearing().inner_raceway_radius + Bearing().roller_radius
    factors = []
    for clearance in (1e-6, 7e-5):
        radii = {"pitch_radius": pitch + 0.5 * clearance, "outer_raceway_radius": pitch + Bearing().roller_radius + clearance}
        population = sweep(set={"cage.joint": "revolute", "bearing": radii}).population
        rated = rating_life(dynamic_load_rating(Bearing()), population.duty.load)
        assert population.rating / rated == pytest.approx((population.zone_load / population.duty.load) ** (-10.0 / 3.0), rel=1e-3)
        factors.append(population.rating / rated)
    assert factors == [pytest.approx(1.0, abs=0.04), pytest.approx(0.33, abs=0.03)]


def test_a_data_set_records_the_model_of_its_lives() -> None:
    plan = plan_of(sweep())
    assert plan.sweep.inputs["life_model"] == "ISO/TS 16281 load zone"
    assert "`ISO/TS 16281 load zone`" in plan.design_text()


def test_components_have_their_shares() -> None:
    lives = list(sweep(lives=2000, damage={"outer": 0.2, "inner": 0.5, "roller": 0.3}).population.lives())
    shares = {name: sum(life.component == name for life in lives) / 2000 for name in ("outer", "inner", "roller")}
    # Four standard errors of a share of one half are 4.5 %.
    assert shares == pytest.approx({"outer": 0.2, "inner": 0.5, "roller": 0.3}, abs=0.045)


# Plans


def test_a_bearing_is_one_individual_in_one_split() -> None:
    plan = plan_of(sweep(lives=20))
    assert isinstance(plan, LifePlan)
    runs = list(plan.runs())
    assert len({run.name for run in runs}) == len(runs) == plan.sweep.count
    splits: dict[str, set[str]] = defaultdict(set)
    individuals: dict[str, set[int]] = defaultdict(set)
    for run in runs:
        splits[str(run.truth["bearing_id"])].add(run.split)
        individuals[str(run.truth["bearing_id"])].add(int(run.changes["surfaces.seed"]))
    assert {len(found) for found in splits.values()} == {len(found) for found in individuals.values()} == {1}
    assert len({next(iter(found)) for found in individuals.values()}) == 20
    counts = [sum(next(iter(found)) == split for found in splits.values()) for split in ("train", "validation", "test")]
    assert counts == [12, 4, 4]


def test_splits_and_noise_do_not_depend_on_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    before = [(run.name, run.split, run.seed) for run in plan_of(sweep()).runs()]
    monkeypatch.setattr("dcrb_ros.sweep.plan.model_fingerprint", lambda: "another model")
    after = [(run.name, run.split, run.seed) for run in plan_of(sweep()).runs()]
    assert [found[1:] for found in before] == [found[1:] for found in after]
    assert not {found[0] for found in before} & {found[0] for found in after}


def test_inspections_are_made_on_sections_by_their_hours() -> None:
    sections = [run.truth["section"] for run in plan_of(sweep(lives=200)).runs()]
    assert set(sections) == {"fast", "slow"}
    assert sections.count("fast") / len(sections) == pytest.approx(0.6 / 0.9, abs=0.06)
    fixed = plan_of(sweep(inspection={"every": 5000.0, "overhaul": 20000.0, "section": "slow"}))
    assert {run.truth["section"] for run in fixed.runs()} == {"slow"}


OILED = {"thermal.law": "network", "lubrication.law": "film", "cage.joint": "revolute"}


def test_the_surroundings_follow_the_year() -> None:
    climate = {"mean": 5.0, "season": 15.0, "hours_per_year": 4000.0}
    population = {"lives": 6, "inspection": {"every": 1000.0, "overhaul": 20000.0}, "start": {"rating": 5e6}}
    runs = list(plan_of(sweep(set=OILED, climate=climate, **population)).runs())
    by_bearing: dict[str, list[float]] = defaultdict(list)
    for run in runs:
        by_bearing[str(run.truth["bearing_id"])].append(float(run.changes["thermal.ambient"]))
    for found in by_bearing.values():
        # Inspections a quarter of a year apart: T(t) + T(t + half a year) = 2 mean, and the squares of quarters add up to the amplitude's.
        year = np.array(found[:20]) - 5.0
        assert np.allclose(year[:-2], -year[2:])
        assert np.allclose(year[:-1] ** 2 + year[1:] ** 2, 15.0**2)
    assert len({round(found[0], 6) for found in by_bearing.values()}) == 6
    assert all("thermal.ambient" not in run.changes for run in plan_of(sweep(set=OILED)).runs())


def test_a_spall_spreads_along_the_rollers() -> None:
    wide = {"surfaces.law": "profile", "cage.joint": "revolute"}
    plan = plan_of(sweep(set=wide, damage={"outer": 1.0, "inner": 0.0, "roller": 0.0}, lives=10))
    shares = [(float(run.truth["damage"]), run.changes["faults.outer_1.share"]) for run in plan.runs() if run.truth["damage"]]
    assert shares
    assert all(share == pytest.approx(min(3.0 * width / 0.048, 1.0)) for width, share in shares)


# Data sets


def test_a_data_set_of_lives_has_its_truth_and_is_the_same_in_parts(tmp_path: Path) -> None:
    folder, plan = tmp_path / "whole", plan_of(sweep())
    made(plan, folder)
    table, lives = pd.read_parquet(folder / "labels.parquet"), pd.read_parquet(folder / "lives.parquet")
    assert (table["status"] == "done").all()
    assert list(lives["inspections"]) == list(table.groupby("bearing_id").size())
    for bearing, rows in table.groupby("bearing_id"):
        life = lives.set_index("bearing_id").loc[bearing]
        assert rows["hours"].is_monotonic_increasing
        assert np.allclose(rows["hours"] + rows["remaining_life"], life["failure"])
        assert set(rows["split"]) == {life["split"]}
        assert (rows["fault"].ne("healthy") == (rows["hours"] >= life["start"])).all()
        assert np.allclose(rows.loc[rows["damage"] > 0.0, "width"], rows.loc[rows["damage"] > 0.0, "damage"])
        assert bool(life["censored"]) == (life["failure"] > 20000.0)
        if not life["censored"]:
            assert rows["remaining_life"].iloc[-1] == 0.0
    card = (folder / "README.md").read_text()
    assert "| `remaining_life` |" in card
    assert "The law and its constants are assumptions" in card
    assert "| split | bearings |" in card
    whole = contents(folder)
    missing = json.loads((folder / "labels" / f"{table['run'].iloc[3]}.json").read_text())
    (folder / missing["file"]).unlink()
    made(plan, folder)
    assert contents(folder) == whole


def test_two_workers_of_a_cluster_make_the_same_bits(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    plan = plan_of(sweep(lives=2))
    made(plan, tmp_path / "alone")
    with (
        distributed.Client(processes=False, n_workers=2, threads_per_worker=1, dashboard_address=None) as client,
        open_data_set(plan, Store(str(tmp_path / "cluster"))) as data_set,
    ):
        data_set.make(ClusterWorkers(client), lambda _: None)
    assert contents(tmp_path / "cluster") == contents(tmp_path / "alone")


def test_another_growth_is_another_data_set(tmp_path: Path) -> None:
    made(plan_of(sweep(lives=1)), tmp_path)
    with pytest.raises(Refusal, match=r"growth differs?"):
        made(plan_of(sweep(lives=1, growth={"law": "gamma"})), tmp_path)


@pytest.mark.parametrize("path", sorted((shipped_folder() / "sweeps").glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_sweeps_can_be_planned(path: Path) -> None:
    found = read_sweep(path)
    assert next(plan_of(found).runs()).position == 0
    assert found.count >= 100


# Refusals


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"kind": "lives"}, "kind = 'lives' is not life"),
        ({"points": 3}, "unknown key 'points'"),
        ({"spectrum": []}, "the spectrum is empty, so no life ends"),
        ({"spectrum": [{"name": "run", "share": 0.5, "speed_kmh": 100.0, "load": 1e5}]}, "shares of the spectrum add up to 0.5"),
        ({"spectrum": [{"name": "stand", "share": 1.0, "load": 1e5}]}, "never moves, so no life ends"),
        ({"spectrum": [{"name": "run", "share": 1.0, "speed_kmh": 100.0}]}, "the equivalent load of the duty is 0 N"),
        ({"spectrum": [{"name": "run", "share": 1.0, "speed_kmh": 100.0, "load": 100.0}]}, "the growth of the damage takes"),
        ({"start": {"rating": 1e9}}, "a life cannot end: the rating life takes"),
        ({"spectrum": [{"share": 1.0, "speed_kmh": 100.0, "load": 1e5}]}, "the level at 100 km/h has no name"),
        ({"spectrum": {"share": 1.0}}, "spectrum is not a list"),
        ({"spectrum": [{"name": "run", "share": 2.0}]}, r"spectrum\[0\]: share = 2.0 is outside 0 .. 1: give a share, not per cent"),
        ({"line": {"stations": []}}, "the duty is given twice"),
        ({"growth": {"revolutions": 1e13}}, "the growth of the damage takes"),
        ({"growth": {"law": "pairs"}}, "did you mean 'paris'"),
        ({"growth": {"law": ["paris"]}}, r"growth.law = \['paris'\] is not one of"),
        ({"growth": {"law": "gamma", "exponent": 2.0}}, "unknown parameter 'exponent'"),
        ({"damage": {"last_width": 0.001}}, "damage.last_width = 0.001 m is not above damage.first_width"),
        ({"damage": {"outer": 0.9}}, "add up to 1.4"),
        ({"damage": {"last_width": 0.04}}, "the end of a life: faults.inner_1.width = 0.04 m is not below the pitch"),
        ({"inspection": {"every": 20000.0, "overhaul": 20000.0}}, "inspection.every = 20000 h is not below 2e.04 h, the overhaul"),
        ({"inspection": {"every": 9e5}, "start": {}}, "is not below .* h, the basic rating life with the growth"),
        ({"inspection": {"every": 100.0}}, "start.in_service draws damage before an overhaul, and there is none"),
        ({"inspection": {"every": 0.0}}, "every = 0.0 h is outside 0.001 .. 1e.06 h"),
        ({"inspection": 5}, "inspection is not a group"),
        ({"climate": {"mean": 5.0}}, "climate needs temperatures, and thermal.law is none"),
        ({"set": OILED, "climate": {"season": -1.0}}, "season = -1.0 K is outside 0 .. 50 K"),
        ({"base": "outer_ring_defect"}, "the base has the fault faults.outer_1, but a life begins without damage"),
        ({"set": {"faults.broken_bars": "row1/bar3"}}, "the base has the fault faults.broken_bars"),
        ({"set": {"operating.speed": 90.0}}, "operating.speed = 90.0 under 'set' would have no effect, .* from the section"),
        ({"set": {"operating": {"load": 9e4}}}, "operating.load = 90000.0 under 'set' would have no effect"),
        ({"set": {"surfaces.seed": 3}}, "surfaces.seed = 3 under 'set' would have no effect, .* from the bearing"),
        ({"set": {**OILED, "thermal.ambient": 3.0}, "climate": {"mean": 5.0}}, "thermal.ambient = 3.0 .* from the climate"),
        ({"set": {"operating.lateral_load": 1e5}}, "operating.lateral_load = 100000 N, but the rating life is that of the load of the"),
        ({"start": {"rating": 1047.0}}, "the rating of 1047 N is below the equivalent load of .*: give start.rating in newtons, not kN"),
        ({"lives": 0}, "lives = 0 is outside 1 .. 1000000"),
        ({"inspection": {"every": 1e-3, "overhaul": 20000.0}}, "defines more than 1000000 inspections, .*: give fewer lives, or a larger"),
        ({"start": {"slope": 0.0}}, "slope = 0.0 is outside 0.3 .. 20"),
        ({"base": "ball_bearing_6205", "set": {}}, "contact.law = hertz is that of balls"),
        ({"duration": 4000.0, "output": "bag"}, "an inspection of 4000 s is longer than every stretch"),
    ],
)
def test_recipes_whose_lives_cannot_end_or_be_inspected_are_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(Refusal, match=words):
        sweep(**changes)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ({"stations": [{"name": "A"}]}, "has 1 station"),
        ({"stations": [{"name": "A", "speed_kmh": 80.0}, {"name": "B"}]}, "A - B is 0 km long"),
        ({"stations": [{"name": "A"}, {"name": "B", "km": 9.0}]}, "at 0 km/h, so no train reaches its end"),
        ({"stations": [{"speed_kmh": 80.0}, {"name": "B", "km": 9.0}]}, "has no name"),
        ([], "line is not a group"),
        ({"stations": [], "accel": 1.0}, "unknown parameter 'accel'"),
    ],
)
def test_lines_on_which_no_train_runs_are_refused(line: Any, words: str) -> None:
    tree = {key: value for key, value in QUICK.items() if key != "spectrum"}
    with pytest.raises(Refusal, match=words):
        sweep_of({**tree, "line": line}, "life.yaml")


def test_without_a_duty_or_a_number_of_lives_nothing_is_planned() -> None:
    with pytest.raises(Refusal, match="the duty is given nowhere"):
        sweep_of({key: value for key, value in QUICK.items() if key != "spectrum"}, "life.yaml")
    with pytest.raises(Refusal, match="'lives' is missing"):
        sweep_of({key: value for key, value in QUICK.items() if key != "lives"}, "life.yaml")
