"""Heat and lubricant of a running bearing: what changes slowly beside the motion, on a fixed grid of simulated steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from dcrb_ros.bearing.axle_heat import ALONE, BoxTemperatures, Surroundings, box_temperatures
from dcrb_ros.bearing.film_observation import friction_losses
from dcrb_ros.bearing.heat_network import Conductances, Vector
from dcrb_ros.bearing.quasi_steady import QuasiSteady, air_speed, lost_in_grease, raceway_conductance, seal_heat, vehicle_speed
from dcrb_ros.bearing.thermal_fit import Growth, OilState, expansion, oil_state, oiled, resized, rounded, work_of_growth
from dcrb_ros.core.contacts.films import entrainment_speeds
from dcrb_ros.core.laws.lubricants import lubricant_of
from dcrb_ros.core.layout.state import CAGE, SHAFT_SPEED, State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import material_of
from dcrb_ros.settings.oil_limits import held
from dcrb_ros.simulation.failure import failure_at
from dcrb_ros.simulation.opposite_box import OppositeBox
from dcrb_ros.simulation.temperature_sensors import TemperatureSensors
from dcrb_ros.stream.states import HEAT_SOURCES, TemperatureReading, ThermalState

TICK, SHORT_TICK = 0.1, 0.02
"""Simulated time between two steps of the network [s], in real time and with a time lapse."""
LAPSE = 10.0
"""Time lapse from which a tick is short [-]."""
AVERAGED = 0.5
"""Simulated time constant over which heat and conductances are averaged [s]: they fluctuate as rollers pass the load zone."""
PART = 0.0025
"""Least simulated time between two changes of the radii, or of the lubricant [s]."""
LARGEST_GROWTH = 0.02e-6
"""Largest change of a radius at once [m], some 16 N at a contact."""
LARGEST_LOSS = 2.0**-6
"""Largest change of the share of lost lubricant at once [-] (a choice): all of it goes within 0.16 s, in which rollers pass a place of a
raceway some 20 times at 1200 rpm. Films that collapse within a step strike the rings."""
HOTTEST = 600.0
"""Temperature at which the bearing is destroyed and the run ends [deg C]."""
HOUR = 3600.0
BURNING = 0.01
"""Share of the lubricant that burns per kelvin above the limit and hour [1/(K h)] (a choice)."""


class Heating:
    """Steps the temperatures, and fits oil and radii to them and to the faults; inactive unless configured or a fault asks for it."""

    def __init__(self, configuration: Configuration, surroundings: Surroundings = ALONE) -> None:
        c = configuration
        self.surroundings = surroundings
        """What a vehicle does to the heat of the box."""
        self.network_on = c.thermal.law == "network"
        """Whether there are temperatures."""
        self.interval = max(1, round((TICK if c.thermal.acceleration < LAPSE else SHORT_TICK) * c.step_rate))
        """Time steps in a tick."""
        self._part = max(1, round(PART * c.step_rate))
        self._steady = QuasiSteady(_in_air(c, surroundings.air))
        self._material = material_of(c.bearing)
        self._network = self._steady.network
        self._tick = self.interval / c.step_rate
        self.loss, self._burnt = self._asked(c), 0.0
        self._lost = self.loss
        """The loss that `loss` approaches within a tick or more [-]."""
        self.clamped = 0
        self.temperatures: Vector = []
        """Of the nodes of the network [deg C]."""
        self._heat: list[list[float]] = []
        self._conductance: list[list[float]] = []
        self._losses: Floats | None = None
        self._oil: OilState | None = None
        self._growth = Growth(0.0, 0.0, 0.0)
        self._aim = self._growth
        self._ambient = c.thermal.ambient
        self._present: ThermalState | None = None
        """The temperatures as states have them, until they change."""
        if self.network_on:
            self._start(c)
        self._opposite = OppositeBox(_in_air(c, surroundings.air)) if self.network_on else None
        self._sensors = TemperatureSensors(c, self._network, self.temperatures) if self.network_on else None

    @staticmethod
    def _asked(c: Configuration) -> float:
        """Return the loss of lubricant at the start: that of the fault, unless it grows."""
        condition = c.faults.condition
        return 0.0 if condition.duration > 0.0 else float(condition.loss)

    def active(self, configuration: Configuration) -> bool:
        """Return whether anything changes beside the motion."""
        return self.network_on or not configuration.faults.condition.sound or self._oil is not None or self._growth != Growth(0.0, 0.0, 0.0)

    def _start(self, c: Configuration) -> None:
        """Set temperatures, heat and conductances to those at the start."""
        running, nodes = self._steady.running(), self._network.box + 1
        cold = [c.thermal.ambient] * nodes
        self.temperatures = cold if c.thermal.start == "cold" else self._steady.steady(running, self.loss)
        self._heat = [list(row) for row in self._steady.power(running, self.temperatures, self.loss)]
        flow = self._steady.conductances(running).matrix
        rows = range(self._network.rows)
        self._conductance = [
            [-flow[self._network.inner(row)][self._network.rollers(row)], -flow[self._network.rollers(row)][self._network.outer(row)]]
            for row in rows
        ]

    def begin(self, configuration: Configuration, payload: Payload) -> Payload:
        """Return the payload at the start, with oil and radii as temperatures and faults make them.

        Raises:
            Refusal: films fill the radial gap.
        """
        if not self.active(configuration):
            return payload
        self._growth = self._aim = self._wanted(configuration)
        running = self._steady.running()
        if self.network_on:
            self._steady.refuse_thick_films(running, self.temperatures, self.loss)
        return self._fitted(configuration, payload, running.rolling)

    def refit(self, configuration: Configuration, payload: Payload, state: State) -> Payload:
        """Return a payload that was built anew, with the present oil and radii."""
        if not self.active(configuration):
            return payload
        self._oil = None
        return self._fitted(configuration, payload, entrainment_speeds(payload, state))

    def next(self, steps: int) -> int:
        """Return the step after ``steps`` at which `update` is due: the next tick, or sooner while radii or films change."""
        after = steps % self.interval
        reached = self._growth == self._aim and self.loss == self._lost
        wait = self.interval if reached else min((after // self._part + 1) * self._part, self.interval)
        return steps - after + wait

    def update(self, configuration: Configuration, payload: Payload, state: State, steps: int) -> tuple[Payload, float]:
        """Return the payload from a step on, and the work that changed radii did on the contacts [J].

        Raises:
            ModelFailure: a temperature is above `HOTTEST`.
        """
        c, self._present = configuration, None
        if steps % self.interval == 0:
            self._lose(c)
            if self.network_on:
                self._warm(c, payload, state)
                self._check_hottest(nanoseconds(steps, c.step_rate))
            self._aim = self._wanted(c)
        self.loss = min(max(self._lost, self.loss - LARGEST_LOSS), self.loss + LARGEST_LOSS)
        before = self._growth
        self._growth = Growth(
            *(present + min(max(aim - present, -LARGEST_GROWTH), LARGEST_GROWTH) for present, aim in zip(before, self._aim, strict=True))
        )
        work = work_of_growth(state, Growth(*(now - present for now, present in zip(self._growth, before, strict=True))))
        return self._fitted(c, payload, entrainment_speeds(payload, state)), work

    def reading(self, configuration: Configuration, steps: int, time_ns: int) -> TemperatureReading | None:
        """Return what the sensors read at a step; None between two readings, and without temperatures."""
        return self._sensors.reading(configuration, steps, time_ns) if self._sensors is not None else None

    @property
    def box(self) -> BoxTemperatures | None:
        """Temperatures of journal, outer ring and box; None without a network."""
        return box_temperatures(self._network, self.temperatures) if self.network_on else None

    @property
    def present(self) -> ThermalState | None:
        """The temperatures; None without a network."""
        if not self.network_on:
            return None
        if self._present is None:
            self._present = self._state_now()
        return self._present

    def _state_now(self) -> ThermalState:
        t, n = self.temperatures, self._network
        rows = range(n.rows)
        return ThermalState(
            inner_ring_temperature=np.array([t[n.inner(row)] for row in rows]),
            roller_temperature=np.array([t[n.rollers(row)] for row in rows]),
            outer_ring_temperature=np.array([t[n.outer(row)] for row in rows]),
            box_temperature=t[n.box],
            ambient_temperature=self._ambient,
            heat=np.array(self._heat),
            clearance_change=self._growth.clearance,
            clamped=self.clamped,
        )

    def truth(self, configuration: Configuration) -> dict[str, float]:
        """Return temperatures, heat and loss as the ground truth names them."""
        numbers: dict[str, float] = {}
        if self.network_on:
            numbers = {f"{name} [deg C]": value for name, value in zip(self._network.names, self.temperatures, strict=True)}
            numbers |= {
                f"row{row + 1}/{source} [W]": value
                for row, heat in enumerate(self._heat)
                for source, value in zip(HEAT_SOURCES, heat, strict=True)
            }
            numbers |= {"ambient [deg C]": configuration.thermal.ambient, "acceleration": configuration.thermal.acceleration}
            numbers["clamped"] = float(self.clamped)
            opposite = self.surroundings.opposite or self._opposite
            assert opposite is not None
            numbers |= {"opposite_box [deg C]": opposite.box, "opposite_outer_ring [deg C]": opposite.outer_ring}
            if self.surroundings != ALONE:
                numbers["brakes [W]"] = self.surroundings.journal_heat
        if self.active(configuration):
            numbers |= {"lubricant_loss": self.loss, "clearance_change [m]": self._growth.clearance}
        return numbers

    def _lose(self, c: Configuration) -> None:
        """Let the loss of lubricant approach that of the fault, and burn some of it."""
        condition, a = c.faults.condition, c.thermal.acceleration
        most = self._tick / condition.duration if condition.duration > 0.0 else math.inf
        without = self._lost - self._burnt
        without += min(max(condition.loss - without, -most), most)
        limit = c.thermal.grease_limit
        if self.network_on and limit > 0.0:
            above = max(max(self._steady.inlets(self.temperatures, row)) for row in range(self._network.rows)) - limit
            self._burnt += a * self._tick / HOUR * BURNING * max(above, 0.0)
        self._burnt = min(self._burnt, 1.0 - without)
        self._lost = without + self._burnt

    def _warm(self, c: Configuration, payload: Payload, state: State) -> None:
        """Step the temperatures over a tick."""
        speed = float(state.shaft[SHAFT_SPEED])
        share = self._tick / (AVERAGED + self._tick)
        sources, conductance = self._sources(c, payload, state)
        for row in range(self._network.rows):
            self._heat[row] = [old + share * (new - old) for old, new in zip(self._heat[row], sources[row], strict=True)]
            self._conductance[row] = [old + share * (new - old) for old, new in zip(self._conductance[row], conductance[row], strict=True)]
        self._ambient = c.thermal.ambient
        self.flow = self._flow(c, speed)
        heat = self._network.heat(self._heat, c.thermal.sun)
        if self.surroundings != ALONE:
            heat = self.surroundings.heated(self._network, heat, self.temperatures)
        duration = c.thermal.acceleration * self._tick
        self.temperatures = self._network.after(self.temperatures, self.flow, heat, c.thermal.ambient, duration)
        if self._sensors is not None:
            self._sensors.follow(c, self.temperatures, duration)
        if self._opposite is not None:  # also beside a real one, which may fail
            x, y = state.load.tolist()
            self._opposite.follow(_in_air(c, self.surroundings.air), speed, math.hypot(y, x), self._tick)
        self._count_clamped(c)

    def _check_hottest(self, time_ns: int) -> None:
        hottest = max(self.temperatures)
        if not hottest <= HOTTEST:
            name = self._network.names[self.temperatures.index(hottest)]
            raise failure_at(time_ns, f"{name} is hotter than {HOTTEST:g} deg C: the bearing has burnt off")

    def _flow(self, c: Configuration, speed: float) -> Conductances:
        raceways = [(inner, outer) for inner, outer in self._conductance]
        return self._network.conductances(raceways, vehicle_speed(c, speed), air_speed(c, speed) * self.surroundings.air)

    def _sources(self, c: Configuration, payload: Payload, state: State) -> tuple[list[list[float]], list[list[float]]]:
        """Return the mean heat of each row since the tick before [W], and the conductances of its raceways now [W/K]."""
        losses = friction_losses(state)
        since = losses if self._losses is None else losses - self._losses
        self._losses = losses
        rolling = entrainment_speeds(payload, state)
        speed, length = float(state.shaft[SHAFT_SPEED]), c.bearing.roller_length
        heats, conductances = [], []
        powers = [self._momentary(state, number, rolling[number]) for number in (0, 1)]
        for row, (sliding, resistance, contacts, *about_cage) in enumerate((since / self._tick).tolist()):
            both = powers[0][row] + powers[1][row]
            inner = powers[0][row] / both if both > 0.0 else 0.5
            raceways = sliding + resistance + contacts
            orbit = float(state.velocity[CAGE + row, 2])
            rest = sum(about_cage) + seal_heat(c, speed) + lost_in_grease(c, orbit, self.loss)
            heats.append([raceways * inner, raceways * (1.0 - inner), rest])
            conductances.append(
                [
                    raceway_conductance(forces[row], site, length, along)
                    for forces, site, along in zip(
                        (state.inner_force, state.outer_force), (payload.inner, payload.outer), rolling, strict=True
                    )
                ]
            )
        return heats, conductances

    @staticmethod
    def _momentary(state: State, number: int, rolling: float) -> list[float]:
        """Return the power that each row loses at a raceway at this instant [W]; the account has rows, but no raceways."""
        # Plain arrays: records look up each field by its name in Python.
        rollers: Any = state.rollers
        contacts = rollers.view(np.ndarray)["inner" if number == 0 else "outer"]
        force, friction, slip = (contacts[name][0] for name in ("force", "friction", "slip"))
        power = np.abs(friction * slip) + 2.0 * abs(rolling) * np.abs(contacts["film"]["resistance"][0])
        return [sum(row) for row in state.of_rollers(np.where(force > 0.0, power, 0.0)).tolist()]

    def _wanted(self, c: Configuration) -> Growth:
        """Return the radii that temperatures and faults ask for."""
        grown = expansion(c, self._network, self.temperatures) if self.network_on else Growth(0.0, 0.0, 0.0)
        return rounded(grown._replace(inner=grown.inner + c.faults.condition.clearance))

    def _fitted(self, c: Configuration, payload: Payload, rolling: tuple[float, float]) -> Payload:
        """Return the payload with the oil and the radii of now."""
        payload = resized(c, payload, self._growth)
        if c.lubrication.law == "dry":
            return payload
        wanted = self._oil_now(c)
        if wanted == self._oil:
            return payload
        self._oil = wanted
        return oiled(c, self._material, payload, wanted, rolling)

    def _oil_now(self, c: Configuration) -> OilState:
        """Return the state of the oil, at temperatures within the range of its formulas."""
        if not self.network_on:
            return oil_state(self.loss, c.lubrication.temperature, c.lubrication.temperature, c.faults.condition.oil_share)
        lubricant, law = lubricant_of(dict(c.lubrication)), c.lubrication.law
        inner, outer = (held(lubricant, law, inlet) for inlet in self._inlets())
        return oil_state(self.loss, inner, outer, c.faults.condition.oil_share)

    def _inlets(self) -> list[float]:
        """Return the temperatures of the oil at the inlets of inner and outer raceways, means of the rows [deg C]."""
        rows = [self._steady.inlets(self.temperatures, row) for row in range(self._network.rows)]
        return [sum(row[number] for row in rows) / len(rows) for number in (0, 1)]

    def _count_clamped(self, c: Configuration) -> None:
        """Count a tick at which the oil at a raceway is beyond the range of its formulas."""
        lubricant = lubricant_of(dict(c.lubrication))
        self.clamped += any(held(lubricant, c.lubrication.law, inlet) != inlet for inlet in self._inlets())


def _in_air(c: Configuration, share: float) -> Configuration:
    """Return a configuration whose box has a share of the air."""
    if share == 1.0:
        return c
    return c.model_copy(update={"thermal": c.thermal.model_copy(update={"exposure": share * c.thermal.exposure})})
