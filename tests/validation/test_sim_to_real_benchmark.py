"""The scores of docs/results/sim-to-real.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sim_to_real_data
import sim_to_real_scores
import sim_to_real_trainings

from dcrb_ros.exam import replica


@pytest.mark.slow
def test_a_bearing_is_scored_by_a_forest_of_the_others() -> None:
    random = np.random.default_rng(1)
    faults = {"healthy": ["well_0"], "outer_ring": ["a_0", "a_1", "b_0"], "inner_ring": ["c_0", "d_0"], "roller": ["e_0", "e_1"]}
    truth, recording, values = [], [], []
    for place, (fault, names) in enumerate(faults.items()):
        for name in names:
            values.append(place + 0.1 * random.standard_normal((8, 2)))
            truth += [fault] * 8
            recording += [name] * 8
    test = sim_to_real_data.Windows(("y_depth", "y_kurtosis"), np.concatenate(values), truth, recording)
    healthy = sim_to_real_data.Windows(test.names, values[0], ["healthy"] * 8, ["other"] * 8)
    scores = sim_to_real_scores.left_out_scores(test, healthy, levels=False)
    assert scores.shape == (len(truth), len(sim_to_real_data.CLASSES))
    assert np.allclose(scores.sum(axis=1), 1.0)
    rollers = np.array(truth) == "roller"
    named = np.array(sim_to_real_data.CLASSES)[scores.argmax(axis=1)]
    assert (named == truth)[~rollers].all()
    # There is one bearing with a damaged roller, and no forest without it knows the class.
    assert (scores[rollers, sim_to_real_data.CLASSES.index("roller")] == 0.0).all()


def test_kept_windows_are_those_of_the_same_machines_and_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[tuple[int, float]] = []

    def windows(bench: str, machine: object, number: int, seconds: float) -> sim_to_real_data.Windows:
        made.append((number, seconds))
        return sim_to_real_data.Windows(("y_depth",), np.full((1, 1), seconds), ["healthy"], [str(number)])

    monkeypatch.setattr(sim_to_real_trainings, "machine_windows", windows)
    monkeypatch.setattr(replica, "healthy_level", lambda *_, **__: 2.0)

    def values(machines: int, seconds: float) -> list[float]:
        found = sim_to_real_trainings.drawn_windows(sim_to_real_data.RIGS[0], "ball_bearing_6205", tmp_path, machines, seconds)
        return found.values[:, 0].tolist()

    assert values(2, 1.0) == values(2, 1.0) == [1.0, 1.0]
    assert made == [(0, 1.0), (1, 1.0)]
    assert values(2, 2.0) == [2.0, 2.0]
    made.clear()
    assert values(3, 2.0) == [2.0, 2.0, 2.0]
    assert made == [(2, 2.0)], "more machines keep the first ones"
