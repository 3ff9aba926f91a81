"""The drive of a bench: the commanded speed and load as the kernels approach them."""

from __future__ import annotations

import math
from collections.abc import Collection
from numbers import Real

from dcrb_ros.core.layout.state import SHAFT_ANGLE, SHAFT_SPEED, TARGET_SPEED, TARGET_X, TARGET_Y, State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Operating
from dcrb_ros.simulation.shaft_speed import ShaftSpeed


def commanded(name: str, key: str, value: float, unit: str) -> float:
    """Return a commanded value that is within the range of a parameter of operation."""
    low, high = (
        next((m.ge for m in Operating.model_fields[key].metadata if hasattr(m, "ge")), -math.inf),
        next((m.le for m in Operating.model_fields[key].metadata if hasattr(m, "le")), math.inf),
    )
    valid = isinstance(value, Real) and not isinstance(value, bool) and low <= value <= high
    if not (valid and math.isfinite(value)):
        raise Refusal(
            f"{name} = {value} {unit} is refused: it must be a number within {low:g} .. {high:g} {unit}; "
            "the previous command remains in effect"
        )
    return float(value)


class Drive:
    """Sets the targets of speed and load in the state, and their ramps in the payload; nothing else changes either during a run."""

    def __init__(self, configuration: Configuration) -> None:
        self._shaft = ShaftSpeed(configuration)
        self.fluctuates = self._shaft.fluctuates
        """Whether the speed is anything but its ramp."""

    def command_speed(self, state: State, speed: float) -> None:
        """Set the commanded speed [rad/s]; a fluctuating speed follows it from its next value on."""
        self._shaft.commanded = speed
        if not self.fluctuates:
            state.target[TARGET_SPEED] = speed

    def command_load(self, state: State, x: float, y: float) -> None:
        """Set the commanded load in X and Y [N]."""
        state.target[TARGET_X], state.target[TARGET_Y] = x, y

    def command_changed(self, state: State, operating: Operating, changed: Collection[str]) -> None:
        """Set the commanded speed and loads that are among the keys of changed parameters."""
        if "operating.speed" in changed:
            self.command_speed(state, operating.speed)
        if "operating.lateral_load" in changed:
            state.target[TARGET_X] = operating.lateral_load
        if "operating.load" in changed:
            state.target[TARGET_Y] = -operating.load

    def with_ramps(self, payload: Payload, operating: Operating, present: float) -> Payload:
        """Return a payload with the ramps of speed and load; a fluctuating speed keeps the ``present`` one [rad/s^2] to its next value."""
        return payload._replace(speed_ramp=present if self.fluctuates else operating.speed_ramp, load_ramp=operating.load_ramp)

    def fluctuate(self, payload: Payload, state: State, operating: Operating, step: int) -> tuple[Payload, int]:
        """Prescribe the speed if a new value is due at a step; return the payload with the ramp to it, and the step of the next value."""
        since = step % self._shaft.interval
        if since == 0:
            angle, speed = float(state.shaft[SHAFT_ANGLE]), float(state.shaft[SHAFT_SPEED])
            state.target[TARGET_SPEED], ramp = self._shaft.next(step, angle, speed, operating.speed_ramp)
            payload = payload._replace(speed_ramp=ramp)
        return payload, step - since + self._shaft.interval
