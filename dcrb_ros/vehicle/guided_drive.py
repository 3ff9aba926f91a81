"""Speed and load of a bearing in a vehicle, which the vehicle gives frame by frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dcrb_ros.core.layout.state import TARGET_SPEED, TARGET_X, TARGET_Y, State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten
from dcrb_ros.settings.parameters import Operating
from dcrb_ros.simulation.drive import Drive
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.vehicle.changes import check_own
from dcrb_ros.vehicle.frame import FRAME

ROUNDING = 1.0 + 1e-9
"""Factor on a ramp, which must reach its target within the frame."""


class GuidedDrive(Drive):
    """Speed and load of a bearing in a vehicle, along straight lines from frame to frame."""

    def __init__(self, configuration: Configuration) -> None:
        super().__init__(configuration)
        self.fluctuates = True
        self._frame = FRAME / configuration.step_rate
        self._load_ramp = 0.0
        self.speed = configuration.operating.speed
        """Speed at the end of the frame [rad/s]."""
        self.load = np.array([configuration.operating.lateral_load, -configuration.operating.load])
        """Force on the inner ring in X and Y at the end of the frame [N]."""

    def fluctuate(self, payload: Payload, state: State, operating: Operating, step: int) -> tuple[Payload, int]:
        """Set the targets at the start of a frame; return the payload with the ramps to them, and the step of the next frame."""
        since = step % FRAME
        if since == 0:
            (x, y), (before_x, before_y) = self.load.tolist(), state.load.tolist()
            turn = abs(self.speed - float(state.target[TARGET_SPEED]))
            state.target[TARGET_SPEED], state.target[TARGET_X], state.target[TARGET_Y] = self.speed, x, y
            self._load_ramp = ROUNDING * max(abs(x - before_x), abs(y - before_y)) / self._frame
            payload = payload._replace(speed_ramp=ROUNDING * turn / self._frame, load_ramp=self._load_ramp)
        return payload, step - since + FRAME

    def with_ramps(self, payload: Payload, operating: Operating, present: float) -> Payload:
        """Return a payload with the ramps of the present frame."""
        return payload._replace(speed_ramp=present, load_ramp=self._load_ramp)


class GuidedSimulation(Simulation):
    """The simulation of a box of a vehicle, which refuses commands and changes of what the vehicle gives it."""

    def command_speed(self, speed: float) -> None:
        """Refuse the command."""
        raise Refusal(f"speed = {speed} rad/s is refused, as the speed of a box follows from the vehicle: command its speed_kmh")

    def command_load(self, x: float, y: float) -> None:
        """Refuse the command."""
        remedy = "command its curvature, cant, wind or brake"
        raise Refusal(f"force = {x}, {y} N is refused, as the load of a box follows from the vehicle: {remedy}")

    def _altered(self, changes: Mapping[str, Any], configuration: Configuration | None = None) -> Configuration:
        for key in flatten(changes):
            check_own(key, f"'{key}'")
        return super()._altered(changes, configuration)
