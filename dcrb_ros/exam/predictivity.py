"""How well an exam predicts the marks of detectors on measured recordings.

SRCC is Pearson's correlation (Kadian et al. 2020), MMRV the mean maximum rank violation (Li et al. 2024, SIMPLER).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.exam.correlation import kendall_tau, mean_maximum_rank_violation, pearson_r, spearman_rho
from dcrb_ros.exam.exam_score import interval
from dcrb_ros.exam.statistics import Interval, class_mean
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

RESAMPLES = 1000
"""Bootstrap samples of each interval [-]."""
SPLITS = 200
"""Splits of the measured recordings into halves [-]."""
SEED = 33
FEWEST = 3
"""Families from which on an order is compared [-]."""
STATISTICS: Mapping[str, Callable[[Floats, Floats], Floats]] = {
    "srcc": pearson_r,
    "rho": spearman_rho,
    "tau_b": kendall_tau,
    "mmrv": mean_maximum_rank_violation,
}
"""Functions of exam and field marks, shape (detectors, samples), by name."""
Indices = npt.NDArray[np.int64]


class Compared(NamedTuple):
    """A measured recording as both sides see it."""

    name: str
    machine: str
    truth: str
    bearing: str
    led: bool
    """Whether a healthy recording of the machine precedes it."""


@dataclass(frozen=True, eq=False)
class Marks:
    """The marks of detectors on both sides."""

    detectors: tuple[str, ...]
    families: tuple[str, ...]
    """Family of each detector."""
    published: tuple[bool, ...]
    """Whether a detector has the published settings of its family."""
    recordings: tuple[Compared, ...]
    field: Floats
    """1 where the last verdict on a measured recording is right, shape (detectors, recordings) [-]."""
    exam: Floats
    """Share of its counterparts on which it is right, shape (detectors, recordings) [-]."""

    @property
    def representatives(self) -> Marks:
        """The marks of the member with the published settings of each family."""
        detectors, families = (tuple(compress(names, self.published)) for names in (self.detectors, self.families))
        chosen = np.array(self.published)
        return Marks(detectors, families, (True,) * len(detectors), self.recordings, self.field[chosen], self.exam[chosen])


@dataclass(frozen=True)
class Statistic:
    """A statistic with its intervals and ceiling."""

    value: float
    bearings: Interval
    """Interval of a bootstrap over the bearings."""
    families: Interval
    """Interval of a bootstrap over the families of detectors."""
    ceiling: Interval
    """The same statistic between halves of the measured recordings, mean over the splits, and the range of 95 % of them; NaN if they
    cannot be divided."""


@dataclass(frozen=True)
class Predictivity:
    """How well the exam predicts the field in one scope."""

    scope: str
    """all, all with a healthy reference, a machine or a class."""
    detectors: int
    recordings: int
    statistics: Mapping[str, Statistic]


def scopes(recordings: Sequence[Compared]) -> Iterator[tuple[str, list[int]]]:
    """Yield the name of each scope and the positions of its recordings."""
    everything = list(range(len(recordings)))
    yield "all", everything
    led = {recording.machine for recording in recordings if recording.led}
    apart = [k for k in everything if recordings[k].machine in led]
    if 0 < len(apart) < len(everything):
        yield "machines with a healthy reference", apart
    for machine in sorted({recording.machine for recording in recordings}):
        members = [k for k in everything if recordings[k].machine == machine]
        if len(members) >= 2 * FEWEST:
            yield machine, members
    for truth in sorted({recording.truth for recording in recordings}):
        yield f"class {truth}", [k for k in everything if recordings[k].truth == truth]


def check_families(families: Iterable[str], left_out: Sequence[str] = ()) -> None:
    """Refuse fewer than three families of detectors; the sentence has the first reason why a detector is ``left_out``."""
    count = len(set(families))
    if count < FEWEST:
        because = f" ({len(left_out)} left out, such as {left_out[0]})" if left_out else ""
        few = "1 family of detectors is" if count == 1 else f"{count} families of detectors are"
        raise Refusal(f"{few} left{because}, but an order takes {FEWEST}: give a folder with more of them")


def predictivities(marks: Marks) -> list[Predictivity]:
    """Return how well the exam predicts the field in every scope.

    Raises:
        Refusal: there are fewer than three families of detectors.
    """
    check_families(marks.families)
    return [_predictivity(scope, marks, members) for scope, members in scopes(marks.recordings)]


def _predictivity(scope: str, marks: Marks, members: Sequence[int]) -> Predictivity:
    recordings = [marks.recordings[k] for k in members]
    truths = [recording.truth for recording in recordings]
    field, exam = marks.field[:, members], marks.exam[:, members]
    whole = np.ones((len(members), 1))
    here = class_mean(exam, truths, whole), class_mean(field, truths, whole)
    weights = drawn_bearings(recordings)
    drawn = class_mean(exam, truths, weights), class_mean(field, truths, weights)
    by_family = drawn_families(marks.families)
    first, second = halves(recordings)
    parts = class_mean(field, truths, first), class_mean(field, truths, second)
    statistics = {}
    for name, function in STATISTICS.items():
        value = float(function(*here)[0])
        resampled = np.array([function(here[0][chosen], here[1][chosen])[0] for chosen in by_family])
        ceiling = function(*parts) if parts[0].shape[1] else np.array([np.nan])
        statistics[name] = Statistic(
            value,
            Interval(value, *interval(function(*drawn))),
            Interval(value, *interval(resampled)),
            Interval(float(ceiling.mean()), *interval(ceiling)),
        )
    return Predictivity(scope, len(marks.detectors), len(members), statistics)


def _strata(recordings: Sequence[Compared]) -> Iterator[list[list[int]]]:
    """Yield the positions of the recordings of each bearing, for every machine and class.

    If all recordings of a machine and class are of one bearing, each counts as a bearing of its own.
    """
    for stratum in sorted({(recording.machine, recording.truth) for recording in recordings}):
        members = [k for k, recording in enumerate(recordings) if (recording.machine, recording.truth) == stratum]
        bearings = sorted({recordings[k].bearing for k in members})
        yield [[k for k in members if recordings[k].bearing == one] for one in bearings] if len(bearings) > 1 else [[k] for k in members]


def drawn_bearings(recordings: Sequence[Compared]) -> Floats:
    """Return the weights of the recordings in samples of the bearings of each machine and class, shape (recordings, `RESAMPLES`).

    Of n bearings, n are drawn with replacement. The variance is thus (n - 1)/n of the unbiased one, and 0 for a single recording.
    """
    random, weights = np.random.default_rng(SEED), np.zeros((len(recordings), RESAMPLES))
    for bearings in _strata(recordings):
        times = random.multinomial(len(bearings), np.full(len(bearings), 1.0 / len(bearings)), RESAMPLES)
        for number, members in enumerate(bearings):
            weights[members] = times[:, number]
    return weights


def drawn_families(families: Sequence[str]) -> list[Indices]:
    """Return the positions of the detectors in samples of their families: of n, n are drawn with replacement, each with all members."""
    random, names = np.random.default_rng(SEED + 1), sorted(set(families))
    members = [np.flatnonzero(np.array(families, dtype=object) == name) for name in names]
    return [np.concatenate([members[k] for k in random.integers(0, len(names), len(names))]) for _ in range(RESAMPLES)]


def halves(recordings: Sequence[Compared]) -> tuple[Floats, Floats]:
    """Return the weights of the recordings in both halves of splits of the bearings, each of shape (recordings, splits).

    A class that one half lacks counts in neither, so that both have the same task. Of `SPLITS` splits, those without a class are left out.
    """
    random, first = np.random.default_rng(SEED + 2), np.zeros((len(recordings), SPLITS))
    for bearings in _strata(recordings):
        for split in range(SPLITS):
            order = random.permutation(len(bearings))
            # The larger half of an odd number goes to either side.
            for k in order[: (len(bearings) + int(random.integers(2))) // 2]:
                first[bearings[k], split] = 1.0
    second = 1.0 - first
    for truth in {recording.truth for recording in recordings}:
        members = np.array([recording.truth == truth for recording in recordings])
        lacking = ~(first[members].any(axis=0) & second[members].any(axis=0))
        first[np.ix_(members, lacking)] = second[np.ix_(members, lacking)] = 0.0
    divided = first.any(axis=0)
    return first[:, divided], second[:, divided]
