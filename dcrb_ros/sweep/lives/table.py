"""The tables of lives: columns of the inspections, and a table with one row per bearing."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from dcrb_ros.sweep.lives.life import Life
from dcrb_ros.sweep.lives.sweep import LifeSweep
from dcrb_ros.sweep.table import parquet_schema
from dcrb_ros.sweep.windows import parquet_bytes

TRUTH: Mapping[str, tuple[type, str]] = {
    "bearing_id": (str, "name of the bearing"),
    "inspection": (int, "number of the inspection of the bearing, from 0"),
    "hours": (float, "operating hours of the bearing at the inspection [h]"),
    "section": (str, "section of the duty on which the inspection was made"),
    "damage": (float, "width of the damage [m]; 0 before it starts"),
    "remaining_life": (float, "operating hours from the inspection to functional failure [h]; true also of a bearing that is censored"),
    "censored": (bool, "whether the bearing leaves service at its overhaul, before it fails"),
}
"""Columns of the labels of inspections: type and meaning."""
LIVES: Mapping[str, tuple[type, str]] = {
    "bearing_id": (str, "name of the bearing"),
    "split": (str, "train, validation or test"),
    "component": (str, "component with the damage: outer, inner or roller"),
    "row": (int, "row of the damage"),
    "azimuth": (float, "azimuth of the damage [rad]"),
    "individual": (int, "seed of the bearing's surfaces"),
    "start": (float, "start of the damage [h]"),
    "failure": (float, "functional failure: the damage has its last width [h]"),
    "end": (float, "end of service: failure or overhaul [h]"),
    "censored": (bool, "whether the bearing leaves service at its overhaul, before it fails"),
    "inspections": (int, "number of inspections"),
}
"""Columns of `lives.parquet`: type and meaning."""


def lives_table(sweep: LifeSweep, split: Callable[[Life], str]) -> bytes:
    """Return the table of lives as a Parquet file; ``split`` gives the split of a life."""
    import pyarrow

    every = sweep.recipe.inspection.every
    rows = [
        {
            **{name: getattr(life, name) for name in LIVES if hasattr(life, name)},
            **life.location,
            "split": split(life),
            "inspections": life.count(every),
        }
        for life in sweep.population.lives()
    ]
    return parquet_bytes(pyarrow.Table.from_pylist(rows, schema=parquet_schema(LIVES)), compression="zstd")
