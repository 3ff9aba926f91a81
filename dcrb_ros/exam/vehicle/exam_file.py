"""The exam of a vehicle: its file, and how it is expanded into vehicles.

As in an exam of a bearing, a list where a parameter takes a single value is a variation. In the keys of a scenario, ``box`` is replaced
by each of its ``boxes`` in turn.
"""

from __future__ import annotations

import hashlib
import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from dcrb_ros.exam.case import canonical, refuse_ineffective
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.schema.fields import Group, choice, quantity
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal, nearest, repeated
from dcrb_ros.schema.verdicts import FaultClass, contradicts
from dcrb_ros.settings.files import flatten, load_configuration, validated
from dcrb_ros.settings.shipped import find_shipped
from dcrb_ros.text.yaml import read_yaml
from dcrb_ros.vehicle.description import Journey, Vehicle, Wheel
from dcrb_ros.vehicle.file import DRIVE, GROUPS, SEEDS, as_floats, read_parameters, seed_of, vehicle_of

PLACEHOLDER = "box"
"""In the keys of a scenario, the box in question."""
DRAWN = ("vehicle.seed", "track.seed", "paths.seed")
"""Seeds of a vehicle that an exam draws."""
CANT, CURVATURE = "vehicle.cant", "vehicle.curvature"
CHECKED = re.compile(r"(^|\.)(bench|faults|sensor|publishing)\b")
"""Keys on which the correct verdict of a box depends, or whether its signal has gaps."""
MOST_CASES = 2000
"""Vehicles of an exam at most [-]."""


class VehicleEntry(Group):
    """A scenario of the file, or a family of scenarios."""

    name: str = Field(min_length=1)
    points: list[str] | None = None
    """Operating points by name; all of them if omitted."""
    variants: list[str] = Field(default_factory=list)
    """Variants by name; the vehicle as it is if omitted."""
    boxes: list[str] = Field(default_factory=list)
    """Boxes by which ``box`` is replaced in turn."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Parameters of the vehicle; a list gives one case per value."""
    damaged: dict[str, FaultClass] = Field(default_factory=dict)
    """Correct verdict of each box that is not healthy."""
    required: bool = True
    tags: dict[str, str] = Field(default_factory=dict)


class VehicleExamFile(Group):
    """An exam of a vehicle as written in its file."""

    exam: str
    vehicle: str
    """Vehicle on which the scenarios are based, a shipped name or a file."""
    about: str = ""
    duration: float = quantity(3.0, "s", "Simulated time of a scenario", 2.5, 1e3)
    seed: int | None = Field(None, ge=0, le=SEEDS)
    """Seed from which every vehicle draws its `DRAWN` seeds, unless the exam gives them; without one, they are those of its file."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Parameters of all scenarios."""
    points: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Parameters by operating point."""
    variants: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Parameters by variant, such as the cross-talk."""
    criteria: Criteria = Criteria()
    seal: str = choice("", "Hash published before a sealed exam")
    scenarios: list[VehicleEntry]


@dataclass(frozen=True)
class VehicleCase:
    """A vehicle of the exam, and the correct verdicts."""

    name: str
    parameters: Mapping[str, Any]
    """Parameters of the vehicle by dotted keys."""
    duration: float
    """[s]"""
    damaged: Mapping[str, str]
    """Correct verdict by box, of boxes that are not healthy."""
    required: bool = True
    tags: Mapping[str, str] = field(default_factory=dict)

    @property
    def journey(self) -> Journey:
        """How the vehicle runs, without reading its boxes.

        Raises:
            Refusal: a parameter of this group is invalid.
        """
        prefix = "vehicle."
        given = {key.removeprefix(prefix): value for key, value in self.parameters.items() if key.startswith(prefix)}
        return validated(as_floats(given, Journey), Journey, f"scenario '{self.name}', vehicle")

    def vehicle(self) -> Vehicle:
        """Return the vehicle.

        Raises:
            Refusal: its parameters are invalid.
        """
        return vehicle_of(self.parameters, f"scenario '{self.name}'")


@dataclass(frozen=True)
class VehicleExam:
    """An exam of a vehicle expanded into cases."""

    name: str
    about: str
    criteria: Criteria
    cases: tuple[VehicleCase, ...]
    seal: str = ""

    @property
    def digest(self) -> str:
        """SHA-256 of all cases, with everything that their parameters resolve to; names and order do not enter it."""
        cases = sorted(canonical([dict(case.parameters), case.duration, dict(case.damaged), case.required]) for case in self.cases)
        return hashlib.sha256(canonical([cases, resolved(case.parameters for case in self.cases)]).encode()).hexdigest()

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of the vehicles in increasing order."""
        return tuple(sorted({case.journey.seed for case in self.cases}))


def resolved(vehicles: Iterable[Mapping[str, Any]]) -> list[Any]:
    """Return what the samples of vehicles depend on beside their parameters: the configuration of each bench by name, and the defaults.

    Raises:
        Refusal: a bench is invalid.
    """
    given = ({"vehicle.bench": Journey().bench, **parameters} for parameters in vehicles)
    benches = sorted({str(value) for parameters in given for key, value in parameters.items() if key.endswith(".bench")})
    groups: dict[str, type[Group]] = {**GROUPS, **DRIVE, "wheel": Wheel}
    defaults = {name: group().model_dump() for name, group in groups.items()}
    return [{bench: load_configuration(bench).model_dump() for bench in benches}, defaults]


def read_vehicle_exam(source: str | Path) -> VehicleExam:
    """Return the exam given by a file or by a shipped name.

    Raises:
        Refusal: there is no such exam, it has an unknown key, or one of its scenarios is invalid.
    """
    return vehicle_exam_of(read_yaml(find_shipped("exam", source)), str(source))


def vehicle_exam_of(tree: Any, source: str) -> VehicleExam:
    """Return the exam described by a tree read from YAML; see `read_vehicle_exam`."""
    try:
        file = VehicleExamFile.model_validate(tree)
    except ValidationError as error:
        problem = first_problem(error)
        raise Refusal(f"{source}: {problem.key or 'the file'}: {problem.reason}") from None
    base = read_parameters(file.vehicle)
    cases: list[VehicleCase] = []
    curved: dict[str, bool] = {}
    for entry in file.scenarios:
        for case in _cases(file, entry, base, source, curved):
            cases.append(case)
            if len(cases) > MOST_CASES:
                raise Refusal(f"{source} defines more than {MOST_CASES} scenarios: leave out variations")
    if (twice := repeated(case.name for case in cases)) is not None:
        raise Refusal(f"{source}: two scenarios are called '{twice}': give them different names")
    if not cases:
        raise Refusal(f"{source} defines no scenario: give at least one")
    straight = next((place for place, has_curve in curved.items() if not has_curve), None)
    if straight is not None:
        raise Refusal(f"{straight}: {CANT} has no effect on straight track: give {CURVATURE} with it, or leave it out")
    return VehicleExam(file.exam, file.about, file.criteria, tuple(cases), file.seal)


def _cases(
    file: VehicleExamFile, entry: VehicleEntry, base: Mapping[str, Any], source: str, curved: dict[str, bool]
) -> Iterator[VehicleCase]:
    """Yield the cases of an entry; ``curved`` takes up, by the place that gives a cant, whether a case with this cant has a curve."""
    where, changes = f"{source}, scenario '{entry.name}'", flatten(entry.set)
    _check_entry(file, entry, changes, where)
    varied = {key: value for key, value in changes.items() if isinstance(value, list)}
    checked: set[object] = set()
    for point, variant, box, values in itertools.product(
        (entry.points if entry.points is not None else [*file.points]) or [""],
        entry.variants or [""],
        entry.boxes or [""],
        itertools.product(*varied.values()),
    ):
        chosen = {**changes, **dict(zip(varied, values, strict=True))}
        own = {_placed(key, box, where): value for key, value in chosen.items()}
        words = [entry.name, point, box, variant, *(f"{key.rpartition('.')[2]}={value}" for key, value in zip(varied, values, strict=True))]
        name = "/".join(filter(None, words))
        drawn = {key: seed_of(file.seed, name, key) for key in DRAWN} if file.seed is not None else {}
        layers = (base, drawn, flatten(file.set), flatten(file.points.get(point, {})), flatten(file.variants.get(variant, {})), own)
        refuse_ineffective((key for layer in layers[1:] for key in layer), where)
        parameters = {key: value for layer in layers for key, value in layer.items()}
        places = (f"{source}, set", f"{source}, points, {point}", f"{source}, variants, {variant}", where)
        for place in (place for place, layer in zip(places, layers[2:], strict=True) if layer.get(CANT)):
            curved[place] = curved.get(place, False) or parameters.get(CURVATURE, 0.0) != 0.0
        damaged = {_placed(key, box, where): verdict for key, verdict in entry.damaged.items() if verdict != "healthy"}
        tags = {**({"point": point} if point else {}), **({"variant": variant} if variant else {}), "kind": entry.name, **entry.tags}
        case = VehicleCase(name, parameters, file.duration, damaged, entry.required, tags)
        # The other values are checked when the vehicle is simulated.
        about: set[object] = {
            (point, variant),
            canonical([damaged, [[key, str(value)] for key, value in own.items() if CHECKED.search(key)]]),
        }
        if not about <= checked:
            checked |= about
            _check_verdicts(case, where)
        yield case


def _check_entry(file: VehicleExamFile, entry: VehicleEntry, changes: Mapping[str, Any], where: str) -> None:
    """Refuse unknown points and variants, empty lists, and options without effect."""
    for kind, given, known in (("operating point", entry.points or [], file.points), ("variant", entry.variants, file.variants)):
        unknown = next((name for name in given if name not in known), None)
        if unknown is not None:
            raise Refusal(f"{where}: there is no {kind} '{unknown}'{nearest(unknown, known)}")
    empty = next((key for key, value in changes.items() if value == []), None)
    if empty is not None:
        raise Refusal(f"{where}: {empty} has an empty list: give at least one value")
    if entry.boxes and not any(key.partition(".")[0] == PLACEHOLDER for key in (*changes, *entry.damaged)):
        raise Refusal(
            f"{where}: boxes has no effect without a key of 'box', such as box.bench: give one in set or damaged, or leave it out"
        )
    if not entry.required and all(verdict == "healthy" for verdict in entry.damaged.values()):
        raise Refusal(f"{where}: required = false has no effect on healthy boxes, where nothing is to be detected: leave it out")


def _check_verdicts(case: VehicleCase, where: str) -> None:
    """Refuse an invalid vehicle, gaps, verdicts on boxes that it lacks, and verdicts that the faults of its boxes contradict."""
    boxes = {box.name: box for box in case.vehicle().boxes}
    stranger = next((name for name in case.damaged if name not in boxes), None)
    if stranger is not None:
        raise Refusal(f"{where}: damaged names the box '{stranger}'{nearest(stranger, boxes)} (known: {', '.join(boxes)})")
    for box in boxes.values():
        publishing = box.configuration.publishing
        for key in ("loss_probability", "burst_period"):
            if value := getattr(publishing, key):
                raise Refusal(
                    f"{where}: publishing.{key} = {value:g} causes gaps, which the exam of a vehicle does not simulate: set it to 0"
                )
        verdict, correct = case.damaged.get(box.name, "healthy"), class_of(box.configuration.described_faults())
        if contradicts(verdict, [correct]):
            raise Refusal(
                f"{where}: damaged gives {box.name} the verdict {verdict}, which contradicts its faults, which make {correct} correct: "
                f"change damaged, or the faults of {box.name}"
            )


def _placed(key: str, box: str, where: str) -> str:
    """Return a key with a box in the place of ``box``."""
    first, dot, rest = key.partition(".")
    if first != PLACEHOLDER:
        return key
    if not box:
        raise Refusal(f"{where}: '{key}' names no box: give boxes, such as [axle_1.left]")
    return f"{box}{dot}{rest}"
