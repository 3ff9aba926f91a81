"""What a contact law consists of, and how kernels call the law that a bearing was built with.

A law is chosen by the type of its constants, when a kernel is compiled: there is no branch at run time, and a bearing with another law
has kernels of its own. `docs/how-to/add-a-law.md` adds one.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar, cast

from numba.extending import overload

from dcrb_ros.core.jit import INLINED

Function = TypeVar("Function", bound=Callable[..., Any])


class NoMemory(NamedTuple):
    """Memory of a law that has none."""


class Site(NamedTuple):
    """Where a law acts: the geometry of the contact of a roller with a raceway, or with another roller."""

    number: int
    """0 at the inner raceway, 1 at the outer one, 2 between two rollers."""
    raceway_radius: float
    """Radius of the other body [m]."""
    scale: float
    """4 dR [m]; dR is r_I + r_R at the inner raceway, r_O - r_R at the outer one, 2 r_R between two rollers."""
    width: float
    """Square of the contact's half-width over the normal force, 4 R/(pi L E*) [m^2/N]."""
    reduced_radius: float
    """R [m]: 1/R is the sum of both curvatures."""
    film: Any
    """The film at the present speed, as the bearing's law of lubrication describes it."""
    memory: Any
    """What the film remembers of the contact; see `LubricationLaw.memory`."""


class Material(NamedTuple):
    """Of rings and rollers: what the constants of a law may depend on beside its parameters."""

    effective_modulus: float
    """E* [Pa]."""
    roller_length: float
    """L [m]."""
    roller_radius: float
    """r_R [m]."""
    roller_mass: float
    """m_R [kg]."""
    inner_raceway_radius: float
    """r_I [m]."""
    outer_raceway_radius: float
    """r_O [m]."""


def inner_site(material: Material, film: Any = None) -> Site:
    """Return the contact of a roller with the inner raceway."""
    roller, raceway = material.roller_radius, material.inner_raceway_radius
    radius = 1.0 / (1.0 / roller + 1.0 / raceway)
    return Site(0, raceway, 4.0 * (raceway + roller), _width(material) / (1.0 / roller + 1.0 / raceway), radius, film, NoMemory())


def outer_site(material: Material, film: Any = None) -> Site:
    """Return the contact of a roller with the outer raceway."""
    roller, raceway = material.roller_radius, material.outer_raceway_radius
    radius = 1.0 / (1.0 / roller - 1.0 / raceway)
    return Site(1, raceway, 4.0 * (raceway - roller), _width(material) / (1.0 / roller - 1.0 / raceway), radius, film, NoMemory())


def pair_site(material: Material, film: Any = None) -> Site:
    """Return the contact of two rollers."""
    roller = material.roller_radius
    return Site(2, roller, 8.0 * roller, 0.5 * _width(material) * roller, 0.5 * roller, film, NoMemory())


def _width(material: Material) -> float:
    return 4.0 / (math.pi * material.roller_length * material.effective_modulus)


@dataclass(frozen=True)
class Parameter:
    """A parameter that the user may set: ``contact.<name>`` of a law of the normal force, ``friction.<name>`` of one of traction."""

    name: str
    default: float
    unit: str
    description: str
    low: float
    high: float
    symbol: str = ""
    remedy: str = ""
    """Advice that a refusal gives."""


class NothingKept(NamedTuple):
    """What a traction law keeps for the end of a step that needs nothing."""


def _no_range(law: Any) -> float:
    return 0.0


def _no_damping(law: Any, memory: Any, site: Site, begin: float, way: float, force: float, stiffness: float) -> float:
    return 0.0


def _same_memory(law: Any, memory: Any, penetration: float, closing: float, step: float) -> Any:
    return memory


@dataclass(frozen=True)
class NormalLaw:
    """A law of the normal force between rollers and raceways, and between two rollers.

    Kernels are made by `dcrb_ros.core.jit.kernel`. ``law`` stands for the constants, ``memory`` for the memory at one contact.
    """

    name: str
    """Value of ``contact.law``."""
    summary: str
    """For the description of ``contact.law``."""
    constants: type
    """NamedTuple of floats (or arrays) that the kernels get as ``law``."""
    build: Callable[[Mapping[str, float], Material], Any]
    """Return the constants, from the values of the parameters and the material."""
    force: Callable[..., tuple[float, float]]
    """Kernel (law, memory, penetration, site): elastic force [N] and stiffness [N/m] at a penetration [m] above -range."""
    energy: Callable[..., Any]
    """Kernel (law, memory, penetration, force): energy stored [J] at a penetration [m] under its elastic force [N]. Plain arithmetic, so
    that it takes arrays, too."""
    penetration: Callable[..., Any]
    """Function (law, force, site): penetration [m] under a force above zero [N]. Plain arithmetic and numpy's functions for arrays."""
    stiffness: Callable[..., Any]
    """Function (law, force, site): slope of the elastic force [N/m] under a force above zero [N]."""
    forces: Callable[..., tuple[Any, Any]] | None = None
    """Function (law, penetration, site): force and stiffness over arrays, zero where the contact is open; without it, from ``force``."""
    range: Callable[..., float] = _no_range
    """Kernel (law): gap up to which the law acts on open contacts [m]."""
    damping: Callable[..., float] = _no_damping
    """Kernel (law, memory, site, begin, way, force, stiffness): mean damping [N s/m] beside ``contact.loss_time``, of a step that begins
    at the penetration ``begin`` [m] and ends ``way`` [m] deeper; ``force`` and ``stiffness`` are the elastic ones."""
    update: Callable[..., Any] = _same_memory
    """Kernel (law, memory, penetration, closing, step): memory after a step, ``penetration`` [m] in its middle at the speed ``closing``
    [m/s]."""
    memory: type = NoMemory
    """NamedTuple of floats kept at each contact from step to step, zero at first."""
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True)
class TractionLaw:
    """A law of traction between rollers and raceways, and between two rollers."""

    name: str
    """Value of ``friction.law``."""
    summary: str
    """For the description of ``friction.law``."""
    constants: type
    """NamedTuple of floats (or arrays) that the kernels get as ``law``."""
    build: Callable[[Mapping[str, float], Material], Any]
    """Return the constants, from the values of the parameters and the material."""
    line: Callable[..., tuple[float, float, Any]]
    """Kernel (law, memory, slip, rolling, force, site, step): friction per normal force as a line over the mean slip of the step.

    Returns its offset [-], its slope [s/m], which must not be below zero, and a NamedTuple ``kept``. ``slip`` [m/s] is the one predicted,
    ``rolling`` [m/s] the speed at which the raceway passes the contact, ``force`` [N] the normal force expected; ``rolling`` and ``site``
    are None between two rollers and at bars and lands."""
    update: Callable[..., Any]
    """Kernel (law, memory, kept, slip, closed, step): memory after a step, of the mean slip found [m/s]; ``closed`` says whether the
    contact was, ``kept`` is what the line returned."""
    memory: type = NoMemory
    """NamedTuple of floats kept at each contact from step to step, zero at first and after a contact has opened."""
    kept: type = NothingKept
    """NamedTuple of floats that the line hands to the update at the end of the step."""
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True)
class LubricationLaw:
    """What is between rollers and raceways: nothing, or an oil.

    A ``film`` is a NamedTuple of floats, the film of a raceway's contacts at the present speed. Its kernels get it in place of ``law``.
    """

    name: str
    """Value of ``lubrication.law``."""
    summary: str
    """For the description of ``lubrication.law``."""
    constants: type
    """NamedTuple that `film_at` gets as ``law``."""
    film: type
    """NamedTuple of floats."""
    build: Callable[[Mapping[str, Any], Material], Any]
    """Return the constants, from the values of the parameters and the material."""
    film_at: Callable[..., Any]
    """Kernel (law, number, speed): the film of raceway ``number`` (see `Site`) at a speed of rolling [m/s]; of contacts of two rollers,
    2, one that does nothing."""
    film_reach: Callable[..., float]
    """Kernel (film): gap up to which the film acts [m]."""
    film_offset: Callable[..., float]
    """Kernel (film): gap at which the elastic contact closes, the thickness of the film [m]."""
    film_lift: Callable[..., tuple[float, float]]
    """Kernel (film, gap): force [N] and stiffness [N/m] that hold the bodies apart, beside the elastic contact."""
    film_lift_energy: Callable[..., float]
    """Kernel (film, gap): integral of that force from the gap to infinity [J]."""
    film_damping: Callable[..., float]
    """Kernel (film, gap, way): mean damping [N s/m] over a step from a gap to one smaller by ``way`` [m]."""
    film_floor: Callable[..., float]
    """Kernel (film): gap below which the damping grows no more [m]."""
    film_squeeze: Callable[..., float]
    """Kernel (film, gap, closing): damping [N s/m] at a gap [m] that closes at a speed [m/s]; near `film_damping` over a short way."""
    steady_friction: Callable[..., tuple[float, float]]
    """Kernel (film, memory, friction, slip): speed [m/s] and coefficient [-] of steady sliding at a slip [m/s]. Their ratio is what counts;
    ``friction`` are the constants of LuGre's law."""
    film_memory: Callable[..., Any]
    """Kernel (film, force): memory of a contact under a normal force [N]."""
    film_resistance: Callable[..., float]
    """Kernel (film, memory, force): resistance of the contact to rolling [N], with the sign of its speed; zero without a force."""
    memory: type = NoMemory
    """NamedTuple of floats kept at each contact: what takes long to evaluate and changes little while a surface passes through it."""
    resists: bool = False
    """Whether the law has a resistance to rolling."""
    thickness: Callable[[Any, float], tuple[float, float]] | None = None
    """Function (film, force): film [m] under a normal force [N], and its ratio to the roughness [-]; None where there is no film."""


@dataclass(frozen=True)
class Registered:
    """A law with the functions that copy its memory and what it keeps from and to the tables of contacts."""

    law: NormalLaw | TractionLaw | LubricationLaw | None
    functions: dict[str, Callable[..., Any]] = field(default_factory=dict)


BY_CONSTANTS: dict[type, Registered] = {}
"""The registered laws, by the type of their constants."""


def _function(source: str, **names: Any) -> Callable[..., Any]:
    exec(source, names)
    made: Callable[..., Any] = names["made"]
    return made


def _accessors(content: type) -> dict[str, Callable[..., Any]]:
    """Return functions that load, store and scale the values of a NamedTuple at element k of a table that has them as arrays."""
    fields = fields_of(content)
    values = ", ".join(f"table.{name}[k]" for name in fields)
    stores = "\n".join(f"    table.{name}[k] = values.{name}" for name in fields) or "    pass"
    scales = "\n".join(f"    table.{name}[k] *= factor" for name in fields) or "    pass"
    clears = "\n".join(f"    table.{name}[k] = 0.0" for name in fields) or "    pass"
    return {
        "load": _function(f"def made(law, table, k):\n    return Content({values})", Content=content),
        "store": _function(f"def made(law, table, k, values):\n{stores}"),
        "scale": _function(f"def made(law, table, k, factor):\n{scales}"),
        "clear": _function(f"def made(law, table, k):\n{clears}"),
    }


def _row_accessors(content: type) -> dict[str, Callable[..., Any]]:
    """Return functions that load and store the values of a NamedTuple as a row of an array."""
    fields = fields_of(content)
    values = ", ".join(f"rows[k, {at}]" for at in range(len(fields)))
    stores = "\n".join(f"    rows[k, {at}] = values.{name}" for at, name in enumerate(fields)) or "    pass"
    return {
        "load": _function(f"def made(law, rows, k):\n    return Content({values})", Content=content),
        "store": _function(f"def made(law, rows, k, values):\n{stores}"),
    }


def fields_of(content: type) -> tuple[str, ...]:
    """Return the names of a NamedTuple's fields."""
    names: tuple[str, ...] = content._fields  # type: ignore[attr-defined]
    return names


FILM_KERNELS = (
    "film_reach",
    "film_offset",
    "film_lift",
    "film_lift_energy",
    "film_damping",
    "film_floor",
    "film_squeeze",
    "steady_friction",
    "film_memory",
    "film_resistance",
)


def _register_lubrication(law: LubricationLaw) -> None:
    """Make the kernels find a law of lubrication by its constants, and its kernels by its films."""
    film = _row_accessors(law.film)
    functions = {"film_at": law.film_at, "load_film": film["load"], "store_film": film["store"]}
    functions |= {f"{verb}_memory": function for verb, function in _accessors(law.memory).items()}
    loads, stores = ("table.resistance[k] * factor", "table.resistance[k] = value") if law.resists else ("0.0", "pass")
    functions["load_resistance"] = _function(f"def made(law, table, k, factor):\n    return {loads}")
    functions["store_resistance"] = _function(f"def made(law, table, k, value):\n    {stores}")
    BY_CONSTANTS[law.constants] = Registered(law, functions)
    resists = _function(f"def made(film):\n    return {law.resists}")
    BY_CONSTANTS[law.film] = Registered(law, {name: getattr(law, name) for name in FILM_KERNELS} | {"film_resists": resists})


def register(law: NormalLaw | TractionLaw | LubricationLaw) -> None:
    """Make the kernels find a law by its constants."""
    if isinstance(law, LubricationLaw):
        _register_lubrication(law)
        return
    memory = _accessors(law.memory)
    functions = {f"{verb}_memory": function for verb, function in memory.items()}
    if isinstance(law, NormalLaw):
        kernels = ("force", "energy", "penetration", "range", "damping", "update")
        functions |= {f"normal_{name}": getattr(law, name) for name in kernels}
    else:
        kept = _accessors(law.kept)
        functions |= {"load_kept": kept["load"], "store_kept": kept["store"], "traction_line": law.line, "traction_update": law.update}
    BY_CONSTANTS[law.constants] = Registered(law, functions)


def law_of(constants: Any) -> Any:
    """Return the law that some constants belong to."""
    return BY_CONSTANTS[type(constants)].law


def by_law(function: Function) -> Function:
    """Make a function of a law's constants and more call that law's function of the same purpose, in kernels and in Python."""
    names = list(inspect.signature(function).parameters)
    name, first, parameters = function.__name__, names[0], ", ".join(names)

    def found(constants: type) -> Callable[..., Any]:
        return BY_CONSTANTS[constants].functions[name]

    def in_python(law: Any) -> Callable[..., Any]:
        kernel = found(type(law))
        return getattr(kernel, "py_func", kernel)

    call: Any = _function(f"def made({parameters}):\n    return in_python({first})({parameters})", in_python=in_python)
    call.__doc__, call.__name__, call.__module__ = function.__doc__, name, function.__module__

    def typed(law: Any) -> Callable[..., Any]:
        return _function(f"def made({parameters}):\n    return kernel({parameters})", kernel=_inlined(found(law.instance_class)))

    overload(call, jit_options=cast(Any, INLINED))(_function(f"def made({parameters}):\n    return typed({first})", typed=typed))
    return call  # type: ignore[no-any-return]


_INLINED: dict[Callable[..., Any], Callable[..., Any]] = {}


def _inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel as it is, and another function compiled as one."""
    from numba import njit
    from numba.core.dispatcher import Dispatcher

    if isinstance(function, Dispatcher):
        return function
    if function not in _INLINED:
        _INLINED[function] = njit(**INLINED)(function)
    return _INLINED[function]


@by_law
def normal_force(law: Any, memory: Any, penetration: float, site: Site) -> tuple[float, float]:  # type: ignore[empty-body]
    """Return elastic force [N] and stiffness [N/m] at a penetration [m] within the law's range."""


@by_law
def normal_energy(law: Any, memory: Any, penetration: Any, force: Any) -> Any:
    """Return the energy stored [J] at a penetration [m] under its elastic force [N]."""


@by_law
def normal_penetration(law: Any, force: Any, site: Site) -> Any:
    """Return the penetration [m] under a force above zero [N]."""


@by_law
def normal_range(law: Any) -> float:  # type: ignore[empty-body]
    """Return the gap up to which the law acts on open contacts [m]."""


@by_law
def normal_damping(  # type: ignore[empty-body]
    law: Any, memory: Any, site: Site, begin: float, way: float, force: float, stiffness: float
) -> float:
    """Return the law's mean damping over a step [N s/m]."""


@by_law
def normal_update(law: Any, memory: Any, penetration: float, closing: float, step: float) -> Any:
    """Return the memory of the normal force after a step."""


@by_law
def traction_line(law: Any, memory: Any, slip: float, rolling: float | None, force: float, site: Site | None, step: float) -> Any:
    """Return offset [-] and slope [s/m] of friction per normal force over the mean slip of a step, and what the law keeps."""


@by_law
def traction_update(law: Any, memory: Any, kept: Any, slip: float, closed: bool, step: float) -> Any:
    """Return the memory of traction after a step."""


@by_law
def load_memory(law: Any, table: Any, k: int) -> Any:
    """Return the law's memory at element ``k`` of its table."""


@by_law
def store_memory(law: Any, table: Any, k: int, values: Any) -> None:
    """Write the law's memory at element ``k`` of its table."""


@by_law
def scale_memory(law: Any, table: Any, k: int, factor: float) -> None:
    """Multiply the law's memory at element ``k`` of its table."""


@by_law
def clear_memory(law: Any, table: Any, k: int) -> None:
    """Write zero to the law's memory at element ``k`` of its table."""


@by_law
def load_kept(law: Any, table: Any, k: int) -> Any:
    """Return what the law has kept at element ``k`` of its table."""


@by_law
def store_kept(law: Any, table: Any, k: int, values: Any) -> None:
    """Write what the law keeps at element ``k`` of its table."""


@by_law
def film_at(law: Any, number: int, speed: float) -> Any:
    """Return the film of a raceway's contacts at a speed of rolling [m/s]."""


@by_law
def load_film(law: Any, rows: Any, k: int) -> Any:
    """Return the film in row ``k`` of an array."""


@by_law
def store_film(law: Any, rows: Any, k: int, values: Any) -> None:
    """Write a film as row ``k`` of an array."""


@by_law
def load_resistance(law: Any, table: Any, k: int, factor: float) -> float:  # type: ignore[empty-body]
    """Return the resistance to rolling [N] at element ``k`` of a table, times a factor."""


@by_law
def store_resistance(law: Any, table: Any, k: int, value: float) -> None:
    """Write the resistance to rolling [N] at element ``k`` of a table."""


@by_law
def film_reach(film: Any) -> float:  # type: ignore[empty-body]
    """Return the gap up to which a film acts [m]."""


@by_law
def film_offset(film: Any) -> float:  # type: ignore[empty-body]
    """Return the gap at which the elastic contact closes [m]."""


@by_law
def film_lift(film: Any, gap: float) -> tuple[float, float]:  # type: ignore[empty-body]
    """Return force [N] and stiffness [N/m] of a film at a gap [m], beside the elastic contact."""


@by_law
def film_lift_energy(film: Any, gap: float) -> float:  # type: ignore[empty-body]
    """Return the integral of that force from a gap to infinity [J]."""


@by_law
def film_damping(film: Any, gap: float, way: float) -> float:  # type: ignore[empty-body]
    """Return the mean damping [N s/m] of a film over a step from a gap to one smaller by ``way`` [m]."""


@by_law
def film_floor(film: Any) -> float:  # type: ignore[empty-body]
    """Return the gap below which the damping of a film grows no more [m]."""


@by_law
def film_squeeze(film: Any, gap: float, closing: float) -> float:  # type: ignore[empty-body]
    """Return the damping [N s/m] of a film at a gap [m] that closes at a speed [m/s]."""


@by_law
def film_memory(film: Any, force: float) -> Any:
    """Return what a film remembers of a contact under a normal force [N]."""


@by_law
def steady_friction(film: Any, memory: Any, friction: Any, slip: float) -> tuple[float, float]:  # type: ignore[empty-body]
    """Return speed [m/s] and coefficient [-] of steady sliding at a slip [m/s]."""


@by_law
def film_resists(film: Any) -> bool:  # type: ignore[empty-body]
    """Return whether a film resists rolling: a constant for the compiler."""


@by_law
def film_resistance(film: Any, memory: Any, force: float) -> float:  # type: ignore[empty-body]
    """Return the resistance to rolling [N], with the sign of the speed of rolling; zero without a normal force [N]."""
