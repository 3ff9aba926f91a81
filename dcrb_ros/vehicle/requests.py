"""Requests to a running vehicle: commands, and changes of wheels and slides, which wait for the next block."""

from __future__ import annotations

import itertools
import threading
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dcrb_ros.schema.arguments import keyed
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.pending import MAX_PENDING
from dcrb_ros.vehicle.changes import RANGES, checked_command, of_model, sorted_changes
from dcrb_ros.vehicle.description import Vehicle
from dcrb_ros.vehicle.loads import check_loads
from dcrb_ros.vehicle.model import VehicleModel
from dcrb_ros.vehicle.scenario import PREFIX, ScheduledSetting, check_way


class VehicleRequests:
    """Keeps requests from any thread and the settings of a scenario, and gives them to the model of the vehicle."""

    def __init__(self, vehicle: Vehicle, model: VehicleModel, settings: Sequence[ScheduledSetting] = ()) -> None:
        self._vehicle, self._model, self._settings = vehicle, model, settings
        self._given = self._planned = 0
        """Settings that were given, and frames that were planned [-]."""
        self._wheels = {box.name: box.wheel for box in vehicle.boxes}
        self.commanded = {name: float(getattr(vehicle.journey, name)) for name in RANGES}
        """The commands in effect, by the names of `RANGES`."""
        self._pending: deque[tuple[str, Any]] = deque()
        self._lock, self._one_command = threading.Lock(), threading.Lock()

    def command(self, commands: Mapping[str, float]) -> None:
        """Keep commands.

        Raises:
            Refusal: one is unknown or out of range, they leave a box without load, now or with a later setting of the scenario, or too many
                requests are waiting; nothing is changed.
        """
        end = "; the previous commands remain in effect"
        for name, value in commands.items():
            checked_command(name, value, end="; the previous command remains in effect")
        with self._one_command:
            with self._lock:
                self._check_room()
                waiting = {name: value for name, value in self._pending if name in RANGES}
                together = self.commanded | waiting | dict(commands)
                present, ramp, begun = 3.6 * self._model.speed, self._model.targets["ramp"], self._planned
                later = zip(self._settings[self._given :], itertools.repeat("the scenario"), strict=False)
            # Without the lock, which a block may wait for: gradual changes have many settings.
            for speed in (together["speed_kmh"], present):  # the vehicle passes all speeds between them
                check_loads(self._vehicle, together | {"speed_kmh": speed}, end=end)
            check_way(self._vehicle, later, together, present, ramp, begun, end)
            with self._lock:
                self._pending.extend((name, float(value)) for name, value in commands.items())

    def change(self, changes: Mapping[str, Any], simulations: Mapping[str, Simulation]) -> None:
        """Keep changes of wheels and slides by their keys, and give those of parameters of boxes to their ``simulations``, if these run.

        Raises:
            Refusal: a key or a value is invalid, a box has failed or refuses its changes, or too many requests wait; nothing is changed.
        """
        # A recording contains the values as Python prints them.
        changes = {key: value.item() if isinstance(value, np.generic) else value for key, value in keyed("changes", changes).items()}
        asked = sorted_changes(self._vehicle, self._wheels, changes)
        model = {key: value for key, value in changes.items() if of_model(key)}
        with self._lock:
            if model:
                self._check_room()
            for name, changed in asked.boxes.items():
                if name not in simulations:
                    raise Refusal(f"{name}: its model failed, so it takes no changes: begin a new run")
                try:
                    simulations[name].check_change(changed)
                except Refusal as refusal:
                    raise Refusal(f"{name}: {refusal}") from None
            for name, changed in asked.boxes.items():
                simulations[name].change(changed)
            self._pending.extend(model.items())

    def _check_room(self) -> None:
        """Refuse requests while too many are waiting."""
        if len(self._pending) >= MAX_PENDING:
            raise Refusal(f"{MAX_PENDING} commands are already waiting for the next block; send this one again once the bench runs")

    def apply(self) -> tuple[tuple[str, Any], ...]:
        """Give the waiting requests to the model, and return them."""
        with self._lock:  # `worn` must find a change either pending or in effect
            requests = tuple(self._pending)
            self._pending.clear()
            for name, value in requests:
                self.give(name, value)
        return requests

    def begin_frame(self) -> None:
        """Give the model the settings of the scenario for the frame that it plans next; they act from its end on."""
        with self._lock:
            while self._given < len(self._settings) and self._settings[self._given].frame <= self._planned:
                setting = self._settings[self._given]
                self.give(setting.key.removeprefix(PREFIX), setting.value)
                self._given += 1
            self._planned += 1

    def give(self, name: str, value: Any) -> None:
        """Give the model a command, the ramp of the speed, or a change of a wheel or a slide."""
        if name in RANGES:
            self.commanded[name] = value
        if name == "speed_kmh":
            self._model.targets["speed"] = value / 3.6
        elif name in self._model.targets:
            self._model.targets[name] = value
        else:
            changes = sorted_changes(self._vehicle, self._wheels, {name: value})
            for box, wheel in changes.wheels.items():
                self._wheels[box] = wheel
                self._model.wear([each.name for each in self._vehicle.boxes].index(box), wheel)
            for axle, slide in changes.slides.items():
                self._model.slides[[each.name for each in self._vehicle.axles].index(axle)] = slide

    def worn(self) -> dict[str, Any]:
        """Return the parameters of wheels and the slides by their keys, as `change` takes them; those that are pending are left out."""
        with self._lock:
            pending = {key for key, _ in self._pending}
            wheels = {f"{name}.wheel.{key}": value for name, wheel in self._wheels.items() for key, value in wheel.model_dump().items()}
            slides = {f"{axle.name}.slide": float(self._model.slides[p]) for p, axle in enumerate(self._vehicle.axles)}
        return {key: value for key, value in (wheels | slides).items() if key not in pending}
