"""Laboratory rigs and axle boxes as drawn machines: unequal impacts and a background, from the priors of the package."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from impact_priors import AXLE_BOX, LABORATORY, draw_impacts

from dcrb_ros.measurement.housing_priors import FLOORS, PRIORS
from dcrb_ros.simulation.healthy_level import healthy_level

IMPACTS = {"laboratory": LABORATORY, "axle_box": AXLE_BOX}
"""Distributions of the impacts by the kind of housing."""
DAMAGED = {"outer": "outer", "inner": "inner", "ball": "roller"}
"""Key of the floor of each kind of defect."""


def equal(bench: str, machine: Mapping[str, Any], kind: str, seed: int) -> dict[str, Any]:
    """Return no settings: impacts are alike and there is no background."""
    return {}


def drawn(bench: str, machine: Mapping[str, Any], kind: str, seed: int) -> dict[str, Any]:
    """Return settings of impacts and background of a machine; only the floor depends on the kind of defect.

    Args:
        bench: configuration of the bearing.
        machine: settings of the healthy machine, with ``structure.housing``.
        kind: kind of defect, or ``healthy``.
        seed: of all that is drawn here.
    """
    settings = _settings(bench, tuple(sorted(machine.items())), seed)
    if kind not in DAMAGED:
        return settings
    floors = {name: prior.drawn(np.random.default_rng([seed, 3])) for name, prior in FLOORS.items()}
    return {**settings, "structure.floor": floors[DAMAGED[kind]]}


@functools.cache
def _settings(bench: str, machine: tuple[tuple[str, Any], ...], seed: int) -> dict[str, Any]:
    """Return the settings of a machine that do not depend on its defect, with the level of the healthy bearing [m/s^2]."""
    housing = dict(machine)["structure.housing"]
    impacts = draw_impacts(IMPACTS[housing], np.random.default_rng([seed, 1]), balls=housing == "laboratory")
    path, random = PRIORS[housing], np.random.default_rng([seed, 2])
    noise = {"structure.background": path.background.drawn(random), "structure.background_lines": path.lines.drawn(random)}
    return {**impacts, **noise, "structure.healthy_level": healthy_level(bench, 1.0, settings={**dict(machine), **impacts})}


DRAWS: dict[str, Callable[[str, Mapping[str, Any], str, int], dict[str, Any]]] = {"equal": equal, "drawn": drawn}
"""Settings of a machine by configuration, settings of the healthy machine, kind of defect and seed."""
