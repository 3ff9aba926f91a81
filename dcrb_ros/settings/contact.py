"""Contact and friction: the choice of laws, the parameters that the registered laws declare, and what is common to all of them.

Apart from the other groups, because the laws bring numba with them.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast

from pydantic import create_model

from dcrb_ros.core.laws import NORMAL_LAWS, TRACTION_LAWS
from dcrb_ros.core.laws.interface import NormalLaw, Parameter, TractionLaw
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
        own: dict[str, Any] = {name: (info.annotation, info) for name, info in group.model_fields.items()}
        for law in laws.values():
            for p in law.parameters:
                _check(p, own, f"{subject.lower()} law '{law.name}'")
        made = create_model(group.__name__, __base__=Group, __doc__=group.__doc__, __module__=group.__module__, **fields, **own)
        return cast(type[AnyGroup], made)

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
        "sink", "Law for notches: sink lowers the raceway along its normal (the paper); edge gives each edge a fillet with its own normal"
    )
    edge_radius: float = length(0.0001, "Fillet radius of the edges of a notch, for the law edge", 1e-6, 0.005, symbol="rho")


@with_laws(TRACTION_LAWS, "Traction")
class Friction(Group):
    """Friction of rollers and raceways, in coefficient form."""

    if TYPE_CHECKING:
        law: str = ""

        def __getattr__(self, name: str) -> Any:
            """Return a parameter that a law declares."""
