"""The file of an exam: what it may hold, and how it becomes cases.

A list where a parameter wants one value is a variation: the case is made once with each, crossed with the operating points and seeds.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError

from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.exam.case import Case, Run, canonical, described
from dcrb_ros.exam.criteria import Criteria, DelayLimits
from dcrb_ros.exam.opinion import VERDICTS
from dcrb_ros.exam.question import Question
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.runtime.refusal import Refusal, nearest
from dcrb_ros.schema.fields import Group, choice, quantity
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import find_configuration, flatten, read_parameters, shipped_folder, validated
from dcrb_ros.settings.vehicle_speed import without_replaced
from dcrb_ros.settings.yaml import read_yaml
from dcrb_ros.simulation.scenario import ScheduledChange, read_scenario_file, scheduled_changes, starting_configuration

MOST_CASES = 10_000
Verdict = Literal["healthy", "outer_ring", "inner_ring", "roller", "cage", "compound", "sensor"]


class Entry(Group):
    """A scenario, or a family of them."""

    name: str
    verdict: Verdict
    points: list[str] | None = None
    """Operating points by name; all without this key."""
    seeds: list[int] | None = None
    duration: float | None = Field(None, ge=0.1, le=1e5)
    onset: float | None = Field(None, ge=0.0, le=1e5)
    base: str | None = None
    """A configuration of its own."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Parameters from the start on; of a list one each."""
    fault: dict[str, Any] = Field(default_factory=dict)
    """Parameters that appear at the onset; of a list one each. Without any, `set` or the timeline must bring what is to be found."""
    scenario: str = choice("", "A shipped scenario or a file, beside the fault")
    timeline: list[dict[str, Any]] = Field(default_factory=list)
    """Entries of a scenario, beside the fault."""
    tags: dict[str, str] = Field(default_factory=dict)
    required: bool = True
    twin: bool = True


class Design(Group):
    """An exam as its file gives it."""

    exam: str
    about: str = ""
    base: str = "healthy"
    duration: float = quantity(10.0, "s", "Simulated time of a scenario", 0.1, 1e5)
    onset: float = quantity(4.0, "s", "When the fault appears", 0.0, 1e5)
    seeds: list[int] = Field(default_factory=lambda: [1])
    points: dict[str, dict[str, Any]] = Field(default_factory=dict)
    criteria: Criteria = Criteria()
    scenarios: list[Entry]


@dataclass(frozen=True)
class Exam:
    """An exam, ready to be sat."""

    name: str
    about: str
    criteria: Criteria
    cases: tuple[Case, ...]


def shipped_exams() -> dict[str, Path]:
    """Return the shipped exams by name."""
    return {path.stem: path for path in sorted((shipped_folder() / "exams").glob("*.yaml"))}


def read_exam(source: str | Path) -> Exam:
    """Return an exam given by its file or a shipped name.

    Raises:
        Refusal: there is none, it has an unknown key or no expected verdict, or the bench refuses one of its scenarios.
    """
    shipped = shipped_exams()
    path = Path(source)
    if not path.is_file():
        if str(source) not in shipped:
            raise Refusal(f"there is no exam '{source}': give a YAML file or one of {', '.join(shipped)}{nearest(str(source), shipped)}")
        path = shipped[str(source)]
    return exam_of(read_yaml(path), str(source))


def exam_of(tree: Any, source: str) -> Exam:
    """Return the exam that a tree, as YAML gives it, describes; see `read_exam`."""
    if not isinstance(tree, Mapping):
        raise Refusal(f"{source} is no exam: it must hold 'exam', 'criteria' and a list of 'scenarios'")
    try:
        design = Design.model_validate(tree)
    except ValidationError as error:
        raise Refusal(f"{source}: {_sentence(error, tree)}") from None
    cases = [case for entry in design.scenarios for case in _cases(design, entry, source)]
    if not 0 < len(cases) <= MOST_CASES:
        raise Refusal(f"{source} makes {len(cases)} scenarios: an exam has 1 to {MOST_CASES}")
    names = [case.question.name for case in cases]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise Refusal(f"{source}: two scenarios are called '{twice}': give them names of their own")
    return Exam(design.exam, design.about, design.criteria, tuple(_with_twins(cases)))


def _sentence(error: ValidationError, tree: Mapping[str, Any]) -> str:
    """Return the first thing wrong with a design in one sentence."""
    problem = error.errors()[0]
    where, key = _place(problem["loc"][:-1], tree), str(problem["loc"][-1])
    if problem["type"] == "extra_forbidden":
        inside = problem["loc"][:-1]
        model = Design if not inside else Entry if inside[0] == "scenarios" else DelayLimits if "delay" in inside else Criteria
        known = model.model_fields
        return f"{where}unknown key '{key}'{nearest(key, known)} (known: {', '.join(known)})"
    if key == "verdict":
        said = "has no expected verdict" if problem["type"] == "missing" else f"expects {problem['input']!r}, which is no verdict"
        return f"{where}it {said}: give verdict, one of {', '.join(VERDICTS)}"
    if problem["type"] == "missing":
        return f"{where}the key '{key}' is missing"
    return f"{where}{key} = {problem['input']!r} is refused: {problem['msg'][0].lower()}{problem['msg'][1:]}"


def _place(location: Sequence[int | str], tree: Mapping[str, Any]) -> str:
    """Return where in the file something stands, as the beginning of a sentence."""
    if len(location) >= 2 and location[0] == "scenarios" and isinstance(location[1], int):
        entry = tree["scenarios"][location[1]]
        name = entry.get("name") if isinstance(entry, Mapping) else None
        return f"scenario {repr(name) if name else location[1] + 1}: "
    return f"{'.'.join(str(part) for part in location)}: " if location else ""


def _cases(design: Design, entry: Entry, source: str) -> Iterator[Case]:
    """Yield the cases of an entry."""
    where = f"{source}, scenario '{entry.name}'"
    names = list(design.points) if entry.points is None else entry.points
    unknown = [name for name in names if name not in design.points]
    if unknown:
        raise Refusal(f"{where}: there is no operating point '{unknown[0]}'{nearest(unknown[0], design.points)}")
    # As its file gives it, not as it comes out: a preset fills in what nobody has given.
    base = read_parameters(find_configuration(entry.base or design.base), "simulator")
    for point in names or [""]:
        for seed in entry.seeds or design.seeds:
            for fixed, fault, words in _variations(entry, where):
                overlay = {**flatten(design.points.get(point, {})), "simulation.seed": seed, **fixed}
                parts = [entry.name, *([point] if len(names) > 1 else []), *words]
                many_seeds = len(entry.seeds or design.seeds) > 1
                name = "/".join([*parts, *([f"seed{seed}"] if many_seeds else [])])
                tags: dict[str, str] = {**({"point": point} if point else {}), **entry.tags}
                tagged = entry.model_copy(update={"tags": tags})
                yield _case(design, tagged, f"{source}, scenario '{name}'", name, base, overlay, fault)


def _variations(entry: Entry, where: str) -> Iterator[tuple[dict[str, Any], dict[str, Any], list[str]]]:
    """Yield what is set, the fault and the words that tell it from the others, for every combination of listed values."""
    fixed, fault = flatten(entry.set), flatten(entry.fault)
    lists = [(group, key, value) for group in (fixed, fault) for key, value in group.items() if isinstance(value, list)]
    empty = next((key for _, key, values in lists if not values), None)
    if empty is not None:
        raise Refusal(f"{where}: {empty} has an empty list: give the values to try, or one without a list")
    for values in itertools.product(*(value for _, _, value in lists)):
        own = dict(fixed), dict(fault)
        for (group, key, _), value in zip(lists, values, strict=True):
            own[0 if group is fixed else 1][key] = value
        yield (*own, [f"{key.rsplit('.', 1)[-1]}={value}" for (_, key, _), value in zip(lists, values, strict=True)])


def _case(
    design: Design, entry: Entry, where: str, name: str, base: Mapping[str, Any], overlay: Mapping[str, Any], fault: Mapping[str, Any]
) -> Case:
    configuration = validated({**without_replaced(base, overlay), **overlay}, Configuration, where)
    duration = entry.duration or design.duration
    faulty = entry.verdict != "healthy"
    appears = design.onset if entry.onset is None else entry.onset
    told: list[Any] = []
    if entry.scenario:
        profile = read_scenario_file(Path(entry.scenario))
        configuration = starting_configuration(profile, configuration, where)
        scheduled_changes(profile, configuration, f"{where}, {entry.scenario}")
        told += profile["timeline"]
    told += [*entry.timeline, *([{"at": appears, "set": dict(fault)}] if fault else [])]
    story = {"timeline": told} if told else None
    events = scheduled_changes(story, configuration, where) if story else []
    onset = 0.0
    if faulty:
        onset = appears if fault or entry.onset is not None else _since(configuration, events, entry.verdict, where)
    if faulty and duration < onset + design.criteria.delay.of(entry.verdict) - 1e-9:
        raise Refusal(
            f"{where}: it ends {duration - onset:g} s after the onset, within the {design.criteria.delay.of(entry.verdict):g} s that "
            f"criteria.delay.{entry.verdict} allows: make the duration longer or the limit shorter"
        )
    facts = described(configuration, fault)
    tags = {**facts, **entry.tags}
    narrow = faulty and 0.0 < float(facts.get("width", 0.0)) < design.criteria.smallest_width
    twin = "?" if faulty and entry.twin and fault else ""
    both = entry.verdict == "sensor" and any(key.startswith("faults.") for key in fault)
    required, bearing = entry.required and not narrow, onset if both else None
    question = Question(name, entry.verdict, duration, onset, tags, twin, required=required, bearing_onset=bearing)
    return Case(question, Run(configuration, story, duration))


def _since(configuration: Configuration, events: Sequence[ScheduledChange], verdict: str, where: str) -> float:
    """Return since when a verdict is right where no fault appears at an onset: from the start on, or by the timeline [s]."""
    present = configuration
    if class_of(present.described_faults()) == verdict:
        return 0.0
    for event in events:
        present = altered(present, event.changes, where)
        if class_of(present.described_faults()) == verdict:
            return event.step / present.step_rate
    raise Refusal(f"{where}: nothing in it makes {verdict} right: give 'fault', a timeline with one, or 'onset' for what is meant")


def _without_fault(case: Case) -> Mapping[str, Any] | None:
    """Return the timeline of a case's twin."""
    told = list((case.run.story or {"timeline": []})["timeline"])[:-1]
    return {"timeline": told} if told else None


def _twin_name(case: Case, taken: Sequence[str]) -> str:
    """Return a name for a case's twin, after the operating point."""
    point = case.question.tags.get("point")
    name = f"twin/{point}" if point else "twin"
    return next(free for free in itertools.chain([name], (f"{name}-{number}" for number in itertools.count(2))) if free not in taken)


def _with_twins(cases: Sequence[Case]) -> Iterator[Case]:
    """Yield the cases, those with a fault naming their twins, and then the twins: one for each operating point and seed."""
    twins: dict[str, Case] = {}
    names = [case.question.name for case in cases]
    for case in cases:
        if not case.question.twin:
            yield case
            continue
        story = _without_fault(case)
        key = canonical([case.run.configuration.model_dump(), story])
        known = twins.get(key)
        duration = max(case.run.duration, known.run.duration if known else 0.0)
        name = known.question.name if known else _twin_name(case, [*names, *(twin.question.name for twin in twins.values())])
        point = {"point": case.question.tags["point"]} if "point" in case.question.tags else {}
        tags = {**described(case.run.configuration, {}), **point}
        twins[key] = Case(Question(name, "healthy", duration, 0.0, tags), Run(case.run.configuration, story, duration))
        yield replace(case, question=replace(case.question, twin=name))
    yield from twins.values()
