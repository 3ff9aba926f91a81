"""The twins of an exam's faulty cases: the same runs without the fault."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

from dcrb_ros.exam.case import Case, CaseSimulation, canonical, derived_tags
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.revolutions import speed_knots
from dcrb_ros.simulation.scenario import scheduled_changes


def with_twins(cases: Sequence[Case]) -> Iterator[Case]:
    """Yield the cases, then their twins: the same runs without fault, one for each operating point and seed."""
    twins: dict[str, Case] = {}
    taken, counts = {case.name for case in cases}, Counter[str]()
    for case in cases:
        if not case.expectation.twin:
            yield case
            continue
        entries = list((case.simulation.scenario or {"timeline": []})["timeline"])[:-1]
        scenario = {"timeline": entries} if entries else None
        key = canonical([case.simulation.configuration.model_dump(), scenario])
        known = twins.get(key)
        duration = max(case.simulation.duration, known.simulation.duration if known else 0.0)
        name = known.name if known else _unused(case.expectation.tags.get("point"), taken, counts)
        point = {"point": case.expectation.tags["point"]} if "point" in case.expectation.tags else {}
        tags = {**derived_tags(case.simulation.configuration, {}), **point}
        events = scheduled_changes(scenario, case.simulation.configuration, name) if scenario else []
        speeds = tuple(speed_knots(case.simulation.configuration, events))  # what appears with the fault may change the speed
        twin = Expectation(name, "healthy", duration, 0.0, tags, speeds=speeds)
        twins[key] = Case(twin, CaseSimulation(case.simulation.configuration, scenario, duration))
        yield replace(case, expectation=replace(case.expectation, twin=name))
    yield from twins.values()


def _unused(point: object, taken: set[str], counts: Counter[str]) -> str:
    """Return a name for a twin that is not taken, twin/POINT, twin/POINT-2 and so on; ``counts`` has the last number of each."""
    name = base = f"twin/{point}" if point else "twin"
    while name in taken:
        counts[base] += 1
        name = f"{base}-{counts[base] + 1}"
    taken.add(name)
    return name
