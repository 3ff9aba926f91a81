"""The temperatures in the labels of runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from data_sets import made

from dcrb_ros.sweep.label import TEMPERATURES, temperatures


def table(folder: Path, **changes: Any) -> pd.DataFrame:
    """Simulate a sweep in this process and return its labels."""
    made({"base": "dry", "duration": 0.02, **changes}, folder)
    return pd.read_parquet(folder / "labels.parquet")


def test_without_a_network_there_are_none(tmp_path: Path) -> None:
    assert temperatures({}) == {}
    found = table(tmp_path, set={"cage.joint": "revolute"})
    assert found[list(TEMPERATURES)].isna().all().all()


def test_a_network_is_warmer_than_its_surroundings(tmp_path: Path) -> None:
    found = table(tmp_path, base="healthy", set={"thermal.law": "network"}, vary={"thermal.ambient": [0.0, 20.0]})
    assert (found["status"] == "done").all(), json.dumps(list(found["reason"]))
    assert list(found["ambient_temperature"]) == [0.0, 20.0]
    box, ring = found["box_temperature"] - found["ambient_temperature"], found["outer_ring_temperature"] - found["ambient_temperature"]
    # Specification of the network: 10 to 45 K above the surroundings at this speed, the ring warmer than the box it heats.
    assert ((box > 5.0) & (ring > box) & (ring < 60.0)).all()


def test_temperatures_are_those_of_the_hotter_row() -> None:
    own = {"row1/outer_ring": 40.0, "row2/outer_ring": 42.0, "box": 35.0, "ambient": 20.0}
    thermal = {f"{name} [deg C]": value for name, value in (own | {"opposite_box": 50.0, "opposite_outer_ring": 60.0}).items()}
    with pytest.raises(KeyError):
        temperatures({key: value for key, value in thermal.items() if key != "box [deg C]"})
    assert temperatures(thermal) == {"ambient_temperature": 20.0, "box_temperature": 35.0, "outer_ring_temperature": 42.0}
