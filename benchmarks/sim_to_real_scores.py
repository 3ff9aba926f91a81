"""Scores of the experiment: macro AUROC with bounds of a bootstrap over recordings, and the gaps between simulated and measured windows."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import rankdata
from sim_to_real_data import CLASSES, Windows
from sklearn.ensemble import RandomForestClassifier

from dcrb_ros.exam.statistics import Interval
from dcrb_ros.schema.arrays import Floats

LEVELS = re.compile(r"y_level_")
ABSOLUTE = ("y_rms", "y_peak")
"""Features that depend on the gain; they are left out."""
FAMILIES = {"outer_ring": "BPFO", "inner_ring": "BPFI", "roller": "2BSF"}
LOAD = re.compile(r"(at\d+)?_\d+$")
"""The suffix of a recording's name after the bearing: position of the spall, load or speed."""
BOOTSTRAPS = 500
BOUNDS = (5.0, 95.0)
"""Percentiles of the bootstrap."""
MATCH = (5.0, 95.0)
"""Percentiles of the simulated healthy windows between which the median of the measured healthy ones must lie."""
TREES = 500
PAIRS, PAIR_TREES = 30, 200
"""Draws of machines and recordings for the bounds of a difference, and trees of each forest."""


class Score(NamedTuple):
    """Macro AUROC."""

    macro: float
    low: float
    high: float
    classes: dict[str, float]
    """AUROC of each class against all others."""


def gain_free(windows: Windows, levels: bool) -> Floats:
    """Return the features that do not depend on the gain: levels of bands relative to their mean, or none, and no rms and peak."""
    band = np.array([bool(LEVELS.match(name)) for name in windows.names])
    kept = np.array([name not in ABSOLUTE for name in windows.names]) & ~band
    values = windows.values[:, kept]
    if levels:
        relative = windows.values[:, band] - windows.values[:, band].mean(axis=1, keepdims=True)
        values = np.concatenate([values, relative], axis=1)
    return values


class Features(NamedTuple):
    """Features of training and test windows, in the same columns."""

    train: Floats
    test: Floats


def chosen(train: Windows, test: Windows, levels: bool, healthy: Windows | None = None) -> Features:
    """Return the features that do not depend on the gain; with ``healthy`` only those that match.

    A feature matches if the median of the measured healthy windows lies between the `MATCH` percentiles of those of the training set.
    """
    features = Features(gain_free(train, levels), gain_free(test, levels))
    if healthy is None:
        return features
    low, high = np.percentile(features.train[np.array(train.truth) == "healthy"], MATCH, axis=0)
    middle = np.median(gain_free(healthy, levels), axis=0)
    kept = (low <= middle) & (middle <= high)
    return Features(features.train[:, kept], features.test[:, kept])


def forest_scores(truth: Sequence[str], given: Features, seed: int = 1, trees: int = TREES) -> Floats:
    """Return the probability of each of `CLASSES` for each test window; zero of a class that the training set does not have."""
    forest = RandomForestClassifier(trees, min_samples_leaf=2, class_weight="balanced", random_state=seed)
    forest.fit(given.train, truth)
    probability = forest.predict_proba(given.test)
    values = np.zeros((len(probability), len(CLASSES)))
    values[:, [CLASSES.index(name) for name in forest.classes_]] = probability
    return values


def left_out_scores(test: Windows, healthy: Windows, levels: bool) -> Floats:
    """Return the scores of a forest of the rig's own measured faults, each faulty bearing scored without its recordings.

    Windows of the tested healthy recordings have the mean of the scores of all forests.
    """
    bearing = np.array([LOAD.sub("", name) for name in test.recording])
    truth, values, known = np.array(test.truth), gain_free(test, levels), gain_free(healthy, levels)
    sound, scores = truth == "healthy", np.zeros((len(truth), len(CLASSES)))
    bearings = list(dict.fromkeys(bearing[~sound]))
    for name in bearings:
        train = ~sound & (bearing != name)
        without = forest_scores([*truth[train], *healthy.truth], Features(np.concatenate([values[train], known]), values))
        scores[bearing == name] = without[bearing == name]
        scores[sound] += without[sound] / len(bearings)
    return scores


def rule_scores(test: Windows) -> Floats:
    """Return scores without learning: the depth of the lines of each family in the squared envelope, of the deeper of both bands.

    A class scores its depth above the deepest of the other families, and healthy how shallow the deepest is.
    """
    depth = {
        fault: np.maximum(*(test.values[:, test.names.index(f"y_{band}_{line}_depth")] for band in ("wide", "impulsive")))
        for fault, line in FAMILIES.items()
    }
    values = np.zeros((len(test.values), len(CLASSES)))
    for fault, depths in depth.items():
        others = np.max([other for name, other in depth.items() if name != fault], axis=0)
        values[:, CLASSES.index(fault)] = depths - others
    values[:, CLASSES.index("healthy")] = -np.max(list(depth.values()), axis=0)
    return values


def scored(scores: Floats, test: Windows, seed: int = 1) -> Score:
    """Return the macro AUROC over the classes that the test set has, with bounds of a bootstrap over its recordings."""
    truth, random, present = np.array(test.truth), np.random.default_rng(seed), _present(test)
    drawn = [np.mean(list(_areas(scores, truth, _drawn_recordings(test, random), present).values())) for _ in range(BOOTSTRAPS)]
    areas = _areas(scores, truth, np.arange(len(truth)), present)
    low, high = np.percentile(drawn, BOUNDS)
    return Score(float(np.mean(list(areas.values()))), float(low), float(high), areas)


def gain(first: Windows, second: Windows, given: tuple[Features, Features], test: Windows, seed: int = 1) -> Interval:
    """Return how much better a training set is than another, with bounds of a bootstrap over the machines of both and the recordings."""
    random, truth, drawn = np.random.default_rng(seed), np.array(test.truth), []
    for _ in range(PAIRS):
        at = _drawn_recordings(test, random)
        both = []
        for windows, features in zip((first, second), given, strict=True):
            machines = _rows(windows.recording)
            rows = np.concatenate([machines[name] for name in random.choice(list(machines), len(machines))])
            given_rows = Features(features.train[rows], features.test)
            scores = forest_scores(np.array(windows.truth)[rows].tolist(), given_rows, int(random.integers(1 << 31)), PAIR_TREES)
            both.append(np.mean(list(_areas(scores, truth, at, _present(test)).values())))
        drawn.append(both[0] - both[1])
    low, high = np.percentile(drawn, BOUNDS)
    return Interval(float(np.mean(drawn)), float(low), float(high))


def _rows(recordings: Sequence[str]) -> dict[str, npt.NDArray[np.int64]]:
    names = np.array(recordings)
    return {name: np.flatnonzero(names == name) for name in dict.fromkeys(recordings)}


def _present(test: Windows) -> list[str]:
    return [name for name in CLASSES if name in test.truth]


def _drawn_recordings(test: Windows, random: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return the rows of recordings drawn within each class, since the windows of one recording are alike."""
    rows = _rows(test.recording)
    by_class = {fault: [name for name, at in rows.items() if test.truth[at[0]] == fault] for fault in _present(test)}
    return np.concatenate([rows[name] for names in by_class.values() for name in random.choice(names, len(names))])


def _areas(scores: Floats, truth: npt.NDArray[np.str_], at: npt.NDArray[np.int64], present: list[str]) -> dict[str, float]:
    return {name: area(scores[at, CLASSES.index(name)], truth[at] == name) for name in present}


def area(score: Floats, positive: npt.NDArray[np.bool_]) -> float:
    """Return the area under the ROC curve [-], from the rank sum (Hanley and McNeil 1982, Radiology 143(1), 29-36)."""
    ranks, count = rankdata(score), int(positive.sum())
    return float((ranks[positive].sum() - 0.5 * count * (count + 1)) / (count * (len(score) - count)))


class Gap(NamedTuple):
    """Mean over features of |2 AUROC - 1| for telling windows of a rig from others of a class: 0 if no feature can, 1 if each does."""

    rig: str
    training: str
    fault: str
    shape: float
    """Of the features without band levels [-]."""
    level: float
    """Of the levels of third octaves relative to their mean [-]."""


def gaps_of(rig: str, trainings: Mapping[str, Windows], test: Windows, healthy: Windows) -> list[Gap]:
    """Return the gaps of each class that a training has; the measured healthy windows are those that calibrate."""
    truth, values, count = np.array(test.truth), gain_free(test, True), gain_free(test, False).shape[1]
    gaps = []
    for training, windows in trainings.items():
        simulated, its_truth = gain_free(windows, True), np.array(windows.truth)
        for fault in (name for name in CLASSES if name in test.truth and name in its_truth):
            measured = gain_free(healthy, True) if fault == "healthy" else values[truth == fault]
            apart = separations(measured, simulated[its_truth == fault])
            gaps.append(Gap(rig, training, fault, float(apart[:count].mean()), float(apart[count:].mean())))
    return gaps


def separations(first: Floats, second: Floats) -> Floats:
    """Return |2 AUROC - 1| of each feature for telling two sets of windows apart, shape (features,)."""
    positive = np.arange(len(first) + len(second)) < len(first)
    return np.abs([2.0 * area(column, positive) - 1.0 for column in np.concatenate([first, second]).T])
