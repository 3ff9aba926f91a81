"""The ground truth of a bench at the present instant, with the time at which each of its faults appeared."""

from __future__ import annotations

import math
from collections.abc import Mapping

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.core.layout.state import SHAFT_SPEED, State
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.block import Truth
from dcrb_ros.stream.events import Event


class PresentTruth:
    """Follows the configuration of a bench, and states its ground truth at an instant."""

    def __init__(self, configuration: Configuration) -> None:
        self._orders = characteristic_orders(configuration.bearing)
        self._onsets: dict[str, float] = {}
        self.change(configuration, 0.0)

    def change(self, configuration: Configuration, now: float) -> None:
        """Take the configuration from the time ``now`` [s] on, which is the onset of every new fault."""
        self._configuration = configuration
        self._onsets = {name: self._onsets.get(name, now) for name in configuration.described_faults()}

    def at(self, time_ns: int, state: State, thermal: Mapping[str, float], event: Event | None) -> Truth:
        """Return the ground truth at a time [ns] in a state of the bearing, with temperatures and the event that is its reason."""
        speed, load = float(state.shaft[SHAFT_SPEED]), state.load
        faults = {name: {**fields, "onset": self._onsets[name]} for name, fields in self._configuration.described_faults().items()}
        frequencies = self._orders.frequencies(speed / (2.0 * math.pi))
        background = self._configuration.background.described()
        return Truth(time_ns, speed, (float(load[0]), float(load[1])), frequencies, faults, event, background, thermal)
