"""A simulated run as arrays, in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.bearing.tacho_pulses import TachoPulses
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.faults.ground_truth import summary_of
from dcrb_ros.schema.arrays import Samples
from dcrb_ros.schema.numbers import duration_within
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.ground_truth import GroundTruth
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import ScheduledChange, read_scenario_file, scheduled_changes, starting_configuration
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.late_scenario import refuse_late

LONGEST = 3600.0
"""Longest run that is returned as arrays [s]."""

Kind = TypeVar("Kind", bound="SimulationResult")


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SimulationResult(Waveform):
    """The result of `simulate`: the measured waveform, the bodies, and the ground truth."""

    clean: Samples
    """Acceleration of the outer ring after the anti-alias filter, without any other stage of the chain, shape (samples, 2) [m/s^2]."""
    states: StateHistory
    """The bodies over time, at ``publishing.state_rate``."""
    truth: GroundTruth
    """Speed, load and faults over time, and the temperatures of all bodies [deg C]."""
    temperatures: TemperatureReadings
    """What the temperature sensors read; empty unless ``thermal.law`` is network."""
    tacho: TachoPulses
    """The pulses of the tacho; empty unless ``tacho.pulses_per_turn`` is above 0."""
    configuration: Configuration
    """The configuration at the start of the run."""

    def _described(self) -> str:
        return f"{super()._described()}, {summary_of(self.truth.faults)}"

    def _cut(self: Kind, samples: slice) -> Kind:
        return replace(super()._cut(samples), clean=self.clean[samples])

    def _columns(self) -> dict[str, npt.NDArray[Any]]:
        return {**super()._columns(), "ax_clean": self.clean[:, 0], "ay_clean": self.clean[:, 1]}


def simulate(
    configuration: Configuration | str | Path = "healthy",
    duration: float = 1.0,
    *,
    settings: Mapping[str, Any] | Sequence[str] | str = (),
    scenario: Mapping[str, Any] | str | Path | None = None,
    seed: int | None = None,
) -> SimulationResult:
    """Simulate a bearing and return what its sensor measured, as arrays.

    The same arguments give the same samples, bit for bit, on the same kind of processor. The first call on a machine
    compiles the kernels, which takes 15 s to over a minute.

    Parameters
    ----------
    configuration
        A `Configuration`, the name of a shipped one (``"healthy"``, ``"outer_ring_defect"`` ...) or a YAML file.
    duration
        Simulated time, up to 3600 s; `Simulation` yields a run of any length block by block [s].
    settings
        Parameters to change: ``{"operating.speed": 100.0}``, nested or with dotted keys, or ``["operating.speed=100.0"]``.
    scenario
        A timeline of speed, load and faults: the name of a shipped one (``"run_up"`` ...), a YAML file or its content.
    seed
        Seed of every random number; that of the configuration by default.

    Returns
    -------
    SimulationResult
        Acceleration (samples, 2) [m/s^2], shaft angle [rad], the bodies and the ground truth. Blocks that the configuration loses on
        their way (``publishing.loss_probability``) are left out, and `SimulationResult.index` jumps there.

    Raises
    ------
    Refusal
        An unknown configuration or parameter, a value out of range, or a duration that is not above 0 and at most 3600 s.

    Examples
    --------
    >>> import dcrb_ros
    >>> run = dcrb_ros.simulate("outer_ring_defect", 0.5, settings={"operating.speed": 100.0}, seed=3)
    >>> run
    <SimulationResult: 0.5 s at 51.2 kHz (25600 samples), shaft at 15.93 Hz, outer_1: 2 mm wide>
    >>> run.acceleration.shape, run.states.azimuth.shape
    ((25600, 2), (49, 35))
    """
    duration = duration_within("duration =", duration, LONGEST, "longer runs are simulated block by block with dcrb_ros.Simulation")
    asked = load_configuration(configuration, settings)
    if seed is not None:
        asked = load_configuration(asked, {"simulation.seed": seed})
    start, events = asked, list[ScheduledChange]()
    if scenario is not None:
        tree, source = (read_scenario_file(Path(scenario)), str(scenario)) if isinstance(scenario, (str, Path)) else (scenario, "scenario")
        start = starting_configuration(tree, asked, source)
        events = scheduled_changes(tree, start, source)
        refuse_late(tree, duration, source, "simulate longer, or leave out the scenario")
    rate = start.sensor.sampling_rate
    if round(duration * rate) < 1:
        raise Refusal(f"duration = {duration:g} s is shorter than one sample ({1e6 / rate:.3g} us at {rate} Hz): simulate longer")
    simulation = Simulation(start, events)
    names = simulation.bodies.names
    blocks = list(simulation.blocks(duration))
    kept = [block for block in blocks if not block.lost]
    if not kept:
        raise Refusal(f"every block of the {duration:g} s is lost: lower publishing.loss_probability, or simulate longer")
    measured = waveform_of(kept, start)
    return SimulationResult(
        **{field.name: getattr(measured, field.name) for field in fields(measured)},
        clean=np.concatenate([block.clean for block in kept]),
        states=StateHistory.of([states for block in blocks for states in block.states], names),
        truth=GroundTruth.of([truth for block in blocks for truth in block.truths]),
        temperatures=temperatures_of(blocks),
        tacho=tacho_of(kept, start.tacho.pulses_per_turn),
        configuration=start,
    )


def temperatures_of(blocks: Sequence[Block]) -> TemperatureReadings:
    """Return what the temperature sensors read during some blocks."""
    readings = [reading for block in blocks for reading in block.temperatures]
    sensors = {name: np.array([getattr(reading, name) for reading in readings], np.float64) for name in ("outer_ring", "box", "ambient")}
    return TemperatureReadings(time=np.array([reading.time_ns * 1e-9 for reading in readings], np.float64), **sensors)


def tacho_of(blocks: Sequence[Block], pulses_per_turn: int) -> TachoPulses:
    """Return the pulses of the tacho during some blocks, at least one."""
    time_ns, number = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("pulse_ns", "pulse_number"))
    return TachoPulses(time=time_ns * 1e-9, number=number, pulses_per_turn=pulses_per_turn)


def waveform_of(blocks: Sequence[Block], configuration: Configuration) -> Waveform:
    """Return the waveform of some blocks, at least one."""
    return Waveform(
        acceleration=np.concatenate([block.acceleration for block in blocks]),
        shaft_angle=np.concatenate([block.shaft_angle for block in blocks]),
        index=np.concatenate([block.index + np.arange(len(block.shaft_angle), dtype=np.int64) for block in blocks]),
        sampling_rate=configuration.sensor.sampling_rate,
        orders=characteristic_orders(configuration.bearing),
        sensor_range=blocks[-1].range,
    )
