"""Where a cage lies at rest: as low as the rollers in its pockets and its land allow."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.bearing.equilibrium import Rest
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.arrays import Floats

LEAST_SLOPE = 1e-6
"""Vertical part of a pocket's tangent from which a roller can carry the cage [-]."""
RESOLUTION = 2.0**-43
"""Places are rounded to a multiple of this [m], as those of the equilibrium."""


def settled_cages(payload: Payload, rest: Rest) -> Floats:
    """Return the centres of the cages at rest on rollers or land, shape (rows, 2) [m].

    A cage with pinned rollers is where these carry it. A free roller lets its pocket move along the tangent t by the clearance c_p on
    either side, so that a cage that falls by d meets it at the first of s + d t_y = +-c_p, s the roller's offset from the pocket's middle.
    """
    settled: Floats = rest.cages.copy()
    for row in np.flatnonzero(payload.free.all(axis=1)):
        offset = ((rest.rollers[row] - rest.cages[row]) * payload.pocket_tangent[row]).sum(axis=-1)
        rise = payload.pocket_tangent[row, :, 1]
        ahead, behind = ~payload.broken[row], ~np.roll(payload.broken[row], 1)
        blocked = (np.abs(rise) > LEAST_SLOPE) & np.where(rise > 0.0, ahead, behind)
        free_fall = (payload.pocket_clearance[row] - np.sign(rise) * offset)[blocked] / np.abs(rise[blocked])
        x, y = rest.cages[row] - rest.outer
        on_land = y + math.sqrt(max(payload.land_clearance**2 - x * x, 0.0))
        fall = max(0.0, min(float(free_fall.min(initial=math.inf)), on_land))
        settled[row, 1] -= round(fall / RESOLUTION) * RESOLUTION
    return settled
