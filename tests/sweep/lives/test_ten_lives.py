"""The lives that are made within minutes: ten bearings with some hundred inspections each."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dcrb_ros.sweep.execution import common_settings, run_task
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.lives.plan import LifePlan
from dcrb_ros.sweep.loader import read_sweep
from dcrb_ros.sweep.store import Store


@pytest.fixture(scope="module")
def plan() -> LifePlan:
    found = plan_of(read_sweep("ten_lives"))
    assert isinstance(found, LifePlan)
    return found


def test_ten_lives_have_a_hundred_inspections_each_on_average(plan: LifePlan) -> None:
    counts = Counter(run.truth["bearing_id"] for run in plan.runs())
    assert len(counts) == 10
    assert 100 <= np.mean(list(counts.values())) <= 120
    assert plan.sweep.file.duration + plan.sweep.file.settle < 0.31  # of simulated time each [s]
    assert {run.split for run in plan.runs()} == {"train", "validation", "test"}


def test_the_vibration_of_a_life_grows_to_its_end(plan: LifePlan, tmp_path: Path) -> None:
    """The first and the last inspection of a life that ends in failure, as `dcrb sweep` makes them."""
    store = Store(str(tmp_path))
    short = plan.sweep.file.model_copy(update={"duration": 0.1, "settle": 0.05})
    common = replace(common_settings(plan.sweep, store), file=short)
    failed = next(life.bearing_id for life in plan.sweep.population.lives() if not life.censored)
    inspections = [run for run in plan.runs() if run.truth["bearing_id"] == failed]
    assert inspections[-1].truth["remaining_life"] == 0.0
    levels = []
    for run in (inspections[0], inspections[-1]):
        assert [status for _, status in run_task(common, (run,))] == ["done"]
        levels.append(float(np.std(np.load(tmp_path / "runs" / f"{run.name}.npz")["ay"])))
    assert levels[1] > 2.0 * levels[0]
