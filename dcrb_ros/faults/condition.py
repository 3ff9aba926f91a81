"""What faults change of a bearing beside its surfaces and cages: lubricant, seals, clearance."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple


class Condition(NamedTuple):
    """The state of lubricant, seals and clearance that the faults of a bearing ask for; the default is that of a sound one."""

    loss: float = 0.0
    """Share of the lubricant that is lost [-]."""
    duration: float = 0.0
    """Time in which all lubricant would be lost [s]; 0 for as fast as films go, within 0.16 s."""
    oil_share: float = 0.0
    """Share of lubricant in the space about the rollers [-]; 0 for that of the configuration."""
    seal_torque: float = 0.0
    """Friction torque of rubbing seals of each row, beside the usual one [N m]."""
    clearance: float = 0.0
    """Radial clearance that is lost [m]."""

    @property
    def sound(self) -> bool:
        """Whether nothing is changed."""
        return not (self.loss or self.oil_share or self.seal_torque or self.clearance)


def combined(conditions: Iterable[Condition]) -> Condition:
    """Return the condition of a bearing with several faults, each of which changes other fields."""
    total = Condition()
    for condition in conditions:
        total = Condition(*(value or former for value, former in zip(condition, total, strict=True)))
    return total
