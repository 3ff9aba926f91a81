"""What follows from a configuration: speeds, loads, clearances and characteristic frequencies, rounded for people."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dcrb_ros.bearing.fault_lines import BearingLike, orders_of
from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.faults.ground_truth import summary_of
from dcrb_ros.prognosis.rating_life import dynamic_load_rating
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.loaded_contacts import heaviest
from dcrb_ros.settings.parameters import STEEL_DENSITY, Bearing, rpm

ALIKE = 0.01
"""Largest relative difference of dimensions that leaves masses as they are [-]."""
LEAST_SHARE = 0.001
"""Least plausible load over the dynamic load rating [-]."""
DEPENDENCES = {
    "roller_mass": ("roller_radius", "roller_length"),
    "roller_inertia": ("roller_radius", "roller_length"),
    "cage_mass": ("pitch_radius", "roller_length", "rollers_per_row"),
    "cage_inertia": ("pitch_radius", "roller_length", "rollers_per_row"),
    "inner_ring_mass": ("inner_raceway_radius", "roller_length", "rows"),
    "outer_ring_mass": ("outer_raceway_radius", "roller_length", "rows"),
}
"""Masses and moments of inertia, with the dimensions on which they depend."""


def data_sheet(configuration: Configuration) -> dict[str, str]:
    """Return what follows from a configuration: texts with units, by what they describe."""
    bearing, operating = configuration.bearing, configuration.operating
    shaft = operating.speed / (2.0 * math.pi)
    orders = characteristic_orders(bearing).as_dict()
    load = math.hypot(operating.load, operating.lateral_load)
    step, rate = configuration.simulation.step, configuration.sensor.sampling_rate
    angle = f", contact angle {math.degrees(bearing.contact_angle):.4g} degrees" if bearing.contact_angle else ""
    normal, law = heaviest(configuration) / math.cos(bearing.contact_angle), "5 F/(z cos alpha)" if bearing.contact_angle else "5 F/z"
    return {
        "bearing": f"{_rows(bearing)} of {bearing.rollers_per_row} rollers, {2e3 * bearing.own_roller_radius:.4g} mm in diameter and "
        f"{1e3 * bearing.roller_length:.4g} mm long, on a pitch circle of {2e3 * bearing.pitch_radius:.4g} mm{angle}",
        "internal clearance": f"{2e6 * bearing.radial_gap:.4g} um, twice the radial gap",
        "speed": f"{rpm(operating.speed):.5g} rpm, shaft frequency {abs(shaft):.4g} Hz",
        "load": f"{load / 1e3:.4g} kN; about {normal / 1e3:.3g} kN on the most heavily loaded roller (Stribeck: {law})",
        "orders": ", ".join(f"{name} {order:.4f}" for name, order in orders.items()),
        "frequencies": ", ".join(f"{name} {order * abs(shaft):.2f}" for name, order in orders.items()) + " Hz",
        "time step": f"{1e6 * step:.4g} us, {configuration.steps_per_sample} for a sample at {rate / 1e3:g} kHz",
        "faults": summary_of(configuration.described_faults()),
        "lubrication": _lubrication(configuration),
    }


def _lubrication(c: Configuration) -> str:
    """Return oil, surfaces, masses around the bearing and, where they are those of the paper, how to get the lubricated ones."""
    film = c.lubrication.law != "dry"
    oil = f"film of {c.lubrication.lubricant} at {c.lubrication.temperature:g} deg C" if film else "dry"
    surfaces = "smooth surfaces" if c.surfaces.law == "smooth" else f"profiles of individual {c.surfaces.seed or c.simulation.seed}"
    masses = f"axle box of {c.housing.box_mass:g} kg, axle of {c.housing.axle_mass:g} kg"
    parts = [oil, surfaces, masses if c.housing.box_mass or c.housing.axle_mass else "no axle box, no axle"]
    if math.isclose(c.bearing.radial_gap, Bearing().radial_gap, rel_tol=1e-6):
        parts.append("the paper's clearance, beyond C5 of ISO 5753")
    if film:
        return ", ".join(parts)
    return f"{', '.join(parts)}; for a bearing as in service, start from config/healthy.yaml, which `dcrb config show healthy` prints"


def _rows(bearing: Bearing) -> str:
    return "1 row" if bearing.rows == 1 else f"{bearing.rows} rows"


def kept_defaults(bearing: Bearing) -> Iterator[str]:
    """Yield a sentence for each mass or moment of inertia of the default bearing in a bearing of other dimensions."""
    default = Bearing()
    for key, dimensions in DEPENDENCES.items():
        changed = [name for name in dimensions if abs(getattr(bearing, name) - getattr(default, name)) > ALIKE * getattr(default, name)]
        value, unit = getattr(bearing, key), "kg m^2" if key.endswith("inertia") else "kg"
        if changed and value == getattr(default, key):
            other = f"{changed[0]} = {getattr(bearing, changed[0]):g}, not {getattr(default, changed[0]):g}"
            yield f"bearing.{key} = {value:g} {unit} is that of the default bearing, but this one has {other}: {_remedy(key, bearing)}"


def implausible_loads(configuration: Configuration) -> Iterator[str]:
    """Yield a sentence if the load is negative, or too small for rollers that roll."""
    load, rating = configuration.operating.load, dynamic_load_rating(configuration.bearing)
    if load < 0.0:
        yield f"operating.load = {load:g} N is negative, so the load zone is at the top: give a positive load, unless that is intended"
    total = math.hypot(load, configuration.operating.lateral_load)
    if total < LEAST_SHARE * rating:
        yield (
            f"the load of {total:g} N is below {LEAST_SHARE:g} of the load rating of {rating / 1e3:.4g} kN, at which rollers skid: give at "
            f"least {LEAST_SHARE * rating:.3g} N, and check the unit"
        )


def _remedy(key: str, bearing: Bearing) -> str:
    """Return how to find a mass or a moment of inertia."""
    radius = bearing.own_roller_radius
    solid = STEEL_DENSITY * math.pi * radius**2 * bearing.roller_length
    return {
        "roller_mass": f"a roller of solid steel has {solid:.3g} kg",
        "roller_inertia": f"a roller of solid steel has {0.5 * solid * radius**2:.3g} kg m^2",
        "cage_inertia": f"a thin cage has mass * pitch_radius^2, here {bearing.cage_mass * bearing.pitch_radius**2:.3g} kg m^2",
    }.get(key, f"take it from a drawing or a catalogue, or estimate it as solid steel of {STEEL_DENSITY:g} kg/m^3")


def characteristic_frequencies(bearing: BearingLike | str, speed: float) -> dict[str, float]:
    """Return the frequencies at which the parts of a bearing pass each other, for pure rolling.

    With the shaft frequency f, the ratio q = D cos(alpha) / d_m of the diameters and Z rollers per row (Fan et al. 2025, Eqs. 43 to 45)

        FTF = f (1 - q) / 2,  BPFO = Z FTF,  BPFI = Z (f - FTF),  BSF = f (d_m / D) (1 - q^2) / 2

    Parameters
    ----------
    bearing
        Geometry (`dcrb_ros.Bearing`), a configuration, orders, or the name or file of a configuration such as ``"healthy"``.
    speed
        Speed of the inner ring [rad/s]; its sign does not matter.

    Returns
    -------
    dict
        FTF (cage), BPFO (outer ring), BPFI (inner ring) and BSF (roller spin) by name [Hz]. A roller defect strikes at twice BSF.

    Raises
    ------
    Refusal
        A speed that is not finite, or an unknown configuration.

    Examples
    --------
    >>> frequencies = characteristic_frequencies("healthy", 125.664)
    >>> {name: round(value, 1) for name, value in frequencies.items()}
    {'FTF': 8.4, 'BPFO': 134.5, 'BPFI': 185.5, 'BSF': 61.1}
    """
    source = load_configuration(bearing) if isinstance(bearing, str) else bearing
    return orders_of(source).frequencies(finite_number("speed =", speed, "rad/s") / (2.0 * math.pi))
