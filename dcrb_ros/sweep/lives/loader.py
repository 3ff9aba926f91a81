"""Loading of a sweep of kind ``life``: every group is checked, and lives that cannot end are refused."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from dcrb_ros.bearing.load_distribution import roller_forces
from dcrb_ros.prognosis.rating_life import dynamic_load_rating, equivalent_load, rating_life, reference_load
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, overlaid, validated
from dcrb_ros.settings.impact_limits import BALLS
from dcrb_ros.sweep.design import Value
from dcrb_ros.sweep.lives.duty import Duty, duty_of_line, duty_of_spectrum
from dcrb_ros.sweep.lives.growth import GROWTH_LAWS, Growth
from dcrb_ros.sweep.lives.life import COMPONENTS, Population
from dcrb_ros.sweep.lives.recipe import Braking, Climate, Damage, Inspection, Level, Numbers, Recipe, Start, Station
from dcrb_ros.sweep.lives.sweep import LifeSweep
from dcrb_ros.sweep.sweep_file import MOST_RUNS, Sweep

COMMON = ("base", "set", "duration", "settle", "output", "windows", "split", "extended", "licence")
"""Keys that mean the same in every sweep."""
OWN = ("kind", "lives", "seed", "line", "spectrum", "inspection", "start", "damage", "growth", "climate")
NETWORK = "thermal.law"
LONGEST_LIFE = 1e8
"""Longest rating life, and longest mean growth [h]: beyond 11 000 years no life ends."""

Model = TypeVar("Model", bound=Group)


def life_sweep_of(tree: Mapping[str, Any], source: str, common: Sweep) -> LifeSweep:
    """Return the sweep of lives described by a tree read from YAML; ``common`` are its keys that every sweep has.

    Raises:
        Refusal: an unknown key, a value out of range, a bearing with balls, or lives that cannot end or are never inspected.
    """
    if "lives" not in tree:
        raise Refusal(f"{source}: 'lives' is missing: give the number of bearings")
    numbers = _group({key: tree[key] for key in ("lives", "seed") if key in tree}, Numbers, source)
    inspection = _group(tree.get("inspection", {}), Inspection, source, "inspection")
    start, damage = _group(tree.get("start", {}), Start, source, "start"), _group(tree.get("damage", {}), Damage, source, "damage")
    if common.file.split.apart:
        raise Refusal(f"{source}: split.apart is for single runs, lives keep every bearing in one split anyway: remove it")
    recipe = Recipe(numbers, inspection, start, damage, _growth(tree.get("growth", {}), source), _climate(tree, common, source))
    configuration = validated(common.base, Configuration, source)
    if configuration.contact.law == BALLS:
        raise Refusal(
            f"{source}: contact.law = {BALLS} is that of balls, and the load rating and the rating life are those of rollers: give a base "
            "with rollers"
        )
    _check_start(configuration, common, recipe, source)
    duty, written = _duty(tree, configuration.operating.wheel_diameter, source)
    population = _population(recipe, duty, configuration, source)
    sections = duty.inspected(inspection.section, common.file.duration + common.file.settle, source)
    sweep = LifeSweep(
        common.file, common.text, common.base, {}, {}, {}, recipe=recipe, duty=written, sections=sections, population=population
    )
    _check_last(sweep, source)
    if sweep.count > MOST_RUNS:
        raise Refusal(
            f"{source} defines more than {MOST_RUNS} inspections, the most runs of a sweep: give fewer lives, or a larger inspection.every"
        )
    return sweep


def _check_start(configuration: Configuration, common: Sweep, recipe: Recipe, source: str) -> None:
    """Refuse a base with damage, and parameters under ``set`` that each inspection has from its section, bearing or climate."""
    damage = next((key for key, _ in configuration.faults.damaging), None)
    if damage is not None:
        raise Refusal(f"{source}: the base has the fault faults.{damage}, but a life begins without damage: give a healthy base")
    if lateral := configuration.operating.lateral_load:
        raise Refusal(f"{source}: operating.lateral_load = {lateral:g} N, but the rating life is that of the load of the duty: set 0")
    drawn = {"operating.speed": "section", "operating.speed_kmh": "section", "operating.load": "section", "surfaces.seed": "bearing"}
    drawn |= {"thermal.ambient": "climate"} if recipe.climate else {}
    fixed = flatten(common.file.fixed)
    key = next((key for key in drawn if key in fixed), None)
    if key is not None:
        raise Refusal(
            f"{source}: {key} = {fixed[key]!r} under 'set' would have no effect, because it follows from the {drawn[key]} of each "
            "inspection: remove it"
        )


def common_keys(tree: Mapping[str, Any], source: str) -> dict[str, Any]:
    """Return the keys of a sweep of lives that every sweep has.

    Raises:
        Refusal: a key that no sweep of lives has.
    """
    for key in tree:
        if key not in (*COMMON, *OWN):
            known = (*OWN, *COMMON)
            raise Refusal(f"{source}: unknown key '{key}'{nearest(key, known)}; a sweep of lives has {', '.join(known)}")
    return {key: tree[key] for key in COMMON if key in tree}


def _group(tree: Any, kind: type[Model], source: str, name: str = "") -> Model:
    where = f"{source}: {name}".removesuffix(": ")
    if not isinstance(tree, Mapping):
        raise Refusal(f"{where} is not a group: write its keys below it, such as {next(iter(kind.model_fields))}")
    return validated(flatten(tree), kind, where)


def _growth(tree: Any, source: str) -> Growth:
    law = tree.get("law", "paris") if isinstance(tree, Mapping) else "paris"
    if not isinstance(law, str) or law not in GROWTH_LAWS:
        raise Refusal(f"{source}: growth.law = {law!r} is not one of {', '.join(GROWTH_LAWS)}{nearest(str(law), GROWTH_LAWS)}")
    return _group(tree, GROWTH_LAWS[law], source, "growth")


def _climate(tree: Mapping[str, Any], common: Sweep, source: str) -> Climate | None:
    if "climate" not in tree:
        return None
    if common.base[NETWORK] != "network":
        raise Refusal(
            f"{source}: climate needs temperatures, and {NETWORK} is {common.base[NETWORK]}: set it to network, or leave climate out"
        )
    return _group(tree["climate"], Climate, source, "climate")


def _duty(tree: Mapping[str, Any], wheel_diameter: float, source: str) -> tuple[Duty, tuple[dict[str, Any], ...]]:
    """Return the duty, and the stations or levels that define it."""
    if ("line" in tree) == ("spectrum" in tree):
        raise Refusal(f"{source}: the duty is given {'twice' if 'line' in tree else 'nowhere'}: give either line or spectrum")
    if "spectrum" in tree:
        levels = _listed(tree["spectrum"], Level, source, "spectrum")
        return duty_of_spectrum(levels, wheel_diameter, source), tuple(level.model_dump() for level in levels)
    line = tree["line"]
    if not isinstance(line, Mapping):
        raise Refusal(f"{source}: line is not a group: write stations, acceleration and braking below it")
    stations = _listed(line.get("stations", []), Station, source, "line.stations")
    braking = _group({key: value for key, value in line.items() if key != "stations"}, Braking, source, "line")
    return duty_of_line(stations, braking, wheel_diameter, source), (braking.model_dump(), *(station.model_dump() for station in stations))


def _listed(tree: Any, kind: type[Model], source: str, name: str) -> list[Model]:
    if not isinstance(tree, list):
        raise Refusal(f"{source}: {name} is not a list: write one entry per line, each with {', '.join(kind.model_fields)}")
    return [_group(entry, kind, source, f"{name}[{number}]") for number, entry in enumerate(tree)]


def _zone_load(duty: Duty, configuration: Configuration, rating: float) -> float:
    """Return the equivalent load of the duty with the load zones of its sections, whose clearance is that of a new bearing [N]."""
    bearing = configuration.bearing
    gap = bearing.radial_gap - configuration.faults.condition.clearance
    zones = {load: reference_load(bearing, rating, roller_forces(configuration, load, gap)) for load in {s.load for s in duty.sections}}
    return equivalent_load([zones[section.load] for section in duty.sections], [section.revolutions for section in duty.sections])


def _population(recipe: Recipe, duty: Duty, configuration: Configuration, source: str) -> Population:
    """Return the lives, and refuse those that do not end or are not inspected."""
    damage, inspection, start = recipe.damage, recipe.inspection, recipe.start
    total = damage.outer + damage.inner + damage.roller
    if abs(total - 1.0) > 1e-6:
        raise Refusal(f"{source}: damage.outer, inner and roller add up to {total:g}, but must add up to 1: give shares of all lives")
    if not damage.last_width > damage.first_width:
        raise Refusal(
            f"{source}: a life cannot end: damage.last_width = {damage.last_width:g} m is not above damage.first_width = "
            f"{damage.first_width:g} m; give a larger one"
        )
    if not duty.load > 0.0:
        raise Refusal(f"{source}: a life cannot end: the equivalent load of the duty is 0 N, without fatigue; give loads above 0 N")
    bearing = configuration.bearing
    rating = start.rating or dynamic_load_rating(bearing)
    load = _zone_load(duty, configuration, rating)
    if rating < load:
        raise Refusal(
            f"{source}: the rating of {rating:g} N is below the equivalent load of {load:.4g} N, for which ISO 281 has no life: give "
            "start.rating in newtons, not kN, or smaller loads"
        )
    population = Population(recipe, duty, rating_life(rating, load), load, bearing)
    longest = max(population.rating_hours, population.growth_hours)
    if longest > LONGEST_LIFE:
        term = "rating life" if population.rating_hours == longest else "growth of the damage"
        raise Refusal(
            f"{source}: a life cannot end: the {term} takes {longest:.3g} h under {duty.load:.4g} N, more than {LONGEST_LIFE:g} h; "
            "increase the loads, or reduce start.rating or growth.revolutions"
        )
    if start.in_service and not inspection.overhaul:
        raise Refusal(f"{source}: start.in_service draws damage before an overhaul, and there is none: give inspection.overhaul in hours")
    life = inspection.overhaul or population.rating_hours + population.growth_hours
    if inspection.every >= life:
        term = "the overhaul" if inspection.overhaul else "the basic rating life with the growth of the damage"
        raise Refusal(
            f"{source}: inspection.every = {inspection.every:g} h is not below {life:.4g} h, {term}, so few lives or none would have an "
            "inspection after their first hour: give a shorter interval"
        )
    return population


def _check_last(sweep: LifeSweep, source: str) -> None:
    """Refuse damage that no bearing can carry at its last width."""
    for component in COMPONENTS:
        if getattr(sweep.recipe.damage, component):
            location: dict[str, Value] = {"row": 1, "azimuth": 0.0, **({"roller": 1} if component == "roller" else {})}
            changes = dict(sweep.damage(component, location, 1, sweep.recipe.damage.last_width))
            for section in sweep.sections:
                loads = {"operating.speed": section.speed, "operating.load": section.load}
                validated(overlaid(sweep.base, {**changes, **loads}), Configuration, f"{source}: the end of a life")
