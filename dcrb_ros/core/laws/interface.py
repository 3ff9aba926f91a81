"""What a contact law consists of.

A law is chosen by the type of its constants, when a kernel is compiled: there is no branch at run time, and a bearing with another law
has kernels of its own. `registry` finds a law by its constants, `calls` has the functions by which kernels call it.
`docs/how-to/add-a-law.md` adds one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from dcrb_ros.core.laws.site import Material, NoMemory, Site


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

    Kernels are made by `dcrb_ros.core.jit.kernel`. ``law`` are the constants, ``memory`` is the memory at one contact.
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


def _no_bar_film(law: Any, gap: float) -> float:
    return 0.0


def _no_land_film(law: Any, offset: float, clearance: float, radius: float) -> tuple[float, float]:
    return 0.0, 0.0


def _no_land_torque(law: Any, clearance: float, radius: float) -> float:
    return 0.0


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
    warmed: Callable[[Mapping[str, Any], Material, float, float], Any] | None = None
    """Return the constants with lubricant of different temperatures at the inlets of inner and outer raceway [deg C]; None where there
    is no lubricant. ``values`` may have ``micro_slip``, the slip of asperities in rolling [-]."""
    memory: type = NoMemory
    """NamedTuple of floats kept at each contact: what takes long to evaluate and changes little while a surface passes through it."""
    resists: bool = False
    """Whether the law has a resistance to rolling."""
    thickness: Callable[..., tuple[float, float]] | None = None
    """Kernel (film, force): film [m] under a normal force [N], and its ratio to the roughness [-]; None where there is no film."""
    has_cage_oil: bool = False
    """Whether the law acts on bars, lands and orbiting rollers."""
    bar_damping: Callable[..., float] = _no_bar_film
    """Kernel (law, gap): damping [N s/m] of a roller that approaches a bar at a gap [m]."""
    bar_shear: Callable[..., float] = _no_bar_film
    """Kernel (law, gap): drag of a bar over the speed of the roller's surface past it [N s/m]."""
    land_damping: Callable[..., tuple[float, float]] = _no_land_film
    """Kernel (law, offset, clearance, radius): damping of a cage that moves away from its lands' centre, and of one that comes
    back [N s/m]; lengths in [m]."""
    land_torque: Callable[..., float] = _no_land_torque
    """Kernel (law, clearance, radius): torque of the lands over the speed of the cage [N m s]."""
    churning: Callable[..., float] = _no_range
    """Kernel (law): drag of an orbiting roller over its squared speed [N s^2/m^2]."""
