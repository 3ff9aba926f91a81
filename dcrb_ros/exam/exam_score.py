"""The exam score, 0 to 100, with its bootstrap interval, and the difference of two detectors.

The score is the credit for faults, times a factor for false alarms and silence.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.stats import chi2

from dcrb_ros.exam.credit import Credit
from dcrb_ros.exam.profile import PROFILES, Profile
from dcrb_ros.exam.statistics import CONFIDENCE, Interval, class_mean
from dcrb_ros.schema.arrays import Floats

RESAMPLES = 2000
"""Bootstrap samples of the scenarios [-]."""
SEED = 22
"""Seed of the bootstrap; the same scenarios are drawn for every detector, so that detectors are compared in pairs."""
DECIMALS = 6
"""Decimals to which scores are given, so that they agree on all machines."""


@dataclass(frozen=True)
class Contribution:
    """A scenario in the exam score."""

    name: str
    family: str
    """Correct verdict."""
    credit: Credit


@dataclass(frozen=True)
class ExamScore:
    """The exam score for one profile."""

    profile: str
    score: Interval
    """0 .. 100 [-]."""
    detection: float
    """Credit for the faults, mean over the families, 0 .. 1 [-]."""
    clean: float
    """Factor for false alarms and silence before the exponent of the profile, 0 .. 1 [-]."""


def upper_bound(count: Floats | float) -> Any:
    """Return the upper limit of the expectation of a Poisson number, one-sided at 95 % confidence (Garwood 1936) [-]."""
    return 0.5 * chi2.ppf(CONFIDENCE, 2.0 * np.asarray(count) + 2.0)


def clean_factor(failed: Floats | float, periods: Floats | float) -> Any:
    """Return F = 1 - ln(u(k) / u(0)) / ln(u(K) / u(0)) for k failed of K healthy periods, u being `upper_bound` [-].

    Both u(k) and u(0) divided by the healthy time are rates: what the exam shows, and the lowest that it could show.
    """
    least = upper_bound(0.0)
    return 1.0 - np.log(upper_bound(failed) / least) / np.log(upper_bound(periods) / least)


def exam_scores(contributions: Sequence[Contribution]) -> list[ExamScore]:
    """Return the exam score for every profile; none without both a fault and healthy time."""
    if all(c.family == "healthy" for c in contributions) or not sum(c.credit.periods for c in contributions):
        return []
    whole, samples = np.ones((1, len(contributions))), draws(contributions)
    return [_exam_score(contributions, profile, whole, samples) for profile in PROFILES]


def _exam_score(contributions: Sequence[Contribution], profile: Profile, whole: Floats, samples: Floats) -> ExamScore:
    detection, clean = _parts(contributions, profile, whole)
    score = 100.0 * detection[0] * clean[0] ** profile.alarms
    known = several_of_each(contribution.family for contribution in contributions)
    low, high = interval(scores(contributions, profile, samples)) if known else (0.0, 100.0)
    rounded = [round(float(value), DECIMALS) for value in (score, low, high, detection[0], clean[0])]
    return ExamScore(profile.name, Interval(*rounded[:3]), *rounded[3:])


def scores(contributions: Sequence[Contribution], profile: Profile, samples: Floats) -> Floats:
    """Return the exam score of every sample; ``samples`` has shape (samples, scenarios) and weighs the scenarios."""
    detection, clean = _parts(contributions, profile, samples)
    return np.asarray(100.0 * detection * clean**profile.alarms)


def several_of_each(families: Iterable[str]) -> bool:
    """Return whether every family has several scenarios; one alone says nothing about others of its kind."""
    return all(count > 1 for count in Counter(families).values())


def interval(values: Floats) -> tuple[float, float]:
    """Return the percentile interval of bootstrap values at `CONFIDENCE`."""
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(values, [tail, 100.0 - tail])
    return float(low), float(high)


def draws(contributions: Sequence[Contribution], seed: int = SEED) -> Floats:
    """Return the weight of each scenario in each bootstrap sample, shape (`RESAMPLES`, scenarios).

    Scenarios are drawn with replacement within their family, so that every sample has faults of all families and healthy time. The array
    cannot be written, because later calls return it again.
    """
    return _drawn(tuple(map(tuple, _grouped(contributions).values())), seed)


@lru_cache(maxsize=4)
def _drawn(groups: tuple[tuple[int, ...], ...], seed: int) -> Floats:
    """Return the weights for the positions of the scenarios of each family; a leaderboard takes the same ones for every pair of entries."""
    counts = np.zeros((RESAMPLES, sum(map(len, groups))))
    for number, members in enumerate(groups):
        random = np.random.default_rng([seed, number, len(members)])
        # One draw fewer than scenarios, each with more weight: otherwise the variance is (n - 1)/n of the true one (Rao and Wu 1988).
        drawn = max(1, len(members) - 1)
        chosen = random.integers(0, len(members), (RESAMPLES, drawn))
        positions = chosen + len(members) * np.arange(RESAMPLES)[:, None]
        times = np.bincount(positions.ravel(), minlength=RESAMPLES * len(members)).reshape(RESAMPLES, len(members))
        counts[:, list(members)] = times * (len(members) / drawn)
    counts.flags.writeable = False
    return counts


def _parts(contributions: Sequence[Contribution], profile: Profile, samples: Floats) -> tuple[Floats, Floats]:
    """Return the credit for the faults and the factor for false alarms and silence of every sample."""
    faulty = [position for position, contribution in enumerate(contributions) if contribution.family != "healthy"]
    credits = np.array([[contributions[position].credit.detection[profile.name] for position in faulty]])
    detection = class_mean(credits, [contributions[position].family for position in faulty], samples[:, faulty].T)[0]
    periods = samples @ np.array([float(contribution.credit.periods) for contribution in contributions])
    failed = samples @ np.array([float(contribution.credit.failed) for contribution in contributions])
    clean = np.where(periods > 0.0, clean_factor(failed, np.maximum(periods, 1.0)), 1.0)
    return detection, np.clip(clean, 0.0, 1.0)


def _grouped(contributions: Sequence[Contribution]) -> Mapping[str, list[int]]:
    """Return the positions of the scenarios by family, families and names in alphabetical order."""
    groups: dict[str, list[int]] = {}
    for position, contribution in sorted(enumerate(contributions), key=lambda item: (item[1].family, item[1].name)):
        groups.setdefault(contribution.family, []).append(position)
    return groups


@dataclass(frozen=True)
class ScoreDifference:
    """The difference of the exam scores of two detectors."""

    low: float
    high: float
    """Bootstrap interval of the score of the first minus that of the second [-]."""
    confidence: float
    """Share of the bootstrap samples in which the first is better; ties count one half [-]."""

    @property
    def distinguished(self) -> bool:
        """Whether the interval of the difference excludes 0."""
        return self.low > 0.0 or self.high < 0.0
