"""Clearance lost to a wrong fit or assembly: a wider load zone, and where nothing is left a preload that heats the bearing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from dcrb_ros.faults.condition import Condition
from dcrb_ros.faults.fault import Dimensions, Fault
from dcrb_ros.schema.fields import LENGTH_REMEDY, length

MOST_PRELOAD = 3e-5
"""Largest interference of rollers and raceways [m]: some 20 kN on every roller of the default bearing."""


class LostClearance(Fault):
    """Radial clearance that a tight fit takes: the inner raceway is larger by it."""

    keys = ("clearance",)
    component = "overheating"

    lost: float = length(
        0.0, "Radial clearance that is lost; more than the bearing has is a preload; 0 for none", 0.0, 0.001, run_time=True
    )

    @property
    def present(self) -> bool:
        """Whether clearance is lost."""
        return self.lost > 0.0

    def problems(self, key: str, bearing: Dimensions) -> Iterator[str]:
        """Refuse a preload that would crush the rollers."""
        gap = bearing.outer_raceway_radius - bearing.inner_raceway_radius - 2.0 * bearing.roller_radius
        if self.lost > gap + MOST_PRELOAD:
            yield (
                f"faults.{key}.lost = {self.lost:g} m is above {gap + MOST_PRELOAD:.4g} m, the radial gap and an interference of "
                f"{MOST_PRELOAD:g} m: {LENGTH_REMEDY}"
            )

    def condition(self) -> Condition:
        """Return the clearance."""
        return Condition(clearance=self.lost)

    @classmethod
    def words(cls, name: str, fields: Mapping[str, float]) -> str:
        """Return the clearance."""
        return f"{fields['lost'] * 1e6:.4g} um of the clearance lost"
