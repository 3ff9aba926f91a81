"""A detector under evaluation, run in this process on a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy.typing as npt

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import TemperatureFeed, ThermalFaultDetector
from dcrb_ros.exam.evaluation import Outcome
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.verdicts import VERDICTS
from dcrb_ros.stream.diagnosis import Diagnosis

SHIPPED = "the shipped detector"


class Detector(Protocol):
    """A fault detector that processes a signal block by block, as `dcrb_ros.FaultDetector` does."""

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any], /) -> Diagnosis | str | None:
        """Process a block; return a diagnosis or a verdict (``"healthy"``, ``"outer_ring"`` ...), or None if there is none yet."""


class Signal(Protocol):
    """The signal of a scenario in blocks, as a `Recording` has it."""

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""

    @property
    def sampling_rate(self) -> int:
        """[Hz]"""

    @property
    def bearing(self) -> object:
        """The bearing; None if it is unknown."""

    def pieces(self) -> Iterable[Piece]:
        """Return consecutive blocks."""

    def temperatures(self) -> TemperatureReadings:
        """Return the readings of the thermometers."""


DetectorFactory = Callable[[Orders, int], Detector]
"""Called with the characteristic orders of the bearing and the sampling rate [Hz]; returns a new detector."""


def run_detector(factory: DetectorFactory, signal: Signal) -> Outcome:
    """Return a detector's diagnoses of a signal, decoded from the messages that a node would publish.

    A detector with a method ``take_temperature`` gets the readings of outer ring and air, too; the shipped one uses the bearing.

    Raises:
        Refusal: the signal cannot be read, or the detector has no ``update`` or returns an unknown verdict.
        RuntimeError: the detector raised an exception.
    """
    rate = signal.sampling_rate
    detector, diagnoses, feed = factory(signal.orders, rate), [], TemperatureFeed(signal.temperatures())
    if not callable(getattr(detector, "update", None)):
        raise Refusal(f"the detector {detector!r} has no method update(index, acceleration, shaft_angle): give it one")
    if isinstance(detector, FaultDetector):
        detector.take_bearing(signal.bearing)
    for piece in signal.pieces():
        if hasattr(detector, "sensor_range"):
            detector.sensor_range = piece.sensor_range
        try:
            output = detector.update(piece.first_index, piece.acceleration, piece.shaft_angle)
        except Exception as error:
            raise RuntimeError(f"update failed at sample {piece.first_index}: {type(error).__name__}: {error}") from error
        end = piece.first_index + len(piece.shaft_angle)
        if hasattr(detector, "take_temperature"):
            feed.give(detector.take_temperature, end / rate)
        if output is not None:
            diagnoses.append(_received(output, (end - 1) / rate))
    return Outcome(diagnoses)


@dataclass(frozen=True)
class PythonDetector:
    """A detector written in Python as a candidate; a new one is made for every scenario."""

    name: str
    factory: DetectorFactory
    parallel: bool = True
    """Whether scenarios are evaluated in processes of their own, to which the factory is pickled."""

    def diagnose(self, signal: Signal) -> Outcome:
        """Return its diagnoses of a signal; see `run_detector`."""
        return run_detector(self.factory, signal)


def shipped_detector(parameters: DetectorParameters, name: str = SHIPPED) -> PythonDetector:
    """Return the shipped detector as a candidate."""
    return PythonDetector(name, partial(ThermalFaultDetector, parameters=parameters))


def _received(output: Diagnosis | str, time: float) -> ReceivedDiagnosis:
    """Return the output of a detector at a time [s] in the form that the exam evaluates."""
    if isinstance(output, Diagnosis):
        return decode_diagnosis(encode_diagnosis(output))
    if output not in VERDICTS:
        known = f"{', '.join(VERDICTS)}{nearest(str(output), VERDICTS)}"
        raise Refusal(f"update returned {output!r}, which is not a verdict: return one of {known}")
    return ReceivedDiagnosis(time, output)
