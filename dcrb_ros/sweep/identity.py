"""Which bearing and which machine a run has, and the groups of conditions that one split must hold whole so that neither leaks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

BEARING_ID, MACHINE = "bearing_id", "machine"
IDENTITIES: Mapping[str, tuple[str, ...]] = {
    BEARING_ID: ("bearing", "surfaces", "cage", "contact"),
    MACHINE: ("housing", "structure", "background", "sensor"),
}
"""Groups of parameters that make the individual bearing, and those that make the machine around it with its sensor."""


def identities(values: Mapping[str, Any], defaults: Mapping[str, Any], digest: Callable[[Any], str]) -> dict[str, str]:
    """Return the hashes of bearing and machine with some parameters, of what differs from the defaults."""
    return {
        name: digest({key: value for key, value in values.items() if key.split(".")[0] in groups and value != defaults.get(key)})
        for name, groups in IDENTITIES.items()
    }


class Groups:
    """Conditions joined by what they share: a disjoint-set forest (Tarjan 1975, J. ACM 22(2), 215-225)."""

    def __init__(self) -> None:
        self._parent: dict[str, str] = {}

    def add(self, condition: str, shared: Mapping[str, str]) -> None:
        """Add a condition and join it with all that have one of its identities, given by name."""
        self._parent.setdefault(condition, condition)
        for name, identity in shared.items():
            self._join(condition, f"{name} {identity}")

    def _join(self, one: str, other: str) -> None:
        # The smaller name stands for both, so that the order of the calls does not matter.
        first, second = sorted((self._root(one), self._root(other)))
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
