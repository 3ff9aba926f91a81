"""Warnings of configurations that are valid but outside the range where the model is realistic, or other than they seem."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dcrb_ros.faults.raceway_defect import NOTCH, RacewayDefect
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Bearing, rpm

LOAD_FACTOR = 0.2
"""k_r of cylindrical roller bearings of the series 22 in SKF's catalogue [-]."""
REFERENCE_SPEED = 5.5e5
"""Reference speed times mean diameter of these bearings [mm/min] (a choice within their 5 to 6e5)."""
RATTLE = 1.5
"""Load below which healthy bearings of the default size had blows, over SKF's minimum load [-]; docs/results/realism.md."""
LEAST_SPEED = 2.5e5
"""Product of mean diameter and speed below which they had none at any load [mm/min]."""


def implausible(configuration: Configuration) -> Iterator[str]:
    """Yield a sentence for each value with which the signal may differ from what a user expects."""
    yield from light_load(configuration)
    yield from whole_length(configuration)


def minimum_load(bearing: Bearing, speed: float) -> float:
    """Return SKF's minimum load of a cylindrical roller bearing, F_rm = k_r (6 + 4 n/n_r) (d_m/100)^2 in kN for each row [N].

    n is the ``speed`` of the inner ring [rad/s], n_r the reference speed, d_m the mean diameter [mm], here that of the pitch circle
    (SKF, *Rolling bearings*, "Cylindrical roller bearings, loads").
    """
    mean = 2e3 * bearing.pitch_radius
    return 1e3 * bearing.rows * LOAD_FACTOR * (6.0 + 4.0 * abs(rpm(speed)) * mean / REFERENCE_SPEED) * (1e-2 * mean) ** 2


def light_load(c: Configuration) -> Iterator[str]:
    """Warn of a fast bearing under a light load: the oil of the lands carries none, so the cage strikes them."""
    if c.lubrication.law != "film_with_cages" or 2e3 * c.bearing.pitch_radius * abs(rpm(c.operating.speed)) < LEAST_SPEED:
        return
    skf, load = minimum_load(c.bearing, c.operating.speed), math.hypot(c.operating.load, c.operating.lateral_load)
    if load < RATTLE * skf:
        yield (
            f"a load of {load / 1e3:.3g} kN is below {RATTLE * skf / 1e3:.3g} kN, under which the model rattles at "
            f"{abs(rpm(c.operating.speed)):.4g} rpm: the cage strikes its lands, and a healthy signal has impulses. Increase "
            f"operating.load (the minimum load of SKF's catalogue is {skf / 1e3:.3g} kN) or reduce operating.speed"
        )


def whole_length(c: Configuration) -> Iterator[str]:
    """Warn of notches in bearings whose surfaces could have a spall."""
    if c.surfaces.law != "profile":
        return
    for key, fault in c.faults.present():
        if isinstance(fault, RacewayDefect) and fault.kind == NOTCH:
            yield (
                f"faults.{key}.kind = {NOTCH} is a groove {1e3 * fault.depth:g} mm deep across the whole raceway, several times as loud as "
                f"a spall of the same width: set faults.{key}.kind to spall, with a depth and a share of the length, for damage by fatigue"
            )
