"""A seal that rubs: heat beside the rollers, and nothing that vibrates."""

from __future__ import annotations

from collections.abc import Mapping

from dcrb_ros.faults.condition import Condition
from dcrb_ros.faults.fault import Fault
from dcrb_ros.schema.fields import quantity


class SealRub(Fault):
    """Seals whose lips or shields touch what turns past them."""

    keys = ("seal_rub",)
    component = "overheating"

    torque: float = quantity(
        0.0,
        "N m",
        "Friction torque of the rubbing seal of each row; 0 for none; 1 N m is 126 W at 1200 rpm",
        0.0,
        50.0,
        run_time=True,
    )

    @property
    def present(self) -> bool:
        """Whether a seal rubs."""
        return self.torque > 0.0

    def condition(self) -> Condition:
        """Return the torque."""
        return Condition(seal_torque=self.torque)

    @classmethod
    def words(cls, name: str, fields: Mapping[str, float]) -> str:
        """Return the torque."""
        return f"seals rub with {fields['torque']:.3g} N m"
