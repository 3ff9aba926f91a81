"""Parameters that have no effect in an exam."""

from __future__ import annotations

from collections.abc import Iterable

from dcrb_ros.schema.refusal import Refusal

INEFFECTIVE = ("time_scale", "recording")
"""Groups and parameters of the nodes: an exam is simulated as fast as possible, and records nothing."""


def refuse_ineffective(keys: Iterable[str], where: str) -> None:
    """Refuse dotted keys of parameters that have no effect in an exam."""
    key = next((key for key in keys if key.partition(".")[0] in INEFFECTIVE), None)
    if key is not None:
        raise Refusal(f"{where}: {key} has no effect in an exam, which is simulated as fast as possible and records nothing: leave it out")
