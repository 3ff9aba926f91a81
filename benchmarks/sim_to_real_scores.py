"""Classifier, rules and scores of the experiment: macro AUROC with bounds of a bootstrap over recordings."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import rankdata
from sim_to_real_data import CLASSES, Windows
from sklearn.ensemble import RandomForestClassifier

from dcrb_ros.schema.arrays import Floats

LEVELS = re.compile(r"y_level_")
ABSOLUTE = ("y_rms", "y_peak")
"""Features that depend on the gain; they are left out."""
FAMILIES = {"outer_ring": "BPFO", "inner_ring": "BPFI", "roller": "2BSF"}
BOOTSTRAPS = 500
BOUNDS = (5.0, 95.0)
"""Percentiles of the bootstrap."""


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
    found = windows.values[:, kept]
    if levels:
        relative = windows.values[:, band] - windows.values[:, band].mean(axis=1, keepdims=True)
        found = np.concatenate([found, relative], axis=1)
    return found


def forest_scores(train: Windows, test: Windows, levels: bool, seed: int = 1) -> Floats:
    """Return the probability of each of `CLASSES` for each window; zero of a class that the training set does not have."""
    forest = RandomForestClassifier(500, min_samples_leaf=2, class_weight="balanced", random_state=seed)
    forest.fit(gain_free(train, levels), train.truth)
    probability = forest.predict_proba(gain_free(test, levels))
    found = np.zeros((len(probability), len(CLASSES)))
    for k, name in enumerate(forest.classes_):
        found[:, CLASSES.index(name)] = probability[:, k]
    return found


def rule_scores(test: Windows) -> Floats:
    """Return scores without learning: the depth of the lines of each family in the squared envelope, of the deeper of both bands.

    A class scores its depth above the deepest of the other families, and healthy how shallow the deepest is.
    """
    depth = {
        fault: np.maximum(*(test.values[:, test.names.index(f"y_{band}_{line}_depth")] for band in ("wide", "impulsive")))
        for fault, line in FAMILIES.items()
    }
    found = np.zeros((len(test.values), len(CLASSES)))
    for fault, own in depth.items():
        others = np.max([other for name, other in depth.items() if name != fault], axis=0)
        found[:, CLASSES.index(fault)] = own - others
    found[:, CLASSES.index("healthy")] = -np.max(list(depth.values()), axis=0)
    return found


def scored(scores: Floats, test: Windows, seed: int = 1) -> Score:
    """Return the macro AUROC over the classes that the test set has, with bounds.

    The bootstrap draws recordings within each class, since the windows of one recording are alike.
    """
    truth, names = np.array(test.truth), np.array(test.recording)
    present = [name for name in CLASSES if (truth == name).any()]
    rows = {one: np.flatnonzero(names == one) for one in dict.fromkeys(test.recording)}
    by_class = {fault: [one for one, at in rows.items() if truth[at[0]] == fault] for fault in present}
    random, drawn = np.random.default_rng(seed), []
    for _ in range(BOOTSTRAPS):
        chosen = [one for fault in present for one in random.choice(by_class[fault], len(by_class[fault]))]
        drawn.append(np.mean(list(_areas(scores, truth, np.concatenate([rows[one] for one in chosen]), present).values())))
    areas = _areas(scores, truth, np.arange(len(truth)), present)
    low, high = np.percentile(drawn, BOUNDS)
    return Score(float(np.mean(list(areas.values()))), float(low), float(high), areas)


def _areas(scores: Floats, truth: npt.NDArray[np.str_], at: npt.NDArray[np.int64], present: list[str]) -> dict[str, float]:
    return {name: area(scores[at, CLASSES.index(name)], truth[at] == name) for name in present}


def area(score: Floats, positive: npt.NDArray[np.bool_]) -> float:
    """Return the area under the ROC curve [-], from the rank sum (Hanley and McNeil 1982, Radiology 143(1), 29-36)."""
    found, count = rankdata(score), int(positive.sum())
    return float((found[positive].sum() - 0.5 * count * (count + 1)) / (count * (len(score) - count)))
