"""A detector under evaluation, run in this process on a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy.typing as npt

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import TemperatureFeed, ThermalFaultDetector
from dcrb_ros.exam.case import Case
from dcrb_ros.exam.recording_cache import cached_recording
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.verdicts import VERDICTS
from dcrb_ros.stream.diagnosis import Diagnosis


class Detector(Protocol):
    """A fault detector that processes a signal block by block, as `dcrb_ros.FaultDetector` does."""

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any], /) -> Diagnosis | str | None:
        """Process a block; return a diagnosis or a verdict (``"healthy"``, ``"outer_ring"`` ...), or None if there is none yet."""


DetectorFactory = Callable[[Orders, int], Detector]
"""Called with the characteristic orders of the bearing and the sampling rate [Hz]; returns a new detector."""


def run_detector(factory: DetectorFactory, bag: Path) -> list[ReceivedDiagnosis]:
    """Return a detector's diagnoses of a recording, decoded from the messages that a node would publish.

    Raises:
        Refusal: the recording cannot be read, or the detector has no ``update`` or returns an unknown verdict.
        RuntimeError: the detector raised an exception.
    """
    recording = Recording(bag)
    return run_on_pieces(
        factory, recording.pieces(), recording.orders, recording.sampling_rate, recording.bearing, recording.temperatures()
    )


def run_on_pieces(
    factory: DetectorFactory,
    pieces: Iterable[Piece],
    orders: Orders,
    rate: int,
    bearing: object = None,
    temperatures: TemperatureReadings | None = None,
) -> list[ReceivedDiagnosis]:
    """Return a detector's diagnoses of consecutive blocks at a sampling rate [Hz]; the shipped one may know the ``bearing``.

    A detector with a method ``take_temperature`` gets the readings of outer ring and air, too.

    Raises:
        Refusal, RuntimeError: as `run_detector`.
    """
    detector, diagnoses, feed = factory(orders, rate), [], TemperatureFeed(temperatures or TemperatureReadings.none())
    if not callable(getattr(detector, "update", None)):
        raise Refusal(f"the detector {detector!r} has no method update(index, acceleration, shaft_angle): give it one")
    if isinstance(detector, FaultDetector):
        detector.take_bearing(bearing)
    for piece in pieces:
        if hasattr(detector, "sensor_range"):
            detector.sensor_range = piece.sensor_range
        try:
            output = detector.update(piece.first_index, piece.acceleration, piece.shaft_angle)
        except Exception as error:
            raise RuntimeError(f"update failed at sample {piece.first_index}: {type(error).__name__}: {error}") from error
        if hasattr(detector, "take_temperature"):
            feed.give(detector.take_temperature, (piece.first_index + len(piece.shaft_angle)) / rate)
        if output is not None:
            diagnoses.append(_received(output, (piece.first_index + len(piece.shaft_angle) - 1) / rate))
    return diagnoses


def run_shipped_detector(bag: Path, parameters: DetectorParameters) -> list[ReceivedDiagnosis]:
    """Return the shipped detector's diagnoses of a recording."""
    return run_detector(partial(ThermalFaultDetector, parameters=parameters), bag)


def run_shipped_detector_on_case(case: Case, folder: Path, parameters: DetectorParameters) -> list[ReceivedDiagnosis]:
    """Return the shipped detector's diagnoses of a case; simulate the case if ``folder`` has no recording of it."""
    return run_shipped_detector(cached_recording(case, folder), parameters)


def _received(output: Diagnosis | str, time: float) -> ReceivedDiagnosis:
    """Return the output of a detector at a time [s] in the form that the exam evaluates."""
    if isinstance(output, Diagnosis):
        return decode_diagnosis(encode_diagnosis(output))
    if output not in VERDICTS:
        known = f"{', '.join(VERDICTS)}{nearest(str(output), VERDICTS)}"
        raise Refusal(f"update returned {output!r}, which is not a verdict: return one of {known}")
    return ReceivedDiagnosis(time, output)
