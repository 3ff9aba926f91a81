"""The whole measurement chain: the stages of the registry at their rates, with the anti-alias filter and the sample clock in between."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.decimation import Decimator
from dcrb_ros.measurement.registry import PER_CONVERSION, PER_SAMPLE, PER_STEP
from dcrb_ros.measurement.sample_clock import ClockParameters, SampleClock
from dcrb_ros.measurement.scheduled_changes import ScheduledChanges
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.measurement.stages.measuring_range import MeasuringRange
from dcrb_ros.schema.arrays import Floats


@dataclass(frozen=True)
class Measurement:
    """Consecutive samples of the sensor; arrays of shape (samples, 2)."""

    clean: npt.NDArray[np.float64]
    """Acceleration of the outer ring after the anti-alias filter, without any stage [m/s^2]."""
    measured: npt.NDArray[np.float64]
    """Acceleration after all stages [m/s^2]."""
    clipped: npt.NDArray[np.bool_]
    """Whether any axis of a sample was beyond the range, shape (samples,)."""
    angle: npt.NDArray[np.float64]
    """Rotation of the inner ring when a sample was taken, shape (samples,) [rad]."""


class StageSequence:
    """Stages that run one after the other at the same rate."""

    def __init__(self, stages: Sequence[type[Stage]], setup: Setup, rate: float) -> None:
        self.stages = [stage(setup, rate) for stage in stages]
        self.changes: ScheduledChanges[Parameters] = ScheduledChanges(self._set_parameters)
        """Parameter changes by tick."""
        self._angle: float | None = None
        self._first_turn = setup.speed / rate
        self._set_parameters(setup.parameters, 0)

    def _set_parameters(self, parameters: Parameters, tick: int) -> None:
        for stage in self.stages:
            stage.set_parameters(parameters, tick)

    def modifies(self, count: int) -> bool:
        """Return whether any stage is active within the next ``count`` ticks."""
        return any(stage.active for stage in self.stages) or self.changes.due(count)

    def process(self, acceleration: Floats, angle: Floats) -> Floats:
        """Return the acceleration after the stages; both have shape (ticks, 2) [m/s^2], the shaft ``angle`` (ticks,) [rad]."""
        if not len(angle):
            return acceleration
        before = float(angle[0]) - self._first_turn if self._angle is None else self._angle
        self._angle = float(angle[-1])
        if not self.modifies(len(angle)):
            self.changes.skip(len(angle))
            return acceleration
        angles, first, parts = np.concatenate([[before], angle]), self.changes.reached, []
        for piece in self.changes.pieces(len(acceleration)):
            part, span = acceleration[piece], Span(first + piece.start, angles[piece.start : piece.stop + 1])
            for stage in self.stages:
                if stage.active:
                    part = stage.process(part, span)
            parts.append(part)
        return parts[0] if len(parts) == 1 else np.concatenate(parts)


class Sensor:
    """The chain from the acceleration at every time step to measured samples; the same bits for any block size."""

    def __init__(self, setup: Setup) -> None:
        self._factor = setup.steps_per_sample
        self._decimator = Decimator(self._factor, between=True)
        self._modified_decimator: Decimator | None = None
        """Decimator of the modified acceleration; none as long as the stages before it have modified nothing."""
        rate = float(setup.sampling_rate)
        self._per_step = StageSequence(PER_STEP, setup, float(setup.step_rate))
        self._per_sample = StageSequence(PER_SAMPLE, setup, rate)
        self._per_conversion = StageSequence(PER_CONVERSION, setup, rate)
        self._range = next(stage for stage in self._per_conversion.stages if isinstance(stage, MeasuringRange))
        clock = setup.parameters[ClockParameters]
        self._clock = SampleClock(setup) if clock.clock_offset_ppm or clock.clock_jitter else None
        self._angles = np.zeros(0)

    def change(self, parameters: Parameters, sample: int) -> None:
        """Measure with other parameters from ``sample`` on, which must not be before that of an earlier call."""
        self._per_step.changes.add(sample * self._factor, parameters)
        self._per_sample.changes.add(sample, parameters)
        self._per_conversion.changes.add(self._clock.sample_at(sample) if self._clock else sample, parameters)

    def steps(self, samples: int) -> int:
        """Return the time steps needed to measure so many ``samples`` [-]."""
        nominal = samples if self._clock is None else max(samples, self._clock.needed(samples))
        return (nominal - 1) * self._factor + self._decimator.lead + 1

    def measure(self, acceleration: npt.NDArray[np.float64], angle: npt.NDArray[np.float64]) -> Measurement:
        """Return the samples that are complete after ``acceleration``, means over each time step, shape (steps, 2) [m/s^2].

        ``angle`` is the shaft angle at the start of each step, shape (steps,) [rad].
        """
        clean, samples = self._decimated(acceleration, angle)
        # The angle of a sample is known before the anti-alias filter returns the sample.
        self._angles = np.concatenate([self._angles, angle])
        known = len(clean) * self._factor
        angles, self._angles = self._angles[: known : self._factor], self._angles[known:]
        samples = self._per_sample.process(samples, angles)
        if self._clock is not None:
            samples, angles = self._clock.process(samples, angles)
        measured = self._per_conversion.process(samples, angles)
        return Measurement(clean, measured, self._range.take_clipped(), angles)

    def _decimated(
        self, acceleration: npt.NDArray[np.float64], angle: npt.NDArray[np.float64]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return the acceleration of the outer ring and of the sensor, both after the anti-alias filter [m/s^2]."""
        if self._modified_decimator is None and self._per_step.modifies(len(acceleration)):
            # Both were equal until now, and so were the states of their filters.
            self._modified_decimator = copy.deepcopy(self._decimator)
        clean = self._decimator.process(acceleration)
        modified = self._per_step.process(acceleration, angle)
        return clean, clean if self._modified_decimator is None else self._modified_decimator.process(modified)
