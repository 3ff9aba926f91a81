"""What changes while a bench runs: which parameters may, to what, and how the moving bearing takes new faults."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dcrb_ros.bearing.observation import place_pinned_rollers
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.payload import Payload
from dcrb_ros.runtime.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import fields_by_key, flatten, validated


def altered(configuration: Configuration, changes: Mapping[str, Any], source: str = "parameters") -> Configuration:
    """Return a configuration with some dotted keys changed, checked as a whole.

    Raises:
        Refusal: a key that is unknown or fixed while the bench runs, a value or a combination that the configuration's own
            checks refuse, or a broken bar that would heal.
    """
    fields = fields_by_key()
    for key in changes:
        if key not in fields:
            raise Refusal(f"{source}: unknown parameter '{key}'{nearest(key, fields)}")
        if not fields[key].run_time:
            raise Refusal(f"{source}: {key} is fixed while the bench runs; set it in the configuration and start anew")
    after = validated({**flatten(configuration.model_dump()), **changes}, Configuration, source)
    for words in configuration.faults.unhealed(after.faults):
        raise Refusal(f"{source}: {words}")
    return after


def refitted(configuration: Configuration, payload: Payload, state: State) -> Payload:
    """Return the payload with the faults of ``configuration``; rollers that it sets free go on where their cages carry them now."""
    place_pinned_rollers(payload, state)
    after = build_payload(configuration)
    freed = after.free & ~payload.free
    # The cage's change of velocity was not theirs; a step's prediction does without.
    state.roller_change[freed, :2] = 0.0
    return after


def onsets(known: Mapping[str, float], configuration: Configuration, now: float) -> dict[str, float]:
    """Return since when [s] each fault of a configuration is present: as known, or since ``now``."""
    return {name: known.get(name, now) for name in configuration.described_faults()}
