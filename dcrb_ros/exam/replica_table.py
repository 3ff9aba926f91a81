"""Optional columns of a table of measured recordings that a replica takes instead of drawn values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from dcrb_ros.exam.measured import COLUMNS, OPTIONAL_COLUMNS, REPLICA_COLUMNS
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.tables import read_rows


@dataclass(frozen=True)
class ReplicaColumns:
    """What a row of the table says about the recording beyond `measured.COLUMNS`."""

    seconds: float
    """Length of the recording, column `seconds` [s]; infinite without the column."""
    load: float | None
    """Radial load, column `load` [N]."""
    pitch_radius: float | None
    """Half of the column `pitch_diameter_mm` [m]."""


def read_replica_columns(table: Path) -> Mapping[str, ReplicaColumns]:
    """Return the optional columns by the name of the recording; the table has been read by `measured.read_table`.

    Raises:
        Refusal: a value is not a number above 0.
    """
    rows = read_rows(table, COLUMNS, (*OPTIONAL_COLUMNS, *REPLICA_COLUMNS))
    return {row["name"]: _columns(table, line, row) for line, row in enumerate(rows, 2)}


def _columns(table: Path, line: int, row: Mapping[str, str | None]) -> ReplicaColumns:
    where = f"{table}, line {line}"
    pitch = _number(row, "pitch_diameter_mm", "mm", where)
    return ReplicaColumns(
        _number(row, "seconds", "s", where) or math.inf,
        _number(row, "load", "N", where),
        None if pitch is None else 5e-4 * pitch,
    )


def _number(row: Mapping[str, str | None], column: str, unit: str, where: str) -> float | None:
    text = row.get(column)
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise Refusal(f"{where}: {column} = {text} is not a number above 0: give it in {unit}, or leave it empty")
    return value
