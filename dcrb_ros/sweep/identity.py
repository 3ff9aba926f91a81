"""Identity of the bearing and the machine of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

BEARING_ID, MACHINE = "bearing_id", "machine"
IDENTITIES: Mapping[str, tuple[str, ...]] = {
    BEARING_ID: ("bearing", "surfaces", "cage", "contact"),
    MACHINE: ("housing", "structure", "background", "sensor"),
}
"""Groups of parameters that make the individual bearing, and those that make the machine around it with its sensor."""
SURFACES, PROFILE, SURFACES_SEED = "surfaces.law", "profile", "surfaces.seed"
STRUCTURE_SEED, DRAWN_PATH = "structure.seed", ("structure.modes", "structure.frequencies", "structure.path_spread")
"""The seed of the path, and the parameters of which one is set if anything is drawn from it, unless a housing is."""
HOUSING, NO_HOUSING = "structure.housing", "none"
MOUNTING = "structure.mounting"
"""The seed of a mounting: a bearing that is mounted again is on the same machine."""
TRUTH: Mapping[str, tuple[type, str]] = {
    BEARING_ID: (str, "shared by the runs of one individual bearing, at any speed and load"),
    MACHINE: (str, "shared by the runs of one machine: housing, path, background and sensor"),
}
"""Columns of the labels: type and meaning."""


def identities(
    values: Mapping[str, Any], defaults: Mapping[str, Any], base: Mapping[str, Mapping[str, Any]] | None = None
) -> dict[str, dict[str, Any]]:
    """Return the parameters that define a bearing and a machine and differ from the defaults, by the name of the identity.

    ``values`` are parameters by dotted key, on top of those of ``base``, an earlier result. Left out are a seed from which nothing is
    drawn, and the mounting.
    """
    merged = {
        name: {**(base or {}).get(name, {}), **{key: value for key, value in values.items() if key.split(".")[0] in groups}}
        for name, groups in IDENTITIES.items()
    }
    return {
        name: {key: value for key, value in group.items() if value != defaults.get(key) and _has_effect(key, {**defaults, **group})}
        for name, group in merged.items()
    }


def _has_effect(key: str, values: Mapping[str, Any]) -> bool:
    """Return whether a parameter makes another bearing or machine."""
    if key == MOUNTING:
        return False
    if key == SURFACES_SEED:
        return bool(values[SURFACES] == PROFILE)
    return key != STRUCTURE_SEED or values[HOUSING] != NO_HOUSING or any(values[name] for name in DRAWN_PATH)


def drawn_by_noise(bearing: Mapping[str, Any], defaults: Mapping[str, Any]) -> bool:
    """Return whether the surfaces of a bearing follow from the seed of the noise, so that each of these seeds is another individual."""
    values = {**defaults, **bearing}
    return bool(values[SURFACES] == PROFILE and not values[SURFACES_SEED])
