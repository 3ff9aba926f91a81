"""The comparing detector over the whole signals of a vehicle in one call."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import PIECE, Piece, Signal
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import TemperatureFeed, temperatures_of
from dcrb_ros.diagnosis.vehicle.detector import BoxBlock, VehicleDetector
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.schema.arguments import checked_arguments, with_attributes
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, Status, VehicleDiagnosis, kind_of
from dcrb_ros.text.counts import counted


class VehicleSignals(Protocol):
    """The signals of a vehicle, as a `VehicleRecording` has them."""

    @property
    def description(self) -> VehicleDescription:
        """What is known about the vehicle."""

    @property
    def boxes(self) -> Mapping[str, Signal]:
        """The signal of each box by name, such as ``axle_1.left``."""


@dataclass(frozen=True, repr=False)
class VehicleDetectionResult:
    """Diagnoses of a vehicle by the comparing detector, one per hop."""

    history: tuple[VehicleDiagnosis, ...]
    """The diagnoses in the order of time; the boxes of `last` alone have spectra, since those of an hour take 0.8 GB a box."""

    def __repr__(self) -> str:
        return f"<VehicleDetectionResult: {self.summary} after {self.last.time:.2f} s>"

    @property
    def summary(self) -> str:
        """The damaged bearings, and the number of bearings without a verdict, in words."""
        bearings = [status.verdict for name, status in self.statuses.items() if kind_of(name) == "bearing"]
        found = [f"{box} {verdict}" for box, verdict in self.damaged.items()]
        if open_ := sum(verdict in ("waiting", UNDECIDED) for verdict in bearings):
            found.append(f"no verdict on {open_} of {counted(len(bearings), 'bearing')}")
        return ", ".join(found) or "no bearing damaged"

    @property
    def last(self) -> VehicleDiagnosis:
        """The last diagnosis."""
        return self.history[-1]

    @property
    def statuses(self) -> dict[str, Status]:
        """The last verdict on each part other than ``waiting``, or the last one if all are."""
        chosen = {}
        for name, status in self.last.statuses.items():
            judged = (diagnosis.statuses[name] for diagnosis in reversed(self.history) if diagnosis.statuses[name].verdict != "waiting")
            chosen[name] = next(judged, status)
        return chosen

    @property
    def damaged(self) -> dict[str, str]:
        """The verdicts on damaged bearings by box."""
        return VehicleDiagnosis(self.last.index, self.last.time, self.statuses, {}).damaged()


@checked_arguments(signals=with_attributes("description", "boxes", kind="a VehicleRecording"))
def detect_vehicle(
    signals: VehicleSignals,
    *,
    parameters: VehicleDetectorParameters | None = None,
    box_parameters: DetectorParameters | None = None,
) -> VehicleDetectionResult:
    """Run the comparing detector over the recording of a vehicle.

    Parameters
    ----------
    signals
        A `VehicleRecording`, or an object with a ``description`` and the signals of its ``boxes``. A signal with ``temperatures`` is also
        judged by these.
    parameters, box_parameters
        Parameters of the comparison and of the fault detector of each box; the defaults otherwise.

    Returns
    -------
    VehicleDetectionResult
        The last verdict on each part, and the history.

    Raises
    ------
    Refusal
        The signals are too short, or are not those of the description, such as at another sampling rate.

    Examples
    --------
    >>> import dcrb_ros
    >>> result = dcrb_ros.detect_vehicle(dcrb_ros.VehicleRecording("bags/bogie"))  # doctest: +SKIP
    >>> result.damaged  # doctest: +SKIP
    {'axle_1/left': 'outer_ring'}
    """
    detector = VehicleDetector(signals.description, parameters or VehicleDetectorParameters(), box_parameters or DetectorParameters())
    boxes = {name.replace(".", "/"): signal for name, signal in signals.boxes.items()}
    for name, signal in boxes.items():
        if signal.sampling_rate != detector.description.sampling_rate:
            raise Refusal(
                f"the signal of {name} is sampled at {signal.sampling_rate} Hz, the boxes of the description at "
                f"{detector.description.sampling_rate} Hz: resample it"
            )
    readings = {name: temperatures_of(signal) for name, signal in boxes.items()}
    history = list[VehicleDiagnosis]()
    for diagnosis in diagnoses_of({name: signal.pieces() for name, signal in boxes.items()}, detector, readings):
        if history:
            history[-1] = replace(history[-1], boxes={name: each.without_spectrum() for name, each in history[-1].boxes.items()})
        history.append(diagnosis)
    if not history:
        raise Refusal("the signals are too short for a diagnosis of the vehicle: record some seconds")
    return VehicleDetectionResult(tuple(history))


def diagnoses_of(
    boxes: Mapping[str, Iterable[Piece]], detector: VehicleDetector, readings: Mapping[str, TemperatureReadings] | None = None
) -> Iterator[VehicleDiagnosis]:
    """Yield the diagnoses by a ``detector``, which takes the pieces and ``readings`` of all boxes, by name, in the order of time."""
    rate, feeds = detector.description.sampling_rate, {name: TemperatureFeed(each) for name, each in (readings or {}).items()}
    parts = (_parts(name, pieces, max(1, int(PIECE * rate))) for name, pieces in boxes.items())
    # By time, not by number: after lost blocks a box has fewer pieces than the others.
    for name, piece in heapq.merge(*parts, key=lambda named: named[1].first_index):
        detector.take_range(name, piece.sensor_range)
        diagnosis = detector.add({name: BoxBlock(piece.first_index, piece.acceleration, piece.shaft_angle)})
        if name in feeds:
            feeds[name].give(partial(detector.take_temperature, name), piece.end_index / rate)
        if diagnosis is not None:
            yield diagnosis
    yield from detector.finish()


def _parts(name: str, pieces: Iterable[Piece], length: int) -> Iterator[tuple[str, Piece]]:
    """Yield the name of a box with each of its pieces, divided into at most ``length`` samples: the others are never far behind."""
    for piece in pieces:
        for start in range(0, len(piece.shaft_angle), length):
            part = slice(start, start + length)
            yield name, Piece(piece.first_index + start, piece.acceleration[part], piece.shaft_angle[part], piece.sensor_range)
