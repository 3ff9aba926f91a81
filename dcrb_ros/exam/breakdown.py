"""The results of an exam taken apart: evidence without a threshold for each family, and strata by difficulty."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from statistics import harmonic_mean

from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.profile import HEADLINE
from dcrb_ros.exam.scoring import ScenarioResult
from dcrb_ros.exam.statistics import characteristic, partial_area
from dcrb_ros.schema.verdicts import BEARING_FAULTS

PARTIAL = 0.1
"""Largest false positive rate of the partial area [-]."""


@dataclass(frozen=True)
class FamilyArea:
    """How well the published scores separate the scenarios of one fault from the healthy ones."""

    verdict: str
    faulty: int
    """Scenarios with the fault [-]."""
    healthy: int
    """Healthy scenarios [-]."""
    area: float
    """Area under the receiver operating characteristic [-]."""
    partial: float | None
    """Area up to a false positive rate of `PARTIAL`, divided by it [-]; None with fewer than ten healthy scenarios."""


@dataclass(frozen=True)
class Stratum:
    """Scenarios of similar difficulty."""

    name: str
    scenarios: int
    """[-]"""
    found: int
    """Scenarios in which the fault was detected in time with the correct verdict [-]."""
    credit: float
    """Mean credit in the profile `HEADLINE` [-]."""


def family_areas(results: Sequence[ScenarioResult]) -> list[FamilyArea]:
    """Return the areas of every bearing fault; see `areas_of`."""
    return areas_of([(result.expectation.verdict, result.score) for result in results])


def compared_scores(
    scores: Sequence[tuple[str, float | None]], faults: Collection[str] = BEARING_FAULTS
) -> tuple[list[float], list[float]]:
    """Return the scores of the scenarios with some faults and of the healthy ones; see `areas_of`."""
    if all(score is None for verdict, score in scores if verdict != "sensor"):
        return [], []
    faulty = [-math.inf if score is None else score for verdict, score in scores if verdict in faults]
    return faulty, [math.inf if score is None else score for verdict, score in scores if verdict == "healthy"]


def areas_of(scores: Sequence[tuple[str, float | None]]) -> list[FamilyArea]:
    """Return the areas of every bearing fault from correct verdicts and scores; none if the detector publishes no score.

    A scenario without a score counts as the least convincing one: the lowest with a fault, the highest without. Silence gains nothing.
    """
    areas = []
    for family in BEARING_FAULTS:
        faulty, healthy = compared_scores(scores, (family,))
        curve = characteristic(faulty, healthy)
        if curve is not None:
            areas.append(FamilyArea(family, len(faulty), len(healthy), curve.area, partial_area(faulty, healthy, PARTIAL)))
    return areas


def overall_area(areas: Sequence[FamilyArea]) -> float:
    """Return the harmonic mean of the areas and partial areas of all families [-]; NaN if there are none."""
    values = [value for area in areas for value in (area.area, area.partial) if value is not None]
    return harmonic_mean(values) if values else math.nan


def strata(results: Sequence[ScenarioResult], criteria: Criteria) -> list[Stratum]:
    """Return the strata of the scenarios with a fault, in the order of `difficulty`."""
    groups: dict[tuple[int, str], list[ScenarioResult]] = {}
    for result in results:
        if result.expectation.faulty:
            groups.setdefault(difficulty(result.expectation, criteria), []).append(result)
    return [
        Stratum(
            name,
            len(group),
            sum(result.found for result in group),
            math.fsum(result.credit.detection.get(HEADLINE, 0.0) for result in group) / len(group),
        )
        for (_, name), group in sorted(groups.items())
    ]


def difficulty(expectation: Expectation, criteria: Criteria) -> tuple[int, str]:
    """Return rank and name of a scenario's stratum: its tag ``difficulty``, or else the width of its defect."""
    tag, smallest = expectation.tags.get("difficulty"), criteria.smallest_width
    if isinstance(tag, str):
        return 4, tag
    if expectation.width <= 0.0:
        return 3, "without a width"
    if expectation.width < smallest:
        return 0, f"below {smallest * 1e3:g} mm, not required"
    return (
        (1, f"{smallest * 1e3:g} to 2 x {smallest * 1e3:g} mm")
        if expectation.width < 2.0 * smallest
        else (2, f"from {2e3 * smallest:g} mm on")
    )
