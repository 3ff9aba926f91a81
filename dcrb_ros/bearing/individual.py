"""What a seed draws of a bearing: deviations of its dimensions within their tolerances, which make it an individual."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

BOUND = 2.0
"""Standard deviations within which clearances lie [-]: bearings and cages outside of their tolerance are not delivered."""
LEAST_CLEARANCE = 0.5
"""Smallest share of the nominal clearance of the pockets [-]."""


class Individual(NamedTuple):
    """Deviations of a bearing from its nominal dimensions; there are none with ``surfaces.law`` smooth."""

    waviness: float
    """Factor of the waviness of all surfaces [-]."""
    clearance: float
    """Of the diametral clearance [m]."""
    row_radii: Floats
    """Of the outer raceway's radius, positive towards the rollers, shape (rows,) [m]."""
    roller_diameters: Floats
    """Shape (rows * rollers,) [m]."""
    run_out: Floats
    """Centre of each inner raceway X, Y, turning with the shaft, shape (rows, 2) [m]."""
    pocket_clearance: Floats
    """Of the clearance between each roller and its bars, shape (rows, rollers) [m]."""
    pocket_places: Floats
    """Of the pockets' places along the pitch circle, shape (rows, rollers) [m]."""
    cage_unbalance: Floats
    """Centre of mass of each cage X, Y at cage angle zero, shape (rows, 2) [m]."""


def surface_seed(configuration: Configuration) -> int:
    """Return the seed that makes the bearing an individual."""
    return configuration.surfaces.seed or configuration.simulation.seed


def individual_of(configuration: Configuration) -> Individual:
    """Return the deviations that the seed of a configuration draws.

    Every item has random numbers of its own, so that one parameter changes nothing else.
    """
    s, b, seed = configuration.surfaces, configuration.bearing, surface_seed(configuration)
    profile = 1.0 if s.law == "profile" else 0.0
    count = b.rows * b.rollers_per_row

    def normal(name: str, spread: float, *shape: int) -> Floats:
        return np.asarray(random_stream(seed, name).standard_normal(shape) * (profile * spread))

    def bounded(name: str, spread: float, *shape: int) -> Floats:
        return np.asarray(np.clip(normal(name, spread, *shape), -BOUND * spread, BOUND * spread))

    angle = 2.0 * math.pi * random_stream(seed, "unbalance of the cages").random(b.rows)
    unbalance = profile * s.cage_unbalance * np.exp(bounded("size of the unbalance of the cages", s.cage_unbalance_spread, b.rows))
    pockets = bounded("pocket clearance", s.pocket_clearance_spread) + bounded(
        "clearance of single pockets", s.single_pocket_spread, b.rows, b.rollers_per_row
    )
    return Individual(
        waviness=math.exp(float(bounded("level of the waviness", s.waviness_spread))),
        clearance=float(bounded("clearance", s.clearance_spread)),
        row_radii=normal("raceways of the rows", s.row_spread, b.rows),
        roller_diameters=normal("roller diameters", s.roller_spread, count),
        run_out=normal("run-out of the inner raceways", s.run_out / math.sqrt(2.0), b.rows, 2),
        pocket_clearance=np.maximum(pockets, (LEAST_CLEARANCE - 1.0) * configuration.cage.pocket_clearance),
        pocket_places=normal("places of the pockets", s.pocket_spread, b.rows, b.rollers_per_row),
        cage_unbalance=unbalance[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1),
    )
