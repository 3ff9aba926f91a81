"""Contact, friction and lubrication: the choices of registered laws, the parameters that these declare, and the common ones.

Apart from the other groups, because the laws bring numba with them.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast

from pydantic import create_model

from dcrb_ros.core.laws import LUBRICATION_LAWS, NORMAL_LAWS, TRACTION_LAWS
from dcrb_ros.core.laws.interface import NormalLaw, Parameter, TractionLaw
from dcrb_ros.core.laws.lubricants import LAYERS
from dcrb_ros.schema.fields import LENGTH_REMEDY, Group, choice, length, quantity
from dcrb_ros.schema.refusal import Refusal

AnyGroup = TypeVar("AnyGroup", bound=Group)


def _check(parameter: Parameter, taken: Container[str], law: str) -> None:
    """Refuse a parameter of a law that would replace another one, or whose default the user could not give."""
    if parameter.name in taken:
        raise Refusal(f"{law}: a parameter '{parameter.name}' exists already: give it another name")
    low, high, default = parameter.low, parameter.high, parameter.default
    if not low <= default <= high:
        raise Refusal(f"{law}: the default {default!r} of '{parameter.name}' is outside {low:g} .. {high:g} {parameter.unit}: correct it")


def with_laws(laws: Mapping[str, NormalLaw] | Mapping[str, TractionLaw], subject: str) -> Callable[[type[AnyGroup]], type[AnyGroup]]:
    """Return a decorator that puts the choice of a law, as ``law``, and the laws' parameters before a group's own fields.

    ``subject`` begins the description of the choice.

    Raises:
        Refusal: a parameter has the name of another one or of a field of the group, or a default outside its range.
    """
    described = ", or ".join(f"{law.name}, {law.summary}" for law in laws.values())
    fields: dict[str, Any] = {"law": (Literal[tuple(laws)], choice(next(iter(laws)), f"{subject}: {described}"))}
    for law in laws.values():
        for p in law.parameters:
            _check(p, fields, f"{subject.lower()} law '{law.name}'")
            remedy = p.remedy or (LENGTH_REMEDY if p.unit == "m" else "")
            fields[p.name] = (type(p.default), quantity(p.default, p.unit, p.description, p.low, p.high, symbol=p.symbol, remedy=remedy))

    def decorate(group: type[AnyGroup]) -> type[AnyGroup]:
        common: dict[str, Any] = {name: (info.annotation, info) for name, info in group.model_fields.items()}
        for law in laws.values():
            for p in law.parameters:
                _check(p, common, f"{subject.lower()} law '{law.name}'")
        model = create_model(group.__name__, __base__=Group, __doc__=group.__doc__, __module__=group.__module__, **fields, **common)
        return cast(type[AnyGroup], model)

    return decorate


@with_laws(NORMAL_LAWS, "Normal force")
class Contact(Group):
    """Normal contact of rollers and raceways, its damping, and the law for notches."""

    if TYPE_CHECKING:
        law: str = ""

        def __getattr__(self, name: str) -> Any:
            """Return a parameter that a law declares."""

    loss_time: float = quantity(
        2.5e-6, "s", "Damping of the normal contact divided by its stiffness; 0 in the paper", 0.0, 1e-4, symbol="beta"
    )
    damping: float = quantity(0.0, "N s/m", "Constant damping of a closed contact, in addition to loss_time", 0.0, 1e5, symbol="c")
    notch: Literal["sink", "edge"] = choice(
        "sink",
        "Law for notches of smooth surfaces: sink lowers the raceway along its normal (the paper); edge gives each edge a fillet with its "
        "own normal",
    )
    edge_radius: float = length(0.0001, "Fillet radius of the edges of a notch, for the law edge", 1e-6, 0.005, symbol="rho")


@with_laws(TRACTION_LAWS, "Traction")
class Friction(Group):
    """Friction of rollers and raceways, in coefficient form."""

    if TYPE_CHECKING:
        law: str = ""

        def __getattr__(self, name: str) -> Any:
            """Return a parameter that a law declares."""


*_OILS, _LAST_OIL = [f"{law.name}, {law.summary}" for law in LUBRICATION_LAWS.values()]


class Lubrication(Group):
    """What is between rollers and raceways: a dry contact, for which only ``law`` counts, or an oil film at a constant temperature."""

    law: Literal[tuple(LUBRICATION_LAWS)] = choice("dry", f"Lubrication: {', '.join(_OILS)}, or {_LAST_OIL}")  # type: ignore[valid-type]
    lubricant: Literal[tuple(LAYERS)] = choice(  # type: ignore[valid-type]
        "grease", "Lubricant: a wheelset grease by its base oil, an oil of ISO VG 100 or 220, or custom, by the values below"
    )
    viscosity_40: float = quantity(100.0, "mm^2/s", "Kinematic viscosity at 40 deg C of a custom lubricant", 2.0, 2000.0, symbol="nu_40")
    viscosity_100: float = quantity(11.0, "mm^2/s", "Kinematic viscosity at 100 deg C of a custom lubricant", 1.0, 200.0, symbol="nu_100")
    density: float = quantity(890.0, "kg/m^3", "Density at 15 deg C of a custom lubricant", 700.0, 1200.0)
    pressure_coefficient: float = quantity(
        2.2e-8, "1/Pa", "Pressure coefficient of the viscosity at 40 deg C of a custom lubricant", 5e-9, 5e-8, symbol="alpha"
    )
    temperature: float = quantity(60.0, "deg C", "Temperature of the oil", -40.0, 250.0)
    layer: float = length(0.0, "Thickness of the oil layer; 0 for 5 um with grease and 50 um with oil", 0.0, 0.001, symbol="H")
    roughness: float = length(2.8e-7, "Combined roughness of roller and raceway, root mean square", 1e-9, 1e-5, symbol="sigma")
    boundary_friction: float = quantity(0.12, "-", "Friction coefficient of asperities", 0.001, 1.0, symbol="mu_b")
    limiting_friction: float = quantity(0.06, "-", "Largest traction coefficient of the film", 0.001, 1.0, symbol="mu_L")
    squeeze: bool = choice(True, "Whether the oil resists the approach of roller and raceway, roller and bar, cage and land")
    rolling_resistance: bool = choice(True, "Whether the oil resists rolling")
    pocket_layer: float = length(1e-4, "Thickness of the oil layer between roller and bar; 0 for none", 0.0, 0.001)
    land_fill: float = quantity(0.1, "-", "Share of the gap between cage and land that is filled with oil", 0.0, 1.0)
    oil_share: float = quantity(
        0.0, "-", "Share of oil in the space about the rollers; 0 for 0.005 with grease and 0.02 with oil", 0.0, 0.5
    )
