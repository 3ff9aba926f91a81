"""Base of the stages of the measurement chain."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple, TypeVar

from dcrb_ros.measurement.parameters import Accelerometer
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group

Kind = TypeVar("Kind", bound=Group)


@dataclass(frozen=True)
class Parameters:
    """The parameter groups that the chain depends on."""

    structure: Group
    background: Group
    sensor: Group

    def __getitem__(self, kind: type[Kind]) -> Kind:
        """Return the group that has the fields of ``kind``, the parameter class of a stage.

        Raises:
            KeyError: no group has these fields.
        """
        for group in (self.structure, self.background, self.sensor):
            if isinstance(group, kind):
                return group
        raise KeyError(kind.__name__)


@dataclass(frozen=True)
class Setup:
    """Parameters, rate and seed from which a measurement chain is built."""

    parameters: Parameters
    step_rate: int
    """Time steps per simulated second [Hz]."""
    seed: int
    """Seed of every random number."""
    wheel_diameter: float
    """Diameter of the wheel on the shaft [m]."""
    speed: float
    """Speed of the shaft at time zero [rad/s]."""

    @property
    def sampling_rate(self) -> int:
        """Sampling rate [Hz]."""
        return self.parameters[Accelerometer].sampling_rate

    @property
    def steps_per_sample(self) -> int:
        """Time steps between two samples [-]."""
        return self.step_rate // self.sampling_rate


class Span(NamedTuple):
    """The ticks that a stage processes in one call: time steps, or samples."""

    first: int
    """Number of the first tick since the start."""
    angle: Floats
    """Shaft angle at the tick before the first one and at every tick, shape (ticks + 1,) [rad]."""


class Stage(ABC):
    """A stage of the measurement chain: acceleration in, acceleration out.

    A stage carries its state from call to call, so that the result does not depend on how the samples are split into calls. It is
    skipped while it is not `active`. A subclass declares its parameters in `parameters` and reads them in `set_parameters`.
    """

    parameters: ClassVar[type[Group]] = Group
    """Fields that the stage adds to the configuration."""
    group: ClassVar[Literal["structure", "background", "sensor"]] = "sensor"
    """Group of the configuration to which it adds them."""

    def __init__(self, setup: Setup, rate: float) -> None:
        """Prepare for samples at a rate [Hz]; `set_parameters` is called before the first sample."""
        self.setup, self.rate = setup, rate

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        """Yield a sentence for every combination of parameters that the stage cannot work with at a step rate [Hz]."""
        yield from ()

    def set_parameters(self, parameters: Parameters, tick: int) -> None:  # noqa: B027 - a stage without parameters needs none
        """Use these parameters from a tick on; called at tick 0 and at every change while the simulation runs."""

    @property
    def active(self) -> bool:
        """Whether the stage changes the samples at present."""
        return True

    @abstractmethod
    def process(self, acceleration: Floats, span: Span) -> Floats:
        """Return the acceleration after this stage; both have shape (ticks, 2), X and Y [m/s^2]. The input must not be modified."""
