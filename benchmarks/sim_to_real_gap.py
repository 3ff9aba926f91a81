"""How far simulated windows are from measured ones, class by class, before and after calibration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from sim_to_real_data import CLASSES, Windows
from sim_to_real_scores import area, gain_free

from dcrb_ros.schema.arrays import Floats


class Gap(NamedTuple):
    """Mean over features of |2 AUROC - 1| for telling measured from simulated windows of a class: 0 if no feature can, 1 if each does."""

    rig: str
    training: str
    fault: str
    shape: float
    """Of the features without band levels [-]."""
    level: float
    """Of the levels of third octaves relative to their mean [-]."""


def gaps_of(rig: str, trainings: Mapping[str, Windows], test: Windows, healthy: Windows) -> list[Gap]:
    """Return the gaps of each class; the measured healthy windows are those that calibrate."""
    truth, values, count = np.array(test.truth), gain_free(test, True), gain_free(test, False).shape[1]
    gaps = []
    for training, windows in trainings.items():
        simulated, its_truth = gain_free(windows, True), np.array(windows.truth)
        for fault in (name for name in CLASSES if name in test.truth):
            measured = gain_free(healthy, True) if fault == "healthy" else values[truth == fault]
            apart = separations(measured, simulated[its_truth == fault])
            gaps.append(Gap(rig, training, fault, float(apart[:count].mean()), float(apart[count:].mean())))
    return gaps


def separations(first: Floats, second: Floats) -> Floats:
    """Return |2 AUROC - 1| of each feature for telling two sets of windows apart, shape (features,)."""
    positive = np.arange(len(first) + len(second)) < len(first)
    return np.abs([2.0 * area(column, positive) - 1.0 for column in np.concatenate([first, second]).T])
