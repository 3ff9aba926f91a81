"""Two detectors on the same scenarios: whether one is better, and with what confidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dcrb_ros.exam.exam_score import DECIMALS, Contribution, draws, interval, scores
from dcrb_ros.exam.profile import Profile
from dcrb_ros.exam.statistics import Interval
from dcrb_ros.schema.refusal import Refusal


@dataclass(frozen=True)
class Comparison:
    """The difference of the exam scores of two detectors."""

    difference: Interval
    """Score of the first minus that of the second, with its bootstrap interval [-]."""
    confidence: float
    """Share of the bootstrap samples in which the first is better; ties count one half [-]."""

    @property
    def distinguished(self) -> bool:
        """Whether the interval of the difference excludes 0."""
        return self.difference.low > 0.0 or self.difference.high < 0.0


def compare(first: Sequence[Contribution], second: Sequence[Contribution], profile: Profile) -> Comparison:
    """Return the comparison of two detectors by a paired bootstrap: both are judged on the same scenarios in every sample.

    Raises:
        Refusal: they were not evaluated on the same scenarios.
    """
    first, second = (sorted(contributions, key=lambda contribution: contribution.name) for contributions in (first, second))
    if [(c.name, c.family, c.credit.periods) for c in first] != [(c.name, c.family, c.credit.periods) for c in second]:
        raise Refusal("the detectors were evaluated on different scenarios: compare entries of one exam")
    whole, samples = np.ones((1, len(first))), draws(first)
    value = float((scores(first, profile, whole) - scores(second, profile, whole))[0])
    differences = np.round(scores(first, profile, samples) - scores(second, profile, samples), DECIMALS)
    families = [contribution.family for contribution in first]
    known = all(families.count(family) > 1 for family in set(families))
    low, high = interval(differences) if known else (-100.0, 100.0)
    confidence = float(np.mean(differences > 0.0) + 0.5 * np.mean(differences == 0.0)) if known else 0.5
    return Comparison(Interval(round(value, DECIMALS), low, high), confidence)
