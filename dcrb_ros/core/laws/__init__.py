"""The published laws, one per file: force, slope, inverse and energy side by side; a new one is a file and a line here."""

from __future__ import annotations

import importlib

from dcrb_ros.core.laws.interface import LubricationLaw, NormalLaw, TractionLaw
from dcrb_ros.core.laws.registry import register

REGISTRY: tuple[str, ...] = (
    "johnson",
    "power",
    "hertz",
    "lugre",
    "dry",
    "film",
    "film_with_cages",
)
"""Files with a law that users may choose, each with a ``LAW``; the first of a kind is the default."""

_LAWS: tuple[NormalLaw | TractionLaw | LubricationLaw, ...] = tuple(importlib.import_module(f"{__name__}.{name}").LAW for name in REGISTRY)
NORMAL_LAWS: dict[str, NormalLaw] = {law.name: law for law in _LAWS if isinstance(law, NormalLaw)}
TRACTION_LAWS: dict[str, TractionLaw] = {law.name: law for law in _LAWS if isinstance(law, TractionLaw)}
LUBRICATION_LAWS: dict[str, LubricationLaw] = {law.name: law for law in _LAWS if isinstance(law, LubricationLaw)}
for _law in _LAWS:
    register(_law)
