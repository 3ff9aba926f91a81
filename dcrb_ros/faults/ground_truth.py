"""Class and description of the faults that the ground truth names.

A fault of the bearing has the name of its key (``outer_1``, ``broken_bars.row1/bar15``), one of the sensor begins with ``sensor.``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from dcrb_ros.faults import Fault, Faults
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import FaultClass, fault_class

SENSOR = "sensor."


def kind_of(name: str) -> type[Fault] | None:
    """Return the kind of a fault, or None for one of the sensor or of a kind that this version lacks."""
    return Faults.kinds.get(name.partition(".")[0])


def class_of(names: Iterable[str]) -> FaultClass:
    """Return the class of a bearing with some faults: the verdict that is correct for it.

    Raises:
        Refusal: a fault of no known kind.
    """
    return fault_class(_class_of_one(name) for name in names)


def _class_of_one(name: str) -> FaultClass:
    if name.startswith(SENSOR):
        return "sensor"
    kind = kind_of(name)
    if kind is None:
        raise Refusal(f"the ground truth names the fault '{name}', whose verdict is unknown: the faults are {', '.join(Faults.kinds)}")
    return kind.component


def words_of(name: str, fields: Mapping[str, float]) -> str:
    """Return a fault in a few words, without its row; one of another version by its name and width."""
    if name.startswith(SENSOR):
        return name.replace(".", " ", 1)
    return (kind_of(name) or Fault).words(name, fields)


def summary_of(faults: Mapping[str, Mapping[str, float]]) -> str:
    """Return all faults in a few words; ``healthy`` without any."""
    return ", ".join(words_of(name, fields) for name, fields in faults.items()) or "healthy"
