"""Profiles of surfaces as the kernels take them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dcrb_ros.core.contacts.profile import profiles_under
from dcrb_ros.core.payload import PROFILE, Payload, Profiles
from dcrb_ros.faults.geometry import SurfaceProfile
from dcrb_ros.schema.arrays import Floats

BODIES = ("inner_ring", "outer_ring", "roller")
LEAST_SAMPLES = 4


def profile_records(profiles: Sequence[SurfaceProfile]) -> tuple[Profiles, Floats, float]:
    """Return the records of profiles, their samples one after the other [m], and how far the highest rises [m].

    Raises:
        ValueError: a profile has too few samples, or one that is no finite number, or it overlaps itself.
    """
    records, first = [], 0
    for profile in profiles:
        count, periodic = len(profile.depths), profile.spacing == 0.0
        if count < LEAST_SAMPLES or not np.isfinite(profile.depths).all():
            raise ValueError(f"a profile of the {profile.body} has {count} samples: give at least {LEAST_SAMPLES}, all of them finite")
        spacing = 2.0 * math.pi / count if periodic else profile.spacing
        if not periodic and not 0.0 < spacing * (count + 2) < 2.0 * math.pi:
            raise ValueError(f"{count} samples {spacing:g} rad apart do not fit on the {profile.body}: make it periodic or shorter")
        records.append((BODIES.index(profile.body), profile.row, profile.roller, profile.azimuth, spacing, first, count, periodic))
        first += count
    depths = np.concatenate([np.zeros(0), *(np.asarray(profile.depths, np.float64) for profile in profiles)])
    return np.array(records, PROFILE).view(np.recarray), depths, float(max(-depths.min(initial=0.0), 0.0))


def profile_depths(payload: Payload, from_ring: Floats, inner: bool) -> Floats:
    """Return the depth of the profiles at the contacts, at shaft and spin angle zero, shape (rows, rollers) [m]."""
    found = np.zeros(payload.free.shape)
    if payload.profiles.row.size > 0:
        for row, i in np.ndindex(*found.shape):
            x, y = from_ring[row, i] / np.linalg.norm(from_ring[row, i])
            found[row, i] = _depth_under(payload, row, i, float(x), float(y), inner)
    return found


def _depth_under(payload: Payload, row: int, i: int, nx: float, ny: float, inner: bool) -> float:
    under = getattr(profiles_under, "py_func", profiles_under)
    depth: float = under(payload, row, i, nx, ny, 0.0, 0.0, 0.0, 0.0, 0.0, inner)[0]
    return depth
