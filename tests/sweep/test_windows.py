"""Labels of windows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.stream.block import Truth
from dcrb_ros.sweep.sweep_file import Windows
from dcrb_ros.sweep.windows import window_labels

RATE = 1000


def truth(time: float, speed: float, load: tuple[float, float], *faults: str) -> Truth:
    about = {name: {"width": 0.002, "onset": time} for name in faults}
    return Truth(round(1e9 * time), speed, load, {}, about)


def test_speed_and_load_are_those_at_the_first_sample() -> None:
    # The ground truth is given ten times a second; a run-up of 5 rad/s^2 under a load that falls by 10 kN/s.
    truths = [truth(0.1 * k, 5.0 + 0.5 * k, (3e4 - 3e3 * k, -4e4 + 4e3 * k)) for k in range(6)]
    labels = window_labels(np.array([0, 130, 260, 390, 520]), 30, RATE, Windows(length=100), truths)
    time = np.array([0.03, 0.16, 0.29, 0.42, 0.5])  # nothing is known after the last instant
    assert labels["speed"] == pytest.approx(5.0 + 5.0 * time)
    assert labels["load"] == pytest.approx(5e4 * (1.0 - time))
    assert labels["time"] == pytest.approx(0.03 + 0.13 * np.arange(5.0))


def test_a_window_has_the_faults_at_its_first_sample() -> None:
    truths = [truth(0.0, 1.0, (0.0, -1.0)), truth(0.15, 1.0, (0.0, -1.0), "outer_1"), truth(0.25, 1.0, (0.0, -1.0), "outer_1", "inner_1")]
    labels = window_labels(np.array([0, 51, 149, 150, 249]), 0, RATE, Windows(length=100), truths)
    assert labels["fault"].tolist() == ["healthy", "healthy", "healthy", "outer_ring", "outer_ring"]
    assert labels["mixed"].tolist() == [False, True, True, False, True]
    assert labels["width"].tolist() == [0.0, 0.0, 0.0, 0.002, 0.002]
    assert labels["load"].tolist() == [1.0] * 5
    assert not math.isnan(labels["speed"].sum())


def test_a_window_in_which_a_fault_begins_and_ends_is_mixed() -> None:
    truths = [truth(0.0, 1.0, (0.0, -1.0)), truth(0.12, 1.0, (0.0, -1.0), "outer_1"), truth(0.15, 1.0, (0.0, -1.0))]
    labels = window_labels(np.array([0, 100, 200]), 0, RATE, Windows(length=100), truths)
    assert labels["fault"].tolist() == ["healthy"] * 3
    assert labels["mixed"].tolist() == [False, True, False]


def test_a_run_without_windows_has_labels_of_the_same_types() -> None:
    # NumPy makes an empty list an array of float64, which a file of windows with texts cannot follow.
    windows, truths = Windows(length=100), [truth(0.0, 1.0, (0.0, -1.0))]
    none, some = (window_labels(np.array(begin, np.int64), 0, RATE, windows, truths) for begin in ([], [0]))
    assert {name: values.dtype.kind for name, values in none.items()} == {name: values.dtype.kind for name, values in some.items()}
