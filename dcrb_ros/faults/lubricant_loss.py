"""Loss of lubricant: the layer on the raceways thins, films break down, and the bearing first runs cooler, then hot and loud."""

from __future__ import annotations

from collections.abc import Mapping

from dcrb_ros.faults.condition import Condition
from dcrb_ros.faults.fault import Fault
from dcrb_ros.schema.fields import quantity


class LubricantLoss(Fault):
    """A share of the lubricant that has bled, leaked or burnt."""

    keys = ("lubrication",)
    component = "lubrication"

    loss: float = quantity(0.0, "-", "Share of the lubricant that is lost; 0 for none, 1 for all", 0.0, 1.0, run_time=True)
    duration: float = quantity(
        0.0,
        "s",
        "Time in which all lubricant would be lost: the loss grows at this rate to its share; 0 for within 0.16 s",
        0.0,
        1e7,
        run_time=True,
    )

    @property
    def present(self) -> bool:
        """Whether lubricant is lost."""
        return self.loss > 0.0

    def condition(self) -> Condition:
        """Return the loss."""
        return Condition(loss=self.loss, duration=self.duration)

    @classmethod
    def words(cls, name: str, fields: Mapping[str, float]) -> str:
        """Return the share."""
        return f"{100.0 * fields['loss']:.3g} % of the lubricant lost"
