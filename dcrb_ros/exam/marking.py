"""The mark by which entries of an exam are sorted: the exam score or, in a replica, the share of correct last verdicts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from dcrb_ros.exam.exam_score import DECIMALS, SEED, ScoreDifference, draws, interval, scores, several_of_each
from dcrb_ros.exam.leaderboard_entry import Entry, EntryScenario, entry_of
from dcrb_ros.exam.profile import HEADLINE, HEADLINE_PROFILE, PROFILES
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.statistics import CONFIDENCE, Interval, class_mean
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import FAULT_CLASSES


class ScoreMarking:
    """The exam score; see `dcrb_ros.exam.exam_score`."""

    name, caption, unit = "exam score", "Exam scores", "-"
    about = f"Exam scores of 100 with {CONFIDENCE:.0%} bootstrap intervals; sorted by {HEADLINE}"

    def heads(self, entries: Sequence[Entry]) -> tuple[str, ...]:
        """Return profiles, area and counts."""
        return (*(profile.name for profile in PROFILES), "ROC areas", "detected", "failed periods")

    def cells(self, entry: Entry, heads: Sequence[str]) -> tuple[str, ...]:
        """Return the cells of an entry in these columns."""
        faulty = [scenario for scenario in entry.scenarios if scenario.family != "healthy"]
        return (
            *(_cell(score) for score in self.series(entry).values()),
            "–" if entry.area is None or math.isnan(entry.area) else f"{entry.area:.3f}",
            f"{sum(scenario.found for scenario in faulty)} of {len(faulty)}",
            f"{sum(scenario.spoiled for scenario in entry.scenarios)} of {sum(scenario.periods for scenario in entry.scenarios)}",
        )

    def series(self, entry: Entry) -> Mapping[str, Interval]:
        """Return the scores of the profiles."""
        return {score.profile: score.score for score in entry.scores()}

    def mark(self, entry: Entry) -> float:
        """Return the score of the profile `HEADLINE`."""
        return self.series(entry)[HEADLINE].value

    def samples(self, entry: Entry, seed: int = SEED) -> Floats:
        """Return this score in bootstrap samples of the scenarios, which are the same for every entry and ``seed``."""
        contributions = entry.contributions()
        return scores(contributions, HEADLINE_PROFILE, draws(contributions, seed))

    def scenarios(self, entry: Entry) -> list[tuple[Any, ...]]:
        """Return name, family and healthy periods of each scenario by name."""
        return sorted((scenario.name, scenario.family, scenario.periods) for scenario in entry.scenarios)


class VerdictMarking:
    """The share of correct verdicts in the required scenarios [%], mean over the classes."""

    name, caption, unit = "correct verdicts", "Correct verdicts", "%"
    about = (
        "Correct verdicts in the required scenarios, the mean over their classes, by which entries are sorted, with its "
        f"{CONFIDENCE:.0%} bootstrap interval; and the numbers of correct verdicts in all scenarios"
    )

    def heads(self, entries: Sequence[Entry]) -> tuple[str, ...]:
        """Return the mark and the classes."""
        families = {scenario.family for entry in entries for scenario in entry.scenarios}
        return ("correct [%]", *(family for family in FAULT_CLASSES if family in families))

    def cells(self, entry: Entry, heads: Sequence[str]) -> tuple[str, ...]:
        """Return the cells of an entry in these columns."""
        classes = ([scenario for scenario in entry.scenarios if scenario.family == family] for family in heads[1:])
        counts = (f"{sum(one.right for one in members)} of {len(members)}" for members in classes)
        return (_cell(self.series(entry)[self.name]), *counts)

    def series(self, entry: Entry) -> Mapping[str, Interval]:
        """Return the mark."""
        known = several_of_each(family for _, family in self.scenarios(entry))
        limits = interval(self.samples(entry)) if known else (0.0, 100.0)
        return {self.name: Interval(self.mark(entry), *limits)}

    def mark(self, entry: Entry) -> float:
        """Return the share of correct verdicts [%]."""
        # Equal shares of several classes can differ in the last bit, depending on the order of the classes.
        return round(float(_shares(entry, np.ones((1, len(_required(entry)))))[0]), DECIMALS)

    def samples(self, entry: Entry, seed: int = SEED) -> Floats:
        """Return this share in bootstrap samples, drawn within each class."""
        names = {scenario.name for scenario in _required(entry)}
        required = sorted((c for c in entry.contributions() if c.name in names), key=lambda c: c.name)
        return _shares(entry, draws(required, seed))

    def scenarios(self, entry: Entry) -> list[tuple[Any, ...]]:
        """Return name and class of each required scenario by name."""
        return [(scenario.name, scenario.family) for scenario in _required(entry)]


Marking: TypeAlias = ScoreMarking | VerdictMarking
"""How the entries of one exam are marked, 0 to 100."""


def marking_of(entry: Entry) -> Marking:
    """Return how the entries of the same exam are marked."""
    return VerdictMarking() if entry.last_verdict else ScoreMarking()


def compare(marking: Marking, first: Entry, second: Entry) -> ScoreDifference:
    """Return the difference of two marks by a paired bootstrap: both are judged on the same scenarios in every sample.

    Raises:
        Refusal: the entries have different scenarios.
    """
    scenarios = marking.scenarios(first)
    if scenarios != marking.scenarios(second):
        raise Refusal("the detectors were evaluated on different scenarios: compare entries of one exam")
    if not several_of_each(family for _, family, *_ in scenarios):
        return ScoreDifference(-100.0, 100.0, 0.5)
    differences = np.round(marking.samples(first) - marking.samples(second), DECIMALS)
    return ScoreDifference(*interval(differences), float(np.mean(differences > 0.0) + 0.5 * np.mean(differences == 0.0)))


def report_mark(report: Report) -> Interval:
    """Return the share of correct verdicts in a report of last verdicts [%]; NaN if no scenario is required."""
    if not any(result.expectation.required for result in report.results):
        return Interval(math.nan, 0.0, 100.0)
    marking = VerdictMarking()
    return marking.series(entry_of(report))[marking.name]


def _required(entry: Entry) -> list[EntryScenario]:
    """Return the required scenarios by name.

    Raises:
        Refusal: there is none.
    """
    required = sorted((scenario for scenario in entry.scenarios if scenario.required), key=lambda scenario: scenario.name)
    if not required:
        raise Refusal(f"the entry '{entry.detector}' of the exam {entry.exam} has no required scenario and so no share of correct verdicts")
    return required


def _shares(entry: Entry, weights: Floats) -> Floats:
    """Return the mean over the classes of the weighted share of correct verdicts [%]; ``weights`` has shape (samples, scenarios)."""
    required = _required(entry)
    right = np.array([[float(scenario.right) for scenario in required]])
    return np.asarray(100.0 * class_mean(right, [scenario.family for scenario in required], weights.T)[0], np.float64)


def _cell(mark: Interval) -> str:
    return f"{mark.value:.1f} ({mark.low:.1f} to {mark.high:.1f})"
