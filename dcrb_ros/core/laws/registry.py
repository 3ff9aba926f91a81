"""How kernels find the law that a bearing was built with: by the type of its constants, when they are compiled."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar, cast

from numba.extending import overload

from dcrb_ros.core.jit import INLINED, WITHOUT_ENTRY
from dcrb_ros.core.laws.interface import LubricationLaw, NormalLaw, TractionLaw

Function = TypeVar("Function", bound=Callable[..., Any])


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


CAGE_KERNELS = ("bar_damping", "bar_shear", "land_damping", "land_torque", "churning")


def _register_lubrication(law: LubricationLaw) -> None:
    """Make the kernels find a law of lubrication by its constants, and its kernels by its films."""
    film = _row_accessors(law.film)
    functions = {"film_at": law.film_at, "load_film": film["load"], "store_film": film["store"]}
    functions |= {f"{verb}_memory": function for verb, function in _accessors(law.memory).items()}
    loads, stores = ("table.resistance[k] * factor", "table.resistance[k] = value") if law.resists else ("0.0", "pass")
    functions["load_resistance"] = _function(f"def made(law, table, k, factor):\n    return {loads}")
    functions["store_resistance"] = _function(f"def made(law, table, k, value):\n    {stores}")
    functions |= {name: getattr(law, name) for name in CAGE_KERNELS}
    functions["has_cage_oil"] = _function(f"def made(law):\n    return {law.has_cage_oil}")
    BY_CONSTANTS[law.constants] = Registered(law, functions)
    resists = _function(f"def made(film):\n    return {law.resists}")
    kernels = {name: getattr(law, name) for name in FILM_KERNELS} | {"has_rolling_resistance": resists}
    BY_CONSTANTS[law.film] = Registered(law, kernels | ({"film_thickness": law.thickness} if law.thickness else {}))


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

    def implementation(constants: type) -> Callable[..., Any]:
        return BY_CONSTANTS[constants].functions[name]

    def in_python(law: Any) -> Callable[..., Any]:
        kernel = implementation(type(law))
        return getattr(kernel, "py_func", kernel)

    call: Any = _function(f"def made({parameters}):\n    return in_python({first})({parameters})", in_python=in_python)
    call.__doc__, call.__name__, call.__module__ = function.__doc__, name, function.__module__

    def typed(law: Any) -> Callable[..., Any]:
        return _function(f"def made({parameters}):\n    return kernel({parameters})", kernel=_inlined(implementation(law.instance_class)))

    options = cast(Any, {**INLINED, **WITHOUT_ENTRY})
    overload(call, jit_options=options)(_function(f"def made({parameters}):\n    return typed({first})", typed=typed))
    return call  # type: ignore[no-any-return]


_INLINED: dict[Callable[..., Any], Callable[..., Any]] = {}


def _inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel as it is, and another function compiled as one."""
    from numba import njit
    from numba.core.dispatcher import Dispatcher

    if isinstance(function, Dispatcher):
        return function
    if function not in _INLINED:
        _INLINED[function] = njit(**INLINED, **WITHOUT_ENTRY)(function)
    return _INLINED[function]
