"""Basic rating life of cylindrical roller bearings (ISO 281:2007) and their load zone (ISO/TS 16281:2008), and the scatter of single lives.

Sources: ISO 281:2007, clauses 7 and 8; ISO/TR 1281-1 for the factor in closed form; ISO/TS 16281:2008, 5.3, for the load zone; Lundberg and
Palmgren, Dynamic capacity of roller bearings, Acta Polytechnica 96 (1952), for the Weibull slope. Lubrication, contamination and
reliability factors (a_ISO, a_1) are 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from dcrb_ros.schema.arguments import checked_arguments, number, with_attributes
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

LIFE_EXPONENT = 10.0 / 3.0
"""Exponent p of the load in the life of roller bearings [-]."""
RATING_FACTOR = 1.1
"""Factor b_m of cylindrical roller bearings of contemporary steel [-], ISO 281 Table 6."""
LIFE_MODEL = "ISO/TS 16281 load zone"
"""Name of `reference_load` with `rating_life`, for the record of what is drawn from them."""
ROLLER_SLOPE = 9.0 / 8.0
"""Weibull slope e of lives in line contact [-]."""
SURVIVAL = 0.9
"""Share of bearings that reach the basic rating life [-]."""


class RollerBearing(Protocol):
    """Dimensions from which a load rating follows; `dcrb_ros.Bearing` has them."""

    @property
    def rows(self) -> int: ...
    @property
    def rollers_per_row(self) -> int: ...
    @property
    def roller_length(self) -> float: ...
    @property
    def roller_radius(self) -> float: ...
    @property
    def pitch_radius(self) -> float: ...
    @property
    def contact_angle(self) -> float: ...


def load_rating_factor(ratio: float) -> float:
    """Return the factor f_c of radial roller bearings [N, mm].

    f_c = 207.9 * 0.83 g^(2/9) (1 - g)^(29/27) / (1 + g)^(1/4) * {1 + [1.04 ((1 - g) / (1 + g))^(143/108)]^(9/2)}^(-2/9)

    ``ratio`` is g, the diameter of the rollers times cos a over that of the pitch circle [-]. ISO 281 Table 7 lists its values.
    """
    inner = ratio ** (2.0 / 9.0) * (1.0 - ratio) ** (29.0 / 27.0) / (1.0 + ratio) ** 0.25
    outer = (1.04 * ((1.0 - ratio) / (1.0 + ratio)) ** (143.0 / 108.0)) ** 4.5
    return float(207.9 * 0.83 * inner * (1.0 + outer) ** (-2.0 / 9.0))


@checked_arguments(
    bearing=with_attributes("contact_angle", "roller_radius", "roller_length", "pitch_radius", "rows", "rollers_per_row", kind="a Bearing")
)
def dynamic_load_rating(bearing: RollerBearing) -> float:
    """Return the basic dynamic radial load rating of a cylindrical roller bearing, C = b_m f_c (i L cos a)^(7/9) Z^(3/4) D^(29/27) [N].

    i are its rows, Z its rollers per row, L the effective length and D the diameter of a roller [mm], a its contact angle (ISO 281:2007).
    A manufacturer's own rating may be higher. Tapered rollers have the same b_m of 1.1, spherical ones 1.15.

    Parameters
    ----------
    bearing
        Dimensions of the bearing, such as ``configuration.bearing``.

    Examples
    --------
    >>> import dcrb_ros
    >>> f"{dynamic_load_rating(dcrb_ros.Bearing()) / 1e3:.0f} kN"
    '1047 kN'
    """
    cosine = math.cos(bearing.contact_angle)
    diameter, length = 2e3 * bearing.roller_radius / cosine, 1e3 * bearing.roller_length * cosine
    factor = load_rating_factor(bearing.roller_radius / bearing.pitch_radius)
    size = (bearing.rows * length) ** (7.0 / 9.0) * bearing.rollers_per_row**0.75 * diameter ** (29.0 / 27.0)
    return float(RATING_FACTOR * factor * size)


def roller_ratings(bearing: RollerBearing, rating: float) -> tuple[float, float]:
    """Return the dynamic load ratings of a roller at the inner raceway, which rotates, and at the outer one, which is at rest [N].

    Q_ci = C / (0.378 Z i^(7/9)) {1 + x^(9/2)}^(2/9), Q_ce = C / (0.364 Z i^(7/9)) {1 + x^(-9/2)}^(2/9),
    x = 1.038 ((1 - g) / (1 + g))^(143/108)

    C is the basic dynamic load rating of the bearing [N], Z its rollers per row, i its rows, g the diameter of the rollers in the plane
    over that of the pitch circle. The ratings are those of the force in the plane, in which the cosine of a contact angle cancels. Source:
    ISO/TS 16281:2008, 5.3.1.2, without its factor 1 / 0.83: that factor takes the edge stress out of C, because the standard adds it again
    lamina by lamina. Here C keeps it.
    """
    ratio = bearing.roller_radius / bearing.pitch_radius
    raceways = 1.038 * ((1.0 - ratio) / (1.0 + ratio)) ** (143.0 / 108.0)
    share = rating / (bearing.rollers_per_row * bearing.rows ** (7.0 / 9.0))
    return share / 0.378 * (1.0 + raceways**4.5) ** (2.0 / 9.0), share / 0.364 * (1.0 + raceways**-4.5) ** (2.0 / 9.0)


def reference_load(bearing: RollerBearing, rating: float, roller_loads: Floats) -> float:
    """Return the equivalent load of a load zone: the one that causes the same fatigue with the load zone of ISO 281, zero clearance [N].

    P_ref = C [i ((Q_ci / Q_ei)^(-9/2) + (Q_ce / Q_ee)^(-9/2))]^(2/9), Q_ei = (mean Q^4)^(1/4), Q_ee = (mean Q^(9/2))^(2/9)

    The mean is over the rollers of a row; all rows carry the same loads, and the rings do not tilt. The inner ring rotates. Source:
    ISO/TS 16281:2008, 5.3, without laminae. The standard raises the bracket to -8/9, a life of the power 4 of the load, which agrees with
    ISO 281 only for P = C. `rating_life` of P_ref keeps the power 10/3 of ISO 281, and agrees with it at zero clearance for every load.

    Parameters
    ----------
    bearing
        Dimensions of the bearing.
    rating
        Basic dynamic load rating C [N].
    roller_loads
        Forces of the rollers of a row in the plane, shape (positions, rollers) [N]; 0 outside the load zone.
    """
    inner, outer = roller_ratings(bearing, rating)
    loads = np.asarray(roller_loads, np.float64)
    shares = np.mean((loads / inner) ** 4.0) ** (9.0 / 8.0) + np.mean((loads / outer) ** 4.5)
    return float(rating * (bearing.rows * shares) ** (2.0 / 9.0))


def equivalent_load(loads: Sequence[float], revolutions: Sequence[float]) -> float:
    """Return the constant load P = (sum P_i^p N_i / sum N_i)^(1/p) under which a bearing lives as long as under a spectrum [N].

    Parameters
    ----------
    loads
        Loads P_i, shape (sections,) [N].
    revolutions
        Revolutions N_i at each, shape (sections,) [-].

    Raises
    ------
    Refusal
        There are no revolutions, or the shapes differ.
    """
    load, turns = np.abs(np.asarray(loads, np.float64)), np.asarray(revolutions, np.float64)
    if load.shape != turns.shape or load.ndim != 1:
        raise Refusal(f"{load.size} loads and {turns.size} revolutions do not belong together: give a number of revolutions for each load")
    if not (turns >= 0.0).all() or not turns.sum() > 0.0:
        raise Refusal("the load spectrum has no revolutions, so no rating life follows from it: give a load with revolutions above 0")
    # Products with the smallest floats lose their digits. A power of two changes no other number's.
    shares = np.ldexp(turns, -np.frexp(turns.max())[1])
    return float((np.sum(load**LIFE_EXPONENT * shares) / np.sum(shares)) ** (1.0 / LIFE_EXPONENT))


@checked_arguments(rating=number, load=number)
def rating_life(rating: float, load: float) -> float:
    """Return the basic rating life L10 = 10^6 (C / P)^(10/3) in revolutions [-], which 90 % of the bearings reach (ISO 281:2007).

    Parameters
    ----------
    rating
        Basic dynamic load rating C [N].
    load
        Equivalent load P [N]; `reference_load` with a clearance.

    Raises
    ------
    Refusal
        The rating or the load is not above 0: without load there is no fatigue, and no life ends. Or their ratio is so large that no
        number can hold the life.

    Examples
    --------
    >>> import dcrb_ros
    >>> bearing = dcrb_ros.Bearing()
    >>> f"{rating_life(dynamic_load_rating(bearing), 100e3) / 1e6:.0f} million revolutions"
    '2509 million revolutions'
    """
    if not (rating > 0.0 and load > 0.0 and math.isfinite(rating) and math.isfinite(load)):
        raise Refusal(f"a load rating of {rating:g} N and a load of {load:g} N give no rating life: both must be above 0 N and finite")
    try:
        life = float(1e6 * float(rating / load) ** LIFE_EXPONENT)
    except OverflowError:
        life = math.inf
    if math.isinf(life):
        raise Refusal(f"a load rating of {rating:g} N over a load of {load:g} N gives a life beyond every number: check the units of both")
    return life


def survivors(life: float, rating: float, slope: float = ROLLER_SLOPE) -> float:
    """Return the share of bearings that live longer than ``life``, S = 0.9^((L / L10)^e) [-]; both lives in the same unit."""
    return float(SURVIVAL ** ((life / rating) ** slope))


def life_survived_by(share: float, rating: float, slope: float = ROLLER_SLOPE) -> float:
    """Return the life that a ``share`` [-] of bearings exceeds, L10 (ln S / ln 0.9)^(1/e): the inverse of `survivors`.

    A share drawn uniformly from 0 to 1 gives the life of one bearing, whose distribution is Weibull's with the slope ``slope``.
    """
    return float(rating * (math.log(share) / math.log(SURVIVAL)) ** (1.0 / slope))
