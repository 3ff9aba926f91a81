"""Do detectors rank alike in a simulated exam and on measured recordings? The rank correlation of two tables, with its interval.

Kendall's tau-b (Kendall 1945, "The treatment of ties in ranking problems") is 1 where both order all detectors alike, -1 where they order
them oppositely, and about 0 where they are independent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dcrb_ros.exam.correlation import kendall_tau, spearman_rho
from dcrb_ros.exam.exam_score import interval, several_of_each
from dcrb_ros.exam.leaderboard_entry import Entry
from dcrb_ros.exam.marking import VerdictMarking, marking_of
from dcrb_ros.exam.statistics import Interval
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted

FIELD_SEED = 23
"""Seed of the samples of measured recordings, another one than that of the exam: both vary independently."""
FEWEST = 3
"""Detectors from which a rank correlation is computed [-]."""


@dataclass(frozen=True)
class Agreement:
    """The rank correlation between an exam and measured recordings."""

    detectors: tuple[str, ...]
    """In the order of their marks in the exam, the best one first."""
    exam: tuple[float, ...]
    """Mark of each in the exam, 0 .. 100 [-]; see `marking.Marking`."""
    measured: tuple[float, ...]
    """Share of correct verdicts of each on the measured recordings, mean over the classes [%]."""
    kendall: Interval
    """Kendall's tau-b [-]."""
    spearman: Interval
    """Spearman's rho [-]."""


def agreement(exam: Sequence[Entry], measured: Sequence[Entry]) -> Agreement:
    """Return the rank correlation of the entries of the same detectors in an exam and on measured recordings.

    The intervals come from a bootstrap over the scenarios of both; they are -1 to 1 if a class of one side has only one scenario.

    Raises:
        Refusal: there are fewer than three detectors in both, two entries of one detector, or entries with different scenarios.
    """
    first, second = by_name(exam, "the exam"), by_name(measured, "the measured recordings")
    common = [name for name in first if name in second]
    if len(common) < FEWEST:
        raise Refusal(
            f"the two folders have {counted(len(common), 'detector')} in common ({', '.join(common) or 'none'}): "
            f"a rank correlation takes {FEWEST}, with the same --name in both"
        )
    marking, field = marking_of(exam[0]), VerdictMarking()
    values = {name: marking.mark(first[name]) for name in common}
    ordered = sorted(common, key=lambda name: (-values[name], name))
    drawn = np.array([marking.samples(first[name]) for name in ordered])
    shares = [field.mark(second[name]) for name in ordered]
    shares_drawn = np.array([field.samples(second[name], FIELD_SEED) for name in ordered])
    at = np.array([[values[name]] for name in ordered]), np.array(shares)[:, None]
    sides = marking.scenarios(first[ordered[0]]), field.scenarios(second[ordered[0]])
    known = all(several_of_each(family for _, family, *_ in scenarios) for scenarios in sides)

    def correlation(statistic: Callable[[Floats, Floats], Floats]) -> Interval:
        limits = interval(statistic(drawn, shares_drawn)) if known else (-1.0, 1.0)
        return Interval(float(statistic(*at)[0]), *limits)

    return Agreement(
        tuple(ordered),
        tuple(float(values[name]) for name in ordered),
        tuple(shares),
        correlation(kendall_tau),
        correlation(spearman_rho),
    )


def by_name(entries: Sequence[Entry], where: str) -> dict[str, Entry]:
    """Return entries by the name of their detector; ``where`` names their scenarios.

    Raises:
        Refusal: two entries have the same name, or different scenarios or criteria.
    """
    named: dict[str, Entry] = {}
    for entry in entries:
        if entry.detector in named:
            raise Refusal(f"two entries of {where} are called '{entry.detector}': give them different names with --name")
        named[entry.detector] = entry
    several = sorted(name for name, _ in {_scenarios(entry) for entry in entries})
    if len(several) > 1:
        raise Refusal(f"the entries of {where} have {len(several)} sets of scenarios ({', '.join(several)}): compare entries of one set")
    criteria = sorted({entry.criteria_sha256[:16] for entry in entries} - {""})
    if len(criteria) > 1:
        raise Refusal(f"the entries of {where} have {len(criteria)} sets of criteria ({', '.join(criteria)}): compare entries of one set")
    return named


def _scenarios(entry: Entry) -> tuple[str, frozenset[tuple[str, str]]]:
    """Return the hash of an entry's scenarios; for recordings, which have none, their number, names and correct verdicts."""
    if entry.scenarios_sha256:
        return entry.scenarios_sha256[:16], frozenset()
    return f"{len(entry.scenarios)} recordings", frozenset((scenario.name, scenario.family) for scenario in entry.scenarios)
