"""The interface of a fault: everything about a kind of fault in one class.

A kind is a subclass of `Fault` in a file of its own and a line in `dcrb_ros.faults.KINDS`. Its parameters, run-time changes, ground truth,
labels and verdict follow from the class; `docs/how-to/add-a-fault.md` shows one from beginning to end.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple, Protocol

from dcrb_ros.faults.condition import Condition
from dcrb_ros.faults.geometry import Damage
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.verdicts import Component, Trouble


class Dimensions(Protocol):
    """Dimensions of the bearing that carries a fault; `dcrb_ros.settings.parameters.Bearing` has them. Lengths [m]."""

    @property
    def rows(self) -> int: ...
    @property
    def rollers_per_row(self) -> int: ...
    @property
    def inner_raceway_radius(self) -> float: ...
    @property
    def outer_raceway_radius(self) -> float: ...
    @property
    def pitch_radius(self) -> float: ...
    @property
    def roller_radius(self) -> float: ...
    @property
    def roller_length(self) -> float: ...


class Footprint(NamedTuple):
    """A stretch of a surface that a fault occupies; no other fault may overlap it."""

    body: Component
    row: int
    """Row, counted from one; 0 for all rows."""
    roller: int
    """Number of the roller, counted from one; 0 on a raceway."""
    azimuth: float
    """Angle of its middle [rad]."""
    width: float
    """Width along the surface [m]."""
    radius: float
    """Radius of the surface [m]."""

    def gap(self, other: Footprint) -> float:
        """Return the distance between the middles of two footprints [m], infinite on different surfaces."""
        same_row = not (self.row and other.row and self.row != other.row)
        if (self.body, self.roller) != (other.body, other.roller) or not same_row:
            return float("inf")
        return abs(math.remainder(self.azimuth - other.azimuth, 2.0 * math.pi)) * self.radius

    def overlaps(self, other: Footprint) -> bool:
        """Return whether two footprints share a part of a surface."""
        return self.gap(other) < 0.5 * (self.width + other.width)


class Fault(Group):
    """One fault of the bearing as configured.

    The fields of a subclass are its parameters: their names, units, ranges and descriptions make the YAML keys, the ROS parameters and the
    table in the documentation. A field with ``run_time=True`` changes while the bench runs.
    """

    keys: ClassVar[tuple[str, ...]]
    """Keys below ``faults``; a bench carries as many faults of the kind as there are keys."""
    component: ClassVar[Component | Trouble]
    """The component that the fault damages, or what is wrong without damage: the correct verdict of a detector."""

    @property
    @abstractmethod
    def present(self) -> bool:
        """Whether the bearing has the fault; the default values describe none."""

    def damage(self, bearing: Dimensions, edge_radius: float) -> Iterator[Damage]:
        """Yield the geometry for the kernels, of a fault that is present and without `problems`; nothing where the surfaces are sound.

        ``edge_radius`` is the radius of rounded edges [m], 0 where the contact law has sharp ones.
        """
        return iter(())

    def problems(self, key: str, bearing: Dimensions) -> Iterator[str]:
        """Yield a sentence for each value that is impossible in this bearing: the value, the range and the remedy."""
        return iter(())

    def footprints(self, bearing: Dimensions) -> Iterator[Footprint]:
        """Yield the stretches of surface that the fault occupies; nothing if it may overlap others."""
        return iter(())

    def condition(self) -> Condition:
        """Return what the fault changes of lubricant, seals and clearance."""
        return Condition()

    def described(self, key: str) -> dict[str, dict[str, float]]:
        """Return the numbers that the ground truth states, by the name of the fault: its key, or its key, a dot and more."""
        return {key: {name: value for name, value in self.model_dump().items() if type(value) in (int, float)}}

    def unhealed(self, after: Fault) -> Iterator[str]:
        """Yield a sentence for each damage that ``after`` lacks although it cannot disappear while the bench runs."""
        return iter(())

    @classmethod
    def words(cls, name: str, fields: Mapping[str, float]) -> str:
        """Return a fault of the ground truth in a few words, without its row."""
        return f"{name}: {fields['width'] * 1e3:g} mm wide" if "width" in fields else name

    @classmethod
    def parameter(cls) -> tuple[Any, Any]:
        """Return type and default of the parameter below each of the `keys`."""
        return cls, cls.model_construct()  # without compiling the group by itself

    @classmethod
    def from_parameter(cls, value: Any) -> Fault:
        """Return the fault that a parameter's value describes."""
        assert isinstance(value, cls)
        return value
