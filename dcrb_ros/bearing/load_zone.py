"""The load zone: the mean normal force that the inner raceway carries at each azimuth."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.schema.arrays import Floats

SECTORS = 72
"""Sectors of azimuth over which the mean is taken."""


def sector_azimuths() -> Floats:
    """Return the azimuths of the middles of the sectors [rad]."""
    return np.asarray(-math.pi + (np.arange(SECTORS) + 0.5) * 2.0 * math.pi / SECTORS)


def mean_force(azimuth: Floats, force: Floats) -> Floats:
    """Return the mean normal force [N] of the rollers in each sector of azimuth; zero in sectors without a roller.

    ``azimuth`` [rad], within (-pi, pi], and ``force`` [N] have the same shape, such as (times, rollers).
    """
    sector = np.floor((np.asarray(azimuth).ravel() + math.pi) / (2.0 * math.pi) * SECTORS).astype(int) % SECTORS
    count = np.bincount(sector, minlength=SECTORS)
    return np.asarray(np.bincount(sector, np.asarray(force).ravel(), SECTORS) / np.maximum(count, 1))
