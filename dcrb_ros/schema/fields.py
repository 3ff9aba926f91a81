"""Fields of parameters: unit, range, description and remedy.

The groups of parameters that are made of these fields are the schema of the YAML files, the ROS parameters, the manifest of a recording and
the table in the documentation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from dcrb_ros.schema.parameter_field import sentence
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

LENGTH_REMEDY = "lengths are in metres; catalogues give millimetres"


class Refusing(ModelMetaclass):
    """Raises a `Refusal` where a group is made of invalid values; ``model_validate`` raises the errors of pydantic."""

    if not TYPE_CHECKING:  # a type checker takes the parameters from the fields

        def __call__(cls, *args: Any, **kwargs: Any) -> Any:
            try:
                return super().__call__(*args, **kwargs)
            except ValidationError as error:
                raise Refusal(sentence(error, cls)) from None


class Group(BaseModel, metaclass=Refusing):
    """A group of parameters: immutable, without unknown keys, silent conversions or NaN."""

    # A group is compiled once, as a part of the configuration, not once more by itself when its module is imported.
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, defer_build=True)


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
    """Return the field of a quantity with a unit.

    ``low`` and ``high`` limit the closed range, ``remedy`` is the advice in the error message for a value outside it, and ``run_time`` says
    whether the parameter can change while the simulation runs.
    """
    extra: dict[str, Any] = {"unit": unit, "symbol": symbol, "remedy": remedy, "run_time": run_time}
    return Field(default, ge=low, le=high, description=description, json_schema_extra=extra)


def length(default: float, description: str, low: float, high: float, *, symbol: str = "", run_time: bool = False) -> Any:
    """Return the field of a length [m]."""
    return quantity(default, "m", description, low, high, symbol=symbol, remedy=LENGTH_REMEDY, run_time=run_time)


def choice(default: str | bool, description: str, *, run_time: bool = False) -> Any:
    """Return the field of a text, of one of several names, or of true and false."""
    return Field(default, description=description, json_schema_extra={"unit": "-", "symbol": "", "remedy": "", "run_time": run_time})
