"""The lubricant in a bearing: at the temperatures of its contacts, and after the loss of a part of it."""

from __future__ import annotations

from typing import Any

from dcrb_ros.core.laws import LUBRICATION_LAWS, lugre
from dcrb_ros.core.laws.film import MICRO_SLIP
from dcrb_ros.core.laws.lubricants import LAYERS, OIL_SHARES, lubricant_of
from dcrb_ros.core.laws.site import Material
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.oil_limits import held

LAST_LAYER = 0.02e-6
"""Layer of a bearing that has lost all lubricant [m] (a choice)."""
LAST_SHARE = 1e-6
"""Share of the oil about the rollers of such a bearing [-], above 0, which would stand for the usual one."""
DRY_FRICTION = 0.30
"""Friction coefficient of steel without lubricant, at asperities, bars and lands [-] (a choice)."""
SMEARING = 0.016
"""Slip of asperities in rolling that smearing and skew add without lubricant [-] (a choice)."""


def remaining(configuration: Configuration, loss: float) -> dict[str, Any]:
    """Return the parameters of lubrication after the share ``loss`` of the lubricant is lost; all of it leaves `LAST_LAYER`.

    With the share x, the layer is H (1 - x) + H_last x, the oil at bars, lands and about the rollers goes with 1 - x, the friction of
    asperities is mu_b + (0.30 - mu_b) x^2, and their slip in rolling 0.004 + 0.016 x^3. An overfill adds to the share about the rollers.
    """
    values = dict(configuration.lubrication)
    filled = (values["oil_share"] or OIL_SHARES[values["lubricant"]]) + configuration.faults.condition.oil_share
    if loss == 0.0:
        return values | {"oil_share": filled}
    layer, boundary = values["layer"] or LAYERS[values["lubricant"]], values["boundary_friction"]
    return values | {
        "layer": layer * (1.0 - loss) + min(LAST_LAYER, layer) * loss,
        "land_fill": values["land_fill"] * (1.0 - loss),
        "oil_share": filled * max(1.0 - loss, LAST_SHARE),
        "pocket_layer": values["pocket_layer"] * (1.0 - loss),
        "boundary_friction": boundary + max(DRY_FRICTION - boundary, 0.0) * loss**2,
        "micro_slip": MICRO_SLIP + SMEARING * loss**3,
    }


def lubrication_at(configuration: Configuration, material: Material, loss: float, inner: float, outer: float) -> Any:
    """Return the constants of lubrication after a loss [-], with lubricant of two temperatures at the raceways' inlets [deg C].

    Temperatures beyond the range of the formulas count as its ends.
    """
    law, values = LUBRICATION_LAWS[configuration.lubrication.law], remaining(configuration, loss)
    if law.warmed is None:
        return law.build(values, material)
    lubricant, name = lubricant_of(values), configuration.lubrication.law
    return law.warmed(values, material, held(lubricant, name, inner), held(lubricant, name, outer))


def cage_friction_of(configuration: Configuration, material: Material, loss: float) -> lugre.LuGre:
    """Return the constants of friction at bars and lands after a loss [-]: mu + (0.30 - mu) x^2."""
    mu = configuration.cage.friction_coefficient
    if loss > 0.0:
        mu += max(DRY_FRICTION - mu, 0.0) * loss**2
    return lugre.build(dict(configuration.friction) | {"kinetic_coefficient": mu, "static_coefficient": mu}, material)
