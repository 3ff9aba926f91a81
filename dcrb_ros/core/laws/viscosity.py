"""Viscosity of lubricating oils over temperature and pressure.

Walther's equation, as in ASTM D341, with nu in mm^2/s and T in kelvin:

    lg lg(nu + 0.7) = A - B lg T

Roelands 1966, with the slope of Barus at p = 0 (Wingertszahn et al. 2023, Lubricants 11:369):

    eta_p = eta exp((ln eta + 9.67) ((1 + p/p_0)^Z - 1)),   Z = alpha p_0/(ln eta + 9.67),   p_0 = 1.962e8 Pa
"""

from __future__ import annotations

import math
from typing import NamedTuple

ZERO_CELSIUS = 273.15
"""[K]"""
COLDEST, HOTTEST = -40.0, 250.0
"""Temperatures between which Walther's equation is evaluated [deg C]; beyond them the nearer one counts."""
LEAST_VISCOSITY = 1e-3
"""[Pa s]; the equations lose their meaning for thinner fluids."""
ROELANDS_PRESSURE = 1.962e8
"""p_0 [Pa]."""
ROELANDS_OFFSET = 9.67
"""-ln of the viscosity at which all isotherms meet, 6.3e-5 Pa s [-]."""


class Lubricant(NamedTuple):
    """An oil, or the base oil of a grease."""

    viscosity_40: float
    """Kinematic viscosity at 40 deg C [mm^2/s]."""
    viscosity_100: float
    """Kinematic viscosity at 100 deg C [mm^2/s]."""
    density_15: float
    """Density at 15 deg C [kg/m^3]."""
    pressure_coefficient_40: float
    """Pressure coefficient alpha of the viscosity at 40 deg C [1/Pa]."""


def walther_constants(viscosity_40: float, viscosity_100: float) -> tuple[float, float]:
    """Return A and B of Walther's equation [-] from the kinematic viscosities at 40 and 100 deg C [mm^2/s]."""
    cold, hot = (math.log10(math.log10(viscosity + 0.7)) for viscosity in (viscosity_40, viscosity_100))
    colder, hotter = math.log10(40.0 + ZERO_CELSIUS), math.log10(100.0 + ZERO_CELSIUS)
    slope = (cold - hot) / (hotter - colder)
    return cold + slope * colder, slope


def kinematic_viscosity(lubricant: Lubricant, temperature: float) -> float:
    """Return nu [mm^2/s] at a temperature [deg C]."""
    a, b = walther_constants(lubricant.viscosity_40, lubricant.viscosity_100)
    kelvin = min(max(temperature, COLDEST), HOTTEST) + ZERO_CELSIUS
    return float(10.0 ** (10.0 ** (a - b * math.log10(kelvin))) - 0.7)


def density(lubricant: Lubricant, temperature: float) -> float:
    """Return the density [kg/m^3] at a temperature [deg C]."""
    return lubricant.density_15 - 0.65 * (temperature - 15.0)


def dynamic_viscosity(lubricant: Lubricant, temperature: float) -> float:
    """Return eta = nu rho [Pa s] at a temperature [deg C]."""
    return max(kinematic_viscosity(lubricant, temperature) * 1e-6 * density(lubricant, temperature), LEAST_VISCOSITY)


def temperature_coefficient(lubricant: Lubricant, temperature: float) -> float:
    """Return -d(ln nu)/dT [1/K] at a temperature [deg C], from a central difference over 1 K."""
    held = min(max(temperature, COLDEST + 0.5), HOTTEST - 0.5)
    return math.log(kinematic_viscosity(lubricant, held - 0.5) / kinematic_viscosity(lubricant, held + 0.5))


def pressure_coefficient(lubricant: Lubricant, temperature: float) -> float:
    """Return alpha [1/Pa] at a temperature [deg C]; its decay of 0.45 % per kelvin is a choice."""
    return lubricant.pressure_coefficient_40 * math.exp(-0.0045 * (temperature - 40.0))


def roelands_exponent(viscosity: float, alpha: float) -> float:
    """Return Roelands' Z [-] of a viscosity [Pa s] and a pressure coefficient [1/Pa]."""
    return alpha * ROELANDS_PRESSURE / (math.log(viscosity) + ROELANDS_OFFSET)
