"""The temperatures of a run for its label."""

from __future__ import annotations

from collections.abc import Mapping

AMBIENT, BOX, OUTER_RINGS = "ambient [deg C]", "box [deg C]", "outer_ring"
"""Names of temperatures in the ground truth, that of the outer rings without their rows."""
TEMPERATURES: Mapping[str, str] = {
    "ambient_temperature": "temperature of the surroundings at the end of the run [deg C]; null, like the next two, without a network",
    "box_temperature": "temperature of the axle box [deg C]",
    "outer_ring_temperature": "temperature of the hotter outer ring [deg C]",
}
"""Columns of the labels and their meaning."""


def temperatures(thermal: Mapping[str, float]) -> dict[str, float]:
    """Return the temperatures of a ground truth by their column; none without a thermal network."""
    if AMBIENT not in thermal:
        return {}
    rings = [value for name, value in thermal.items() if OUTER_RINGS in name and name.endswith("[deg C]")]
    return {"ambient_temperature": thermal[AMBIENT], "box_temperature": thermal[BOX], "outer_ring_temperature": max(rings)}
