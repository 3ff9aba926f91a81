"""Changes of parameters while a simulation runs: which are allowed, and how the moving bearing takes new faults."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dcrb_ros.bearing.observation import place_pinned_rollers
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.parameter_field import wrong_type
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import changed, fields_by_key, unknown_parameter
from dcrb_ros.settings.parameters import Operating


def altered(configuration: Configuration, changes: Mapping[str, Any], source: str = "parameters") -> Configuration:
    """Return a configuration with some dotted keys changed; all of it is checked, since parameters depend on each other.

    Raises:
        Refusal: an unknown key, a parameter that is fixed while the simulation runs, values that the configuration refuses, or a fault that
            cannot disappear.
    """
    fields = fields_by_key()
    for key in changes:
        if key not in fields:
            raise Refusal(f"{source}: {unknown_parameter(key)}")
        if not fields[key].run_time:
            fixed = f"{key} is fixed while the bench runs; set it in the configuration and restart"
            raise Refusal(f"{source}: {wrong_type(fields[key], changes[key]) or fixed}")
    after = changed(configuration, changes, source)
    for words in configuration.faults.unhealed(after.faults):
        raise Refusal(f"{source}: {words}")
    return after


def refitted(configuration: Configuration, assembled: Operating, payload: Payload, state: State) -> Payload:
    """Return the payload with the faults of ``configuration``; rollers that become free keep the positions that their cages gave them.

    Axial preload and the width of the contacts stay those of the assembly, at its speed and load.
    """
    place_pinned_rollers(payload, state)
    after = build_payload(configuration.model_copy(update={"operating": assembled}), configuration.operating.speed)
    freed = after.free & ~payload.free
    # Their last change of velocity was the cage's; one step does without this prediction.
    state.roller_change[freed, :2] = 0.0
    return after
