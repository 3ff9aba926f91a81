"""How far loaded rollers sink into a defect, and over which share of their length; its severity depends on both more than on its depth."""

from __future__ import annotations

import numpy as np

from dcrb_ros.bearing.damage_tables import COLUMNS, RACEWAY_NODES, ROLLER_NODES, add_damage
from dcrb_ros.core.contacts.heights import HEIGHT, PART_HEIGHT, SHARE
from dcrb_ros.faults.fault import Fault
from dcrb_ros.settings.configuration import Configuration


def reached(configuration: Configuration, fault: Fault) -> tuple[float, float]:
    """Return the largest depth [m] that the middle of a loaded contact reaches in a defect, and the share of the rollers' length [-].

    A narrow defect is bridged by the rollers, so that its own depth is larger. With ``surfaces.law`` smooth the numbers are the same, those
    of the path by which the kernels describe defects with ``profile``.
    """
    b = configuration.bearing
    raceways = np.zeros((2, b.rows, RACEWAY_NODES, COLUMNS))
    rollers = np.zeros((b.rows * b.rollers_per_row, ROLLER_NODES, 4))
    for damage in fault.damage(b, 0.0):
        add_damage(configuration, damage, raceways, rollers)
    heights = raceways[..., HEIGHT] + raceways[..., PART_HEIGHT]
    return abs(min(float(heights.min()), float(rollers[..., 0::2].min()))), float(raceways[..., SHARE].max()) or 1.0


def of_widest(configuration: Configuration) -> dict[str, float]:
    """Return both numbers of the widest defect as columns of a label; empty without one."""
    widths = {
        key: fields["width"]
        for key, fault in configuration.faults.present()
        for fields in fault.described(key).values()
        if "width" in fields
    }
    if not widths:
        return {}
    depth, share = reached(configuration, dict(configuration.faults.present())[max(widths, key=lambda key: widths[key])])
    return {"reached_depth": depth, "share": share}
