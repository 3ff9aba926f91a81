"""The size of the widest defect in the labels of runs."""

from __future__ import annotations

import math
from pathlib import Path

import pandas as pd
import pytest
from data_sets import made


def test_labels_have_the_depth_that_rollers_reach_and_their_share(tmp_path: Path) -> None:
    settings = {"cage.joint": "revolute", "faults.outer_1.width": 0.002}
    cases = {"healthy": {"faults.outer_1.width": 0.0}, "outer": {}}
    made({"base": "dry", "duration": 0.02, "set": settings, "cases": cases}, tmp_path)
    labels = pd.read_parquet(tmp_path / "labels.parquet").set_index("case")
    assert labels.loc["outer", ["width", "depth", "share"]].tolist() == [0.002, 0.0003, 1.0]
    assert labels.loc["outer", "reached_depth"] == pytest.approx(28.75e-6, rel=0.01)  # c^2/(2 R), docs/explanation/surfaces.md
    assert math.isnan(labels.loc["healthy", "reached_depth"])
    assert math.isnan(labels.loc["healthy", "share"])
