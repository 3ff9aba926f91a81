"""The part of a data card that describes lives: duty, rating life, start and growth of the damage, and outcomes."""

from __future__ import annotations

from statistics import median

from dcrb_ros.prognosis.rating_life import LIFE_MODEL
from dcrb_ros.sweep.lives.sweep import LifeSweep
from dcrb_ros.sweep.lives.table import LIVES
from dcrb_ros.text.markdown import table


def design_text(sweep: LifeSweep) -> str:
    """Return the section of the data card about the lives."""
    recipe, population, duty = sweep.recipe, sweep.population, sweep.population.duty
    failed, damaged, hours = 0, 0, []
    for life in population.lives():
        failed, damaged = failed + (not life.censored), damaged + (life.start < life.end)
        hours.append(life.failure - life.start)
    lives = len(hours)
    growth = ", ".join(f"{name} {value:g}" for name, value in recipe.growth.model_dump().items() if isinstance(value, float))
    damage, inspection, start = recipe.damage, recipe.inspection, recipe.start
    only = f"; only bearings whose damage starts before the overhaul are drawn, {100 * population.in_service:.3g} % of all"
    chosen = f", always {inspection.section}" if inspection.section else ", drawn by the hours at constant speed"
    overhaul = f"; service ends at {inspection.overhaul:g} h at the latest" if inspection.overhaul else ""
    columns = table(("column", "meaning"), ((f"`{name}`", meaning) for name, (_, meaning) in LIVES.items()))
    sections = table(
        ("section", "speed [rad/s]", "load [N]", "at constant speed [h]", "in total [h]", "revolutions"),
        ((s.name, f"{s.speed:.4g}", f"{s.load:g}", f"{s.steady:.4g}", f"{s.total:.4g}", f"{s.revolutions:.6g}") for s in duty.sections),
    )
    return f"""## Lives

{lives} bearings, of which {failed} fail and {lives - failed} are censored; {damaged} have damage before the end of their service.
Everything is drawn with the seed {recipe.numbers.seed}. `lives.parquet` has one row per bearing:

{columns}

* Duty, repeated until the bearing fails: {duty.revolutions_per_hour:.4g} revolutions per operating hour under an equivalent load of
  {duty.load:.4g} N.
* Start of the damage: Weibull with the slope {start.slope:g} about the basic reference rating life, {population.rating:.4g} revolutions or
  {population.rating_hours:.4g} h, which 90 % of the bearings reach{only if start.in_service else ""}. Its model is `{LIFE_MODEL}`: the
  load zone of the new bearing causes the fatigue of a bearing without clearance under {population.zone_load:.4g} N.
* Growth: law `{recipe.growth.law}` ({growth}),
  from {1e3 * damage.first_width:g} mm to {1e3 * damage.last_width:g} mm, at which the bearing has failed;
  it takes {population.growth_hours:.4g} h under this duty at the median rate and with mean steps. The median of these bearings, overhaul
  aside, is {median(hours):.4g} h. The law and its constants are assumptions, not measurements.
* Place: {damage.outer:g} outer raceway, {damage.inner:g} inner raceway, {damage.roller:g} rollers;
  its depth is {1e6 * damage.depth:g} um, and a spall is {damage.aspect:g} times as long along the rollers as wide.
* Inspections every {inspection.every:g} h from the first hour on, and at failure{overhaul}.
  Speed and load of each are those of a section of the duty{chosen}.
{_climate(sweep)}* Each bearing is an individual: its surfaces have a seed of their own (`surfaces.seed`).

{sections}"""


def _climate(sweep: LifeSweep) -> str:
    climate = sweep.recipe.climate
    if climate is None:
        return ""
    return (
        f"* Temperature of the surroundings (`ambient_temperature`): {climate.mean:g} deg C, {climate.season:g} K up and down over a year "
        f"of {climate.hours_per_year:g} operating hours,\n  and a deviation of {climate.day:g} K between inspections. Every inspection "
        "begins with the temperatures of steady running.\n"
    )
