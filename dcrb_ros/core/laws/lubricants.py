"""The lubricants that parameters choose or describe, and how much of them there is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dcrb_ros.core.laws.viscosity import Lubricant

LUBRICANTS = {
    "grease": Lubricant(100.0, 11.0, 890.0, 2.2e-8),
    "vg100": Lubricant(100.0, 11.2, 885.0, 2.2e-8),
    "vg220": Lubricant(220.0, 18.7, 890.0, 2.4e-8),
}
"""Lubricants by name: the base oil of a wheelset grease (a choice, no data sheet gives it), and typical mineral oils."""
CUSTOM = "custom"
"""Name of the lubricant that parameters describe."""
LAYERS = {"grease": 5e-6, "vg100": 50e-6, "vg220": 50e-6, "custom": 50e-6}
"""Oil layer that both surfaces offer together [m]: what a grease leaves on the raceway, or an oil bath."""
OIL_SHARES = {"grease": 0.005, "vg100": 0.02, "vg220": 0.02, "custom": 0.02}
"""Share of oil in the space of the rollers [-]."""


def lubricant_of(values: Mapping[str, Any]) -> Lubricant:
    """Return the lubricant that the parameters choose or describe."""
    custom = Lubricant(values["viscosity_40"], values["viscosity_100"], values["density"], values["pressure_coefficient"])
    return LUBRICANTS.get(values["lubricant"], custom)
