"""The twins of an exam's faulty cases: the same runs without the fault."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from dcrb_ros.exam.case import Case, CaseSimulation, canonical, derived_tags
from dcrb_ros.exam.expectation import Expectation


def _without_fault(case: Case) -> Mapping[str, Any] | None:
    """Return the timeline of a case's twin."""
    entries = list((case.simulation.scenario or {"timeline": []})["timeline"])[:-1]
    return {"timeline": entries} if entries else None


class _TwinNames:
    """Unused names for twins, based on the operating point."""

    def __init__(self, taken: Iterable[str]) -> None:
        self._taken, self._counts = set(taken), Counter[str]()

    def next(self, case: Case) -> str:
        """Return a name for a case's twin: twin/POINT, twin/POINT-2 and so on."""
        point = case.expectation.tags.get("point")
        name = f"twin/{point}" if point else "twin"
        while True:
            self._counts[name] += 1
            numbered = name if self._counts[name] == 1 else f"{name}-{self._counts[name]}"
            if numbered not in self._taken:
                return numbered


def with_twins(cases: Sequence[Case]) -> Iterator[Case]:
    """Yield the cases, then their twins: the same runs without fault, one for each operating point and seed."""
    twins: dict[str, Case] = {}
    names = _TwinNames(case.expectation.name for case in cases)
    for case in cases:
        if not case.expectation.twin:
            yield case
            continue
        scenario = _without_fault(case)
        key = canonical([case.simulation.configuration.model_dump(), scenario])
        known = twins.get(key)
        duration = max(case.simulation.duration, known.simulation.duration if known else 0.0)
        name = known.expectation.name if known else names.next(case)
        point = {"point": case.expectation.tags["point"]} if "point" in case.expectation.tags else {}
        tags = {**derived_tags(case.simulation.configuration, {}), **point}
        twin = Expectation(name, "healthy", duration, 0.0, tags, speeds=case.expectation.speeds)
        twins[key] = Case(twin, CaseSimulation(case.simulation.configuration, scenario, duration))
        yield replace(case, expectation=replace(case.expectation, twin=name))
    yield from twins.values()
