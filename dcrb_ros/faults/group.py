"""All faults of a bench together: the group ``faults`` of the configuration."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from pydantic import create_model

from dcrb_ros.faults.condition import Condition, combined
from dcrb_ros.faults.fault import Dimensions, Fault, Footprint
from dcrb_ros.faults.geometry import Damage
from dcrb_ros.schema.fields import Group

Kind = TypeVar("Kind", bound=Fault)


class FaultGroup(Group):
    """The faults of a bench by key; its parameters are those of the kinds in `dcrb_ros.faults.KINDS`."""

    kinds: ClassVar[dict[str, type[Fault]]] = {}
    """Kind of the fault below each key."""

    if TYPE_CHECKING:

        def __getattr__(self, key: str) -> Any:
            """Return the parameter below a key."""

    def items(self) -> Iterator[tuple[str, Fault]]:
        """Yield key and fault for every key, whether the bearing has the fault or not."""
        for key, kind in self.kinds.items():
            yield key, kind.from_parameter(getattr(self, key))

    def present(self) -> Iterator[tuple[str, Fault]]:
        """Yield key and fault for every fault that the bearing has."""
        return ((key, fault) for key, fault in self.items() if fault.present)

    def of_kind(self, kind: type[Kind]) -> Iterator[Kind]:
        """Yield every fault of a kind that the bearing has."""
        return (fault for _, fault in self.present() if isinstance(fault, kind))

    def problems(self, bearing: Dimensions) -> Iterator[str]:
        """Yield a sentence for each fault that is impossible in a bearing, and for each that overlaps one before it."""
        before: list[tuple[str, list[Footprint]]] = []
        for key, fault in self.present():
            yield from fault.problems(key, bearing)
            areas = list(fault.footprints(bearing))
            for other_key, others in before:
                gaps = [area.gap(other) for area in areas for other in others if area.overlaps(other)]
                if gaps:
                    yield (
                        f"faults.{key} overlaps faults.{other_key}: their middles are {min(gaps):.4g} m apart; "
                        "move an azimuth or join them into one defect"
                    )
            before.append((key, areas))

    def damage(self, bearing: Dimensions, edge_radius: float = 0.0) -> list[Damage]:
        """Return the geometry of all faults for the kernels; see `Fault.damage`."""
        return [damage for _, fault in self.present() for damage in fault.damage(bearing, edge_radius)]

    @functools.cached_property
    def condition(self) -> Condition:
        """What the faults change of lubricant, seals and clearance."""
        return combined(fault.condition() for _, fault in self.present())

    @property
    def damaging(self) -> list[tuple[str, Fault]]:
        """Key and fault of every fault that damages surfaces or cages."""
        return [(key, fault) for key, fault in self.present() if fault.condition().sound]

    def described(self) -> dict[str, dict[str, float]]:
        """Return the numbers of every fault that the bearing has by its name in the ground truth."""
        return {name: fields for key, fault in self.present() for name, fields in fault.described(key).items()}

    def unhealed(self, after: FaultGroup) -> Iterator[str]:
        """Yield a sentence for each fault that ``after`` lacks although it cannot disappear while the bench runs."""
        for (_, before), (_, now) in zip(self.items(), after.items(), strict=True):
            yield from before.unhealed(now)


def fault_group(kinds: Sequence[type[Fault]]) -> type[FaultGroup]:
    """Return the group with the parameters of some kinds of faults.

    Raises:
        TypeError: two kinds have the same key.
    """
    of_key: dict[str, type[Fault]] = {}
    for kind in kinds:
        for key in kind.keys:
            if key in of_key:
                raise TypeError(f"{of_key[key].__name__} and {kind.__name__} have the same key '{key}': rename one")
            of_key[key] = kind
    parameters: dict[str, Any] = {key: kind.parameter() for key, kind in of_key.items()}
    group = create_model("Faults", __base__=FaultGroup, __module__="dcrb_ros.faults", **parameters)
    group.kinds = of_key
    return group
