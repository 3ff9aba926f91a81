"""Comparisons of the ball bearing with published orders, tables and factors; they need no simulation in time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from dcrb_ros.bearing.equilibrium import roller_forces, static_equilibrium
from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.laws.hertz import contact_ellipse, curvatures, stiffness_coefficient
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.loaded_contacts import material_of
from dcrb_ros.validation.report_row import ReportRow, about

CHAPTER = "Ball bearing"
BENCH = "ball_bearing_6205"
ORDERS = (0.39828, 3.5848, 5.4152, 4.7135)
"""FTF, BPFO, BPFI and twice BSF of a 6205-2RS, as Case Western Reserve's Bearing Data Center prints them."""
ANGLE = math.radians(40.0)
ANGULAR = (0.42199, 3.7979, 5.2021, 2.3964)
"""FTF, BPFO, BPFI and BSF of the same balls at a contact angle of 40 degrees, by hand from Randall and Antoni 2011, eqs. 1 to 4."""
TABLE = {
    0.3204: (1.2623, 0.8114, 0.9761),
    0.7332: (2.011, 0.5881, 0.8394),
    0.90999: (3.233, 0.4499, 0.6636),
    0.9729: (5.267, 0.3490, 0.4960),
}
"""a*, b* and delta* over the curvature difference: Harris and Kotzalas 2007, Table 6.1."""
STEEL_FACTOR = 2.15e5
"""K sum(rho)^0.5 delta*^1.5 of steel balls [N/mm^2]: Harris and Kotzalas 2007, eq. 7.3."""
STRIBECK = 4.37
"""Largest ball load over the mean, Q z/F, without clearance: Stribeck's number for point contacts, Harris and Kotzalas 2007, eq. 7.22."""
HEAVY, TIGHT = 2000.0, 1e-8
"""Load [N] and radial gap [m] of the comparison with it: the gap is far below the approach of the balls."""


def ball_rows() -> Iterator[ReportRow]:
    """Yield the comparisons of orders, contact ellipse, stiffness and load distribution."""
    bench = load_configuration(BENCH)
    orders = characteristic_orders(bench.bearing)
    values = (orders.ftf, orders.bpfo, orders.bpfi, 2.0 * orders.bsf)
    yield about(CHAPTER, "FTF, BPFO, BPFI and 2 BSF of a 6205", values, ORDERS, 1e-3)
    angular = characteristic_orders(angular_bench().bearing)
    yield about(CHAPTER, "FTF, BPFO, BPFI and BSF at 40 degrees", tuple(angular.as_dict().values()), ANGULAR, 1e-3)
    for difference, expected in TABLE.items():
        yield about(CHAPTER, f"a*, b* and delta* at a curvature difference of {difference}", contact_ellipse(difference), expected, 1e-3)
    curvature, _ = curvatures(dict(bench.contact), material_of(bench.bearing))
    coefficient = stiffness_coefficient(curvature, bench.bearing.effective_modulus)
    factor = coefficient * math.sqrt(curvature.total) * contact_ellipse(curvature.difference).approach ** 1.5 * 1e-6
    yield about(CHAPTER, "K sum(rho)^0.5 delta*^1.5 of steel", factor, STEEL_FACTOR, 5e-3, "N/mm^2")
    yield about(CHAPTER, "Largest ball load over the mean without clearance", largest_share(), STRIBECK, 0.02)


def angular_bench() -> Configuration:
    """Return the bench with the same balls at a contact angle of 40 degrees."""
    b = load_configuration(BENCH).bearing
    radius = b.roller_radius * math.cos(ANGLE)
    gap = 0.5 * b.radial_gap
    settings: dict[str, Any] = {
        "contact_angle": ANGLE,
        "roller_radius": radius,
        "inner_raceway_radius": b.pitch_radius - radius - gap,
        "outer_raceway_radius": b.pitch_radius + radius + gap,
    }
    return load_configuration(BENCH, [f"bearing.{key}={value!r}" for key, value in settings.items()])


def largest_share() -> float:
    """Return Q z/F of the most heavily loaded ball without clearance [-], in the static equilibrium of smooth surfaces."""
    b = load_configuration(BENCH).bearing
    tight = [
        f"bearing.inner_raceway_radius={b.pitch_radius - b.roller_radius - 0.5 * TIGHT!r}",
        f"bearing.outer_raceway_radius={b.pitch_radius + b.roller_radius + 0.5 * TIGHT!r}",
        f"operating.load={HEAVY!r}",
    ]
    bench = load_configuration(BENCH, [*tight, "surfaces.law=smooth", "lubrication.law=dry", "operating.gravity=0.0"])
    payload = build_payload(bench)
    rest = static_equilibrium(payload, np.array([0.0, -HEAVY]))
    inner, _ = roller_forces(payload, rest.outer, rest.inner, rest.rollers)
    return float(np.linalg.norm(inner, axis=-1).max()) * b.rollers_per_row / HEAVY
