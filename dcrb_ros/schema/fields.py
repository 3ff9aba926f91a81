"""The fields of which groups of parameters are made: unit, range, description and remedy.

One schema stands behind the YAML files, the ROS parameters, the manifest of a recording and the table in the docs.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

LENGTH_REMEDY = "lengths are in metres, a catalogue gives millimetres"


class Group(BaseModel):
    """A group of parameters: immutable, no unknown keys, no silent conversions, no NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def quantity(
    default: float | int,
    unit: str,
    description: str,
    low: float | int,
    high: float | int,
    *,
    symbol: str = "",
    remedy: str = "",
    run_time: bool = False,
) -> Any:
    """Return the field of a physical quantity.

    ``low`` and ``high`` are the closed range, ``remedy`` the advice that a refusal gives, ``run_time`` whether the
    running node accepts a change.
    """
    extra: dict[str, Any] = {"unit": unit, "symbol": symbol, "remedy": remedy, "run_time": run_time}
    return Field(default, ge=low, le=high, description=description, json_schema_extra=extra)


def length(default: float, description: str, low: float, high: float, *, symbol: str = "", run_time: bool = False) -> Any:
    """Return the field of a length [m]."""
    return quantity(default, "m", description, low, high, symbol=symbol, remedy=LENGTH_REMEDY, run_time=run_time)


def choice(default: str | bool, description: str, *, run_time: bool = False) -> Any:
    """Return the field of a choice: names, a text or yes and no."""
    return Field(default, description=description, json_schema_extra={"unit": "-", "symbol": "", "remedy": "", "run_time": run_time})
