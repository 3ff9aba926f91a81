"""The exam file: its schema, and how it is expanded into cases.

A list where a parameter takes a single value is a variation: one case is made for each value, for every operating point and seed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from dcrb_ros.exam.case import Case, CaseSimulation, derived_tags, refuse_ineffective, scenarios_hash
from dcrb_ros.exam.criteria import Criteria, DelayLimits
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.fault_history import fault_history
from dcrb_ros.exam.replica_priors import START, STARTS
from dcrb_ros.exam.revolutions import speed_knots
from dcrb_ros.exam.twins import with_twins
from dcrb_ros.schema.fields import Group, choice, quantity
from dcrb_ros.schema.refusal import Refusal, nearest, repeated
from dcrb_ros.schema.verdicts import FAULT_CLASSES, FaultClass
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import fields_by_key, flatten, layered, read_parameters, validated
from dcrb_ros.settings.shipped import find_configuration, find_shipped
from dcrb_ros.simulation.scenario import read_scenario_file, scheduled_changes, starting_configuration
from dcrb_ros.stream.late_scenario import refuse_late
from dcrb_ros.text.yaml import read_yaml

SEED = "simulation.seed"
MACHINE_TAG, GAIN_TAG = "machine", "gain"
"""Tags of the scenarios of a replica: simulated machine, and `measured.KNOWN` if its bearings were recorded with one gain."""
LARGEST_EXAM = 8_000_000
"""Largest file of an exam [bytes]: a replica takes some 2 kB per scenario."""
MOST_CASES = 2_000
"""Cases of an exam, without the twins; each is checked with its whole configuration, which takes a millisecond."""


class ScenarioEntry(Group):
    """A scenario of the file, or a family of scenarios."""

    name: str = Field(min_length=1)
    verdict: FaultClass
    points: list[str] | None = None
    """Operating points by name; all of them if omitted."""
    seeds: list[int] | None = Field(None, min_length=1)
    duration: float | None = Field(None, ge=0.1, le=1e5)
    onset: float | None = Field(None, ge=0.0, le=1e5)
    base: str | None = None
    """Configuration, if different from the exam's."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Parameters set from the start; a list gives one case per value."""
    fault: dict[str, Any] = Field(default_factory=dict)
    """Parameters set at the onset; a list gives one case per value. If empty, `set` or the timeline must produce the fault."""
    scenario: str = choice("", "A shipped scenario or a file, in addition to the fault")
    timeline: list[dict[str, Any]] = Field(default_factory=list)
    """Entries of a scenario, in addition to the fault."""
    tags: dict[str, str] = Field(default_factory=dict)
    graded_by: str = ""
    """Parameter of ``set`` or ``fault`` over which the probability of detection is reported, instead of the width of the defect."""
    required: bool = True
    twin: bool = True


class ReplicaOrigin(Group):
    """From which table, and how, the replica of measured recordings was made; see `dcrb_ros.exam.replica`."""

    table_sha256: str
    speed: str
    """Column of speeds: lines or documented."""
    seed: int
    machines: int
    counterparts: int
    longest: float
    """Longest part of a recording [s]."""
    lead: float = 0.0
    """Length of the healthy run before each recording [s]; 0 in a file that does not state it."""
    without: list[str]
    """Parts that are left out."""
    dcrb_ros: str


class ExamFile(Group):
    """An exam as written in its file."""

    exam: str
    about: str = ""
    base: str = "healthy"
    duration: float = quantity(10.0, "s", "Simulated time of a scenario", 0.1, 1e5)
    onset: float = quantity(4.0, "s", "Time at which the fault appears", 0.0, 1e5)
    seeds: list[int] = Field(default_factory=lambda: [1])
    points: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Parameters by operating point; `base` among them is the configuration of this point."""
    criteria: Criteria = Criteria()
    seal: str = choice("", "Hash published before a sealed exam, written by dcrb exam open")
    replica: ReplicaOrigin | None = None
    """Origin of a replica, written by dcrb exam replica."""
    scenarios: list[ScenarioEntry]


@dataclass(frozen=True)
class Exam:
    """An exam expanded into cases."""

    name: str
    about: str
    criteria: Criteria
    cases: tuple[Case, ...]
    seal: str = ""
    """Hash that was published before the exam was held; empty if it was not sealed."""
    replica: ReplicaOrigin | None = None
    """Origin of a replica; None of any other exam."""

    @property
    def digest(self) -> str:
        """SHA-256 of the scenarios; of a replica also of the machines and of the lengths and starts of the healthy runs."""
        if self.replica is None:
            return scenarios_hash(self.cases)
        return scenarios_hash(self.cases, (MACHINE_TAG, GAIN_TAG), lead=self.replica.lead, start=START, starts=STARTS)


def read_exam(source: str | Path) -> Exam:
    """Return the exam given by a file or by a shipped name.

    Raises:
        Refusal: there is no such exam, it has an unknown key or no expected verdict, or one of its scenarios is invalid.
    """
    return exam_of(read_yaml(find_shipped("exam", source), LARGEST_EXAM), str(source))


def exam_of(tree: Any, source: str) -> Exam:
    """Return the exam described by a tree read from YAML; see `read_exam`."""
    if not isinstance(tree, Mapping):
        raise Refusal(f"{source} is not an exam: it must have the keys 'exam', 'criteria' and a list 'scenarios'")
    if "vehicle" in tree:
        raise Refusal(f"{source} is the exam of a vehicle: score it with dcrb score, or read it with read_vehicle_exam")
    drawn = tree.get("scenarios")
    if "template" in tree or (isinstance(drawn, list) and any(isinstance(entry, Mapping) and "draw" in entry for entry in drawn)):
        raise Refusal(
            f"{source} is a sealed exam or the template of one: seal it with dcrb exam seal, and score what dcrb exam open writes"
        )
    try:
        file = ExamFile.model_validate(tree)
    except ValidationError as error:
        raise Refusal(f"{source}: {_sentence(error, tree)}") from None
    # Counted first, because a list in a small file can stand for millions of cases.
    count = sum(_count(file, entry, source) for entry in file.scenarios)
    if not 0 < count <= MOST_CASES:
        raise Refusal(f"{source} defines {count} scenarios: an exam must have 1 to {MOST_CASES}")
    cases = [case for entry in file.scenarios for case in _cases(file, entry, source)]
    if (twice := repeated(case.expectation.name for case in cases)) is not None:
        raise Refusal(f"{source}: two scenarios are called '{twice}': give them different names")
    return Exam(file.exam, file.about, file.criteria, tuple(with_twins(cases)), file.seal, file.replica)


def _sentence(error: ValidationError, tree: Mapping[str, Any]) -> str:
    """Return the first error of an exam file as a sentence."""
    problem = error.errors()[0]
    where, key = _location(problem["loc"][:-1], tree), str(problem["loc"][-1])
    if problem["type"] == "extra_forbidden":
        inside = problem["loc"][:-1]
        model = ExamFile if not inside else ScenarioEntry if inside[0] == "scenarios" else DelayLimits if "delay" in inside else Criteria
        known = model.model_fields
        return f"{where}unknown key '{key}'{nearest(key, known)} (known: {', '.join(known)})"
    if key == "verdict":
        reason = "the key 'verdict' is missing" if problem["type"] == "missing" else f"verdict = {problem['input']!r} is unknown"
        return f"{where}{reason}: give one of {', '.join(FAULT_CLASSES)}"
    if problem["type"] == "missing":
        return f"{where}the key '{key}' is missing"
    return f"{where}{key} = {problem['input']!r} is refused: {problem['msg'][0].lower()}{problem['msg'][1:]}"


def _location(location: Sequence[int | str], tree: Mapping[str, Any]) -> str:
    """Return the place of an error in the file, as the beginning of a sentence."""
    if len(location) >= 2 and location[0] == "scenarios" and isinstance(location[1], int):
        entry = tree["scenarios"][location[1]]
        name = entry.get("name") if isinstance(entry, Mapping) else None
        return f"scenario {repr(name) if name else location[1] + 1}: "
    return f"{'.'.join(str(part) for part in location)}: " if location else ""


def _points(file: ExamFile, entry: ScenarioEntry) -> list[str]:
    """Return the names of an entry's operating points."""
    return list(file.points) if entry.points is None else entry.points


def _lists(entry: ScenarioEntry, where: str) -> list[tuple[str, str, list[Any]]]:
    """Return group, key and values of every list in an entry."""
    groups = {"set": flatten(entry.set), "fault": flatten(entry.fault)}
    lists = [(name, key, value) for name, group in groups.items() for key, value in group.items() if isinstance(value, list)]
    empty = next((key for _, key, values in lists if not values), None)
    if empty is not None:
        raise Refusal(f"{where}: {empty} has an empty list: give at least one value")
    return lists


def _count(file: ExamFile, entry: ScenarioEntry, source: str) -> int:
    """Return the number of an entry's cases."""
    lists = _lists(entry, f"{source}, scenario '{entry.name}'")
    return max(1, len(_points(file, entry))) * len(entry.seeds or file.seeds) * math.prod(len(values) for _, _, values in lists)


def _cases(file: ExamFile, entry: ScenarioEntry, source: str) -> Iterator[Case]:
    """Yield the cases of an entry."""
    where = f"{source}, scenario '{entry.name}'"
    names = _points(file, entry)
    unknown = [name for name in names if name not in file.points]
    if unknown:
        raise Refusal(f"{where}: there is no operating point '{unknown[0]}'{nearest(unknown[0], file.points)}")
    for point in names or [""]:
        settings = dict(file.points.get(point, {}))
        given = {**flatten(settings), **flatten(entry.set)}
        refuse_ineffective(given, where)
        if SEED in given:
            raise Refusal(f"{where}: {SEED} cannot be set here: use 'seeds', a list such as [1, 2]")
        base = _base(settings.pop("base", None), file, entry, f"{where}, point '{point}'")
        # Only the first seed is checked with the whole configuration, which does not depend on the seed.
        known: dict[str, Case] = {}
        for seed in entry.seeds or file.seeds:
            for fixed, fault, words in _variations(entry, where):
                overlay = layered({**flatten(settings), SEED: seed}, fixed)
                bare = "/".join([entry.name, *([point] if len(names) > 1 else []), *words])
                many_seeds = len(entry.seeds or file.seeds) > 1
                name = f"{bare}/seed{seed}" if many_seeds else bare
                if bare in known and _is_seed(overlay[SEED]):
                    yield _with_seed(known[bare], name, overlay[SEED])
                    continue
                tags: dict[str, str] = {**({"point": point} if point else {}), **entry.tags}
                tagged = entry.model_copy(update={"tags": tags})
                known[bare] = _case(file, tagged, f"{source}, scenario '{name}'", name, base, overlay, fault)
                yield known[bare]


def _base(given: Any, file: ExamFile, entry: ScenarioEntry, where: str) -> Mapping[str, Any]:
    """Return the parameters with which the cases of an entry begin at a point that gives the configuration ``given``, if any."""
    if given is not None and not isinstance(given, str):
        raise Refusal(f"{where}: base = {given!r} is not a configuration: give the name of a shipped one or a file")
    if given is not None and entry.base is not None:
        raise Refusal(f"{where}: base is '{given}' for the point and '{entry.base}' for the scenario: give one of them")
    # The parameters of the file only, not the validated ones: a preset fills in the values that are not given.
    return read_parameters(find_configuration(given or entry.base or file.base), "simulator")


def _is_seed(value: Any) -> bool:
    """Return whether a configuration takes a value as its seed."""
    field = fields_by_key()[SEED]
    return type(value) is int and field.low is not None and field.high is not None and field.low <= value <= field.high


def _with_seed(case: Case, name: str, seed: int) -> Case:
    """Return a case with another name and a valid seed."""
    simulation = case.simulation.configuration.simulation.model_copy(update={"seed": seed})
    configuration = case.simulation.configuration.model_copy(update={"simulation": simulation})
    return Case(replace(case.expectation, name=name), replace(case.simulation, configuration=configuration))


def _variations(entry: ScenarioEntry, where: str) -> Iterator[tuple[dict[str, Any], dict[str, Any], list[str]]]:
    """Yield fixed parameters, fault parameters and name parts for every combination of listed values."""
    lists = _lists(entry, where)
    for values in itertools.product(*(value for _, _, value in lists)):
        groups, words = {"set": flatten(entry.set), "fault": flatten(entry.fault)}, []
        for (group, key, _), value in zip(lists, values, strict=True):
            groups[group][key] = value
            words.append(f"{key.rsplit('.', 1)[-1]}={value}")
        yield groups["set"], groups["fault"], words


def _case(
    file: ExamFile,
    entry: ScenarioEntry,
    where: str,
    name: str,
    base: Mapping[str, Any],
    overlay: Mapping[str, Any],
    fault: Mapping[str, Any],
) -> Case:
    """Return a case with its run and what is expected of a detector."""
    faulty, duration = entry.verdict != "healthy", entry.duration or file.duration
    if not faulty:
        _refuse_options_of_faults(entry, where)
    configuration, others = _changes_besides_fault(entry, validated(layered(base, overlay), Configuration, where), duration, where)
    fault_time = file.onset if entry.onset is None else entry.onset
    changes = [*others, *([{"at": fault_time, "set": dict(fault)}] if fault else [])]
    scenario = {"timeline": changes} if changes else None
    events = scheduled_changes(scenario, configuration, where) if scenario else []
    late = next((change["at"] for change in entry.timeline if change["at"] >= duration), None)
    if late is not None:
        raise Refusal(f"{where}: an entry at {late:g} s is not before its end at {duration:g} s: increase the duration or remove it")
    history = fault_history(configuration, events, where)
    onset = 0.0
    if faulty:
        onset = fault_time if fault or entry.onset is not None else history.onset_of(entry.verdict, where)
    history.refuse_contradiction(entry.verdict, onset, where)
    limit = file.criteria.delay.of(entry.verdict) if faulty else 0.0
    # The last verdict of a replica counts, whenever it is given.
    if faulty and file.replica is None and duration < onset + limit - 1e-9:
        raise Refusal(
            f"{where}: it ends {duration - onset:g} s after the onset, but criteria.delay.{entry.verdict} allows {limit:g} s: "
            "increase the duration or reduce the limit"
        )
    derived = derived_tags(configuration, fault) | _grade(entry, {**overlay, **fault}, where)
    narrow = faulty and 0.0 < float(derived.get("width", 0.0)) < file.criteria.smallest_width
    first = history.first(onset)
    expectation = Expectation(
        name,
        entry.verdict,
        duration,
        onset,
        {**derived, **entry.tags},
        "?" if _has_twin(entry, configuration, others, fault, where) else "",
        first if first < onset else None,
        required=entry.required and not narrow,
        bearing_onset=history.first_of_bearing if entry.verdict == "sensor" else None,
        speeds=tuple(speed_knots(configuration, events)),
    )
    return Case(expectation, CaseSimulation(configuration, scenario, duration))


def _refuse_options_of_faults(entry: ScenarioEntry, where: str) -> None:
    """Refuse what has no effect on a healthy bearing."""
    undetected = "on a healthy bearing, where nothing is to be detected"
    for ineffective, text in (
        (entry.onset is not None, f"onset = {entry.onset or 0.0:g} s has no effect on a healthy bearing, to which nothing happens"),
        (not entry.required, f"required = false has no effect {undetected}"),
        (bool(entry.graded_by), f"graded_by = {entry.graded_by} has no effect {undetected}"),
    ):
        if ineffective:
            raise Refusal(f"{where}: {text}: leave it out")


def _changes_besides_fault(
    entry: ScenarioEntry, configuration: Configuration, duration: float, where: str
) -> tuple[Configuration, list[dict[str, Any]]]:
    """Return the configuration at the start, and the changes by the scenario and the timeline of an entry."""
    if not entry.scenario:
        return configuration, list(entry.timeline)
    profile = read_scenario_file(Path(entry.scenario))
    starting = starting_configuration(profile, configuration, where)
    scheduled_changes(profile, starting, f"{where}, {entry.scenario}")
    refuse_late(profile, duration, f"{where}: the scenario '{entry.scenario}'", "increase the duration or remove it")
    return starting, [*profile["timeline"], *entry.timeline]


def _has_twin(entry: ScenarioEntry, configuration: Configuration, others: Sequence[Any], fault: Mapping[str, Any], where: str) -> bool:
    """Return whether a case has a healthy twin: the same run without its fault."""
    appears = entry.verdict != "healthy" and bool(fault)
    if entry.twin and appears:
        bare = f"{where}, without its fault"
        events = scheduled_changes({"timeline": list(others)}, configuration, bare) if others else []
        if fault_history(configuration, events, bare).is_healthy:
            return True
    if entry.twin and "twin" in entry.model_fields_set:
        without = "where another fault remains in the healthy run" if appears else "without a fault that appears"
        raise Refusal(f"{where}: twin = true has no effect {without}: leave it out, or give all faults under 'fault'")
    return False


def _grade(entry: ScenarioEntry, given: Mapping[str, Any], where: str) -> dict[str, str | float]:
    """Return the tags of the parameter that grades an entry; none if it has no ``graded_by``."""
    key = entry.graded_by
    if not key:
        return {}
    known = [*flatten(entry.set), *flatten(entry.fault)]
    if key not in known:
        raise Refusal(f"{where}: graded_by = {key} is neither in 'set' nor in 'fault': give one of their keys{nearest(key, known)}")
    value = given[key]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise Refusal(f"{where}: graded_by = {key} has the value {value!r}: give a parameter with numbers")
    return {"graded_by": key, "grade": float(value)}
