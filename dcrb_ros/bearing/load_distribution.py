"""The forces on the rollers of a bearing whose rings are rigid, from load and clearance alone."""

from __future__ import annotations

import functools
import math

import numpy as np

from dcrb_ros.core.laws import NORMAL_LAWS
from dcrb_ros.core.laws.site import inner_site, outer_site
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import material_of

PHASES = 4
"""Positions of the rollers within a pitch over which a mean is taken."""
TABULATED = 400
"""Forces at which the penetration of both raceways is tabulated."""
LEAST, MOST = 1e-3, 1e7
"""Their range [N]."""
BISECTIONS = 60
WIDEST = 0.01
"""Largest approach of the rings beyond the clearance [m]."""


def roller_forces(configuration: Configuration, load: float, clearance: float) -> Floats:
    """Return the normal forces of a row's rollers at the inner raceway, shape (PHASES, rollers) [N].

    The rings come nearer by d until the forces carry the ``load`` of all rows [N]: a roller at the angle psi from the load is pressed by
    d cos psi - clearance; ``clearance`` is the radial gap of `Bearing.radial_gap`, below zero for a preload [m].
    """
    c, b = configuration, configuration.bearing
    pitch = 2.0 * math.pi / b.rollers_per_row
    angles = pitch * (np.arange(b.rollers_per_row)[None, :] + np.arange(PHASES)[:, None] / PHASES)
    cosine, share = np.cos(angles), load / b.rows
    forces, pressed = _force_table(c)
    loads = np.empty(angles.shape)
    for phase in range(PHASES):
        low, high = -WIDEST, WIDEST
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            row = _under(middle * cosine[phase] - clearance, forces, pressed)
            if float((row * cosine[phase]).sum()) < share:
                low = middle
            else:
                high = middle
        loads[phase] = _under(high * cosine[phase] - clearance, forces, pressed)
    return loads


def _under(penetration: Floats, forces: Floats, pressed: Floats) -> Floats:
    """Return the forces [N] that press rollers in by penetrations [m]."""
    return np.asarray(np.where(penetration > 0.0, np.interp(penetration, pressed, forces), 0.0))


def _force_table(c: Configuration) -> tuple[Floats, Floats]:
    return _table(c.contact.law, tuple(sorted(dict(c.contact).items())), material_of(c.bearing))


@functools.lru_cache(maxsize=16)
def _table(law: str, values: tuple[tuple[str, object], ...], material: object) -> tuple[Floats, Floats]:
    """Return forces [N] and the penetrations of both raceways together under them [m]."""
    normal = NORMAL_LAWS[law]
    constants = normal.build(dict(values), material)  # type: ignore[arg-type]
    forces = np.concatenate([[0.0], np.geomspace(LEAST, MOST, TABULATED)])
    sites = inner_site(material), outer_site(material)  # type: ignore[arg-type]
    pressed = sum(np.asarray(normal.penetration(constants, forces[1:], site)) for site in sites)
    return forces, np.concatenate([[0.0], np.asarray(pressed)])
