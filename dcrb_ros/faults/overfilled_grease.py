"""Too much grease: the rollers plough through it, which heats the bearing."""

from __future__ import annotations

from collections.abc import Mapping

from dcrb_ros.faults.condition import Condition
from dcrb_ros.faults.fault import Fault
from dcrb_ros.schema.fields import quantity


class OverfilledGrease(Fault):
    """Lubricant in the space about the rollers, beyond what a bearing has."""

    keys = ("overfilled",)
    component = "lubrication"

    share: float = quantity(
        0.0, "-", "Share of the space about the rollers that grease fills beyond the normal filling", 0.0, 0.5, run_time=True
    )

    @property
    def present(self) -> bool:
        """Whether there is too much grease."""
        return self.share > 0.0

    def condition(self) -> Condition:
        """Return the share."""
        return Condition(oil_share=self.share)

    @classmethod
    def words(cls, name: str, fields: Mapping[str, float]) -> str:
        """Return the share."""
        return f"overfilled with grease by {100.0 * fields['share']:.3g} %"
