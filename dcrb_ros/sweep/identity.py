"""Identity of the bearing and the machine of a run, and groups of conditions that share one: a group is in one split, to avoid leakage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

BEARING_ID, MACHINE = "bearing_id", "machine"
IDENTITIES: Mapping[str, tuple[str, ...]] = {
    BEARING_ID: ("bearing", "surfaces", "cage", "contact"),
    MACHINE: ("housing", "structure", "background", "sensor"),
}
"""Groups of parameters that make the individual bearing, and those that make the machine around it with its sensor."""
TRUTH: Mapping[str, tuple[type, str]] = {
    BEARING_ID: (str, "shared by the runs of one individual bearing, at any speed and load; with split.apart never in two splits"),
    MACHINE: (str, "shared by the runs of one machine: housing, path, background and sensor; with split.apart never in two splits"),
}
"""Columns of the labels: type and meaning."""


def identities(
    values: Mapping[str, Any], defaults: Mapping[str, Any], base: Mapping[str, Mapping[str, Any]] | None = None
) -> dict[str, dict[str, Any]]:
    """Return the parameters that define a bearing and a machine and differ from the defaults, by the name of the identity.

    ``values`` are parameters by dotted key, on top of those of ``base``, an earlier result.
    """
    merged = {
        name: {**(base or {}).get(name, {}), **{key: value for key, value in values.items() if key.split(".")[0] in groups}}
        for name, groups in IDENTITIES.items()
    }
    return {name: {key: value for key, value in group.items() if value != defaults.get(key)} for name, group in merged.items()}


class Groups:
    """Conditions joined by a common bearing or machine: a disjoint-set forest (Tarjan 1975, J. ACM 22(2), 215-225)."""

    def __init__(self) -> None:
        self._parent: dict[str, str] = {}

    def add(self, condition: str, shared: Mapping[str, str]) -> None:
        """Add a condition and join it with all that have one of its identities, given by name."""
        self._parent.setdefault(condition, condition)
        for name, identity in shared.items():
            self._join(condition, f"{name} {identity}")

    def _join(self, first: str, other: str) -> None:
        # The smaller name becomes the root, so that the order of the calls does not matter.
        first, second = sorted((self._root(first), self._root(other)))
        self._parent[second] = first

    def _root(self, name: str) -> str:
        self._parent.setdefault(name, name)
        while self._parent[name] != name:
            self._parent[name] = self._parent[self._parent[name]]
            name = self._parent[name]
        return name

    def group(self, condition: str) -> str:
        """Return the name of a condition's group."""
        return self._root(condition)
