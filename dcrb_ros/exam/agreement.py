"""Do detectors rank alike in a simulated exam and on measured recordings? The rank correlation of two tables, with its interval.

Kendall's tau-b (Kendall 1945, "The treatment of ties in ranking problems") is 1 where both order all detectors alike, -1 where they order
them oppositely, and about 0 where they are independent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dcrb_ros.exam.correlation import kendall_tau, spearman_rho
from dcrb_ros.exam.exam_score import RESAMPLES, SEED, draws, headline_score, interval, scores
from dcrb_ros.exam.leaderboard_entry import Entry
from dcrb_ros.exam.profile import HEADLINE_PROFILE
from dcrb_ros.exam.statistics import Interval
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

FEWEST = 3
"""Detectors from which a rank correlation is computed [-]."""


@dataclass(frozen=True)
class Agreement:
    """The rank correlation between an exam and measured recordings."""

    detectors: tuple[str, ...]
    """In the order of their exam scores, the best one first."""
    exam: tuple[float, ...]
    """Exam score of each, 0 .. 100 [-]."""
    measured: tuple[float, ...]
    """Share of correct verdicts on the measured recordings of each, mean over the verdicts, 0 .. 1 [-]."""
    kendall: Interval
    """Kendall's tau-b [-]."""
    spearman: Interval
    """Spearman's rho [-]."""


def agreement(exam: Sequence[Entry], measured: Sequence[Entry]) -> Agreement:
    """Return the rank correlation of the entries of the same detectors in an exam and on measured recordings.

    The intervals come from a bootstrap over the scenarios of both.

    Raises:
        Refusal: there are fewer than three detectors in both, two entries of one detector, or entries with different scenarios.
    """
    first, second = _by_name(exam, "the exam"), _by_name(measured, "the measured recordings")
    common = [name for name in first if name in second]
    if len(common) < FEWEST:
        raise Refusal(
            f"{len(common)} detectors are in both folders ({', '.join(common) or 'none'}): "
            f"a rank correlation takes {FEWEST}, with the same --name in both"
        )
    values = {name: headline_score(first[name].scores()).score.value for name in common}
    ordered = sorted(common, key=lambda name: (-values[name], name))
    contributions = [first[name].contributions() for name in ordered]
    drawn = np.array([scores(shares, HEADLINE_PROFILE, draws(shares)) for shares in contributions])
    shares = [macro_recall(second[name]) for name in ordered]
    shares_drawn = np.array([_drawn_recall(second[name]) for name in ordered])
    at = np.array([[values[name]] for name in ordered]), np.array(shares)[:, None]
    return Agreement(
        tuple(ordered),
        tuple(float(values[name]) for name in ordered),
        tuple(shares),
        Interval(float(kendall_tau(*at)[0]), *interval(kendall_tau(drawn, shares_drawn))),
        Interval(float(spearman_rho(*at)[0]), *interval(spearman_rho(drawn, shares_drawn))),
    )


def macro_recall(entry: Entry) -> float:
    """Return the share of correct answers, mean over the correct verdicts of the required scenarios [-]."""
    return float(np.mean([np.mean(right) for right in _right(entry).values()]))


def _right(entry: Entry) -> Mapping[str, Floats]:
    """Return for each verdict, in alphabetical order, which required scenarios have the correct answer, 1 or 0."""
    answers: dict[str, list[float]] = {}
    for scenario in sorted(entry.scenarios, key=lambda scenario: (scenario.family, scenario.name)):
        if scenario.required:
            answers.setdefault(scenario.family, []).append(float(scenario.answer == scenario.family))
    return {family: np.array(right) for family, right in answers.items()}


def _drawn_recall(entry: Entry) -> Floats:
    """Return the macro recall of bootstrap samples, drawn within each verdict and alike for all detectors, shape (samples,)."""
    means = []
    for number, right in enumerate(_right(entry).values()):
        drawn = np.random.default_rng([SEED, number, len(right)]).integers(0, len(right), (RESAMPLES, len(right)))
        means.append(right[drawn].mean(axis=1))
    return np.asarray(np.mean(means, axis=0), np.float64)


def _by_name(entries: Sequence[Entry], where: str) -> dict[str, Entry]:
    by_name: dict[str, Entry] = {}
    for entry in entries:
        if entry.detector in by_name:
            raise Refusal(f"two entries of {where} are called '{entry.detector}': give them different names with --name")
        by_name[entry.detector] = entry
    several = sorted({entry.scenarios_sha256[:16] for entry in entries})
    if len(several) > 1:
        raise Refusal(f"the entries of {where} have {len(several)} sets of scenarios ({', '.join(several)}): compare entries of one set")
    return by_name
