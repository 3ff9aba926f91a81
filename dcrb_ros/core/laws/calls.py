"""The functions of laws as kernels call them: each calls the function of the law to which its first argument belongs."""

from __future__ import annotations

from typing import Any

from dcrb_ros.core.laws.registry import by_law
from dcrb_ros.core.laws.site import Site


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
def film_thickness(film: Any, force: float) -> tuple[float, float]:  # type: ignore[empty-body]
    """Return the central film [m] under a normal force [N], and its ratio to the roughness [-]; of laws that have a film."""


@by_law
def steady_friction(film: Any, memory: Any, friction: Any, slip: float) -> tuple[float, float]:  # type: ignore[empty-body]
    """Return speed [m/s] and coefficient [-] of steady sliding at a slip [m/s]."""


@by_law
def has_rolling_resistance(film: Any) -> bool:  # type: ignore[empty-body]
    """Return whether a film resists rolling: a constant for the compiler."""


@by_law
def film_resistance(film: Any, memory: Any, force: float) -> float:  # type: ignore[empty-body]
    """Return the resistance to rolling [N], with the sign of the speed of rolling; zero without a normal force [N]."""


@by_law
def has_cage_oil(law: Any) -> bool:  # type: ignore[empty-body]
    """Return whether oil acts on bars, lands and orbiting rollers: a constant for the compiler."""


@by_law
def bar_damping(law: Any, gap: float) -> float:  # type: ignore[empty-body]
    """Return the damping [N s/m] of a roller that approaches a bar at a gap [m]."""


@by_law
def bar_shear(law: Any, gap: float) -> float:  # type: ignore[empty-body]
    """Return the drag of a bar at a gap [m] over the speed of the roller's surface past it [N s/m]."""


@by_law
def land_damping(law: Any, offset: float, clearance: float, radius: float) -> tuple[float, float]:  # type: ignore[empty-body]
    """Return the damping [N s/m] of a cage that moves away from its lands' centre, and of one that comes back, at an offset [m]."""


@by_law
def land_torque(law: Any, clearance: float, radius: float) -> float:  # type: ignore[empty-body]
    """Return the torque of the lands over the speed of the cage [N m s]."""


@by_law
def churning(law: Any) -> float:  # type: ignore[empty-body]
    """Return the drag of an orbiting roller over its squared speed [N s^2/m^2]."""
