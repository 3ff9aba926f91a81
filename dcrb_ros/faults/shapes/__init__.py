"""Shapes of damage on raceways, one per file; a new one is a file and a line here."""

from __future__ import annotations

import importlib

from dcrb_ros.faults.shapes.shape import Shape

REGISTRY: tuple[str, ...] = ("spall", "dent", "brinelling", "fluting", "corrosion", "scratch")
"""Files with a ``SHAPE``."""

SHAPES: dict[str, Shape] = {shape.name: shape for shape in (importlib.import_module(f"{__name__}.{name}").SHAPE for name in REGISTRY)}
"""Shapes by the value of ``kind``."""
