"""A detector written in Python during one scenario. This module does not import the exam: it runs in the process of the detector, too."""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.verdicts import VERDICTS
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import BOX_PARTS, QUIET_VERDICTS, VEHICLE_VERDICTS, VehicleDiagnosis, kind_of

Result = TypeVar("Result")


class Detector(Protocol):
    """A fault detector that processes a signal block by block, as `dcrb_ros.FaultDetector` does."""

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any], /) -> Diagnosis | str | None:
        """Process a block; return a diagnosis or a verdict (``"healthy"``, ``"outer_ring"`` ...), or None if there is none yet."""


DetectorFactory = Callable[[Orders, int], Detector]
"""Called with the characteristic orders of the bearing and the sampling rate [Hz]; returns a new detector."""


class DetectorBlock(NamedTuple):
    """A block and the temperatures up to its end: everything that a detector receives at once."""

    first_index: int
    """Index of the first sample."""
    acceleration: npt.NDArray[Any]
    """Shape (samples, 2) [m/s^2]."""
    shaft_angle: npt.NDArray[Any]
    """Shape (samples,) [rad]."""
    sensor_range: float
    """Range of the sensor [m/s^2]; 0 if unknown."""
    temperatures: tuple[tuple[float, float, float], ...]
    """Time [s], temperature of the bearing and of the air [deg C] of each new reading."""

    @property
    def end(self) -> int:
        """Index after the last sample."""
        return self.first_index + len(self.shaft_angle)


class RunningDetector:
    """A detector during one scenario.

    A detector with a method ``take_temperature`` receives the readings of outer ring and air, too, one with ``take_bearing`` the bearing.
    """

    def __init__(self, factory: DetectorFactory, orders: Orders, rate: int, bearing: Callable[[], object]) -> None:
        """Make the detector; ``bearing`` returns the bearing, or None if it is unknown.

        Raises:
            Refusal: it has no ``update``.
            RuntimeError: it raised an exception.
        """
        self._detector: Any = _called("its class", "", lambda: factory(orders, rate))
        if not callable(getattr(self._detector, "update", None)):
            raise Refusal(f"the detector {self._detector!r} has no method update(index, acceleration, shaft_angle): give it one")
        if hasattr(self._detector, "take_bearing"):
            _called("take_bearing", "", lambda: self._detector.take_bearing(bearing()))

    def take(self, block: DetectorBlock) -> Any:
        """Give it a block and return its output, which may be anything.

        Raises:
            RuntimeError: it raised an exception.
        """
        detector, where = self._detector, f" at sample {block.first_index}"
        if hasattr(detector, "sensor_range"):
            detector.sensor_range = block.sensor_range
        output = _called("update", where, lambda: detector.update(block.first_index, block.acceleration, block.shaft_angle))
        if hasattr(detector, "take_temperature"):
            for reading in block.temperatures:
                _called("take_temperature", where, lambda: detector.take_temperature(*reading))  # noqa: B023
        return output


def _called(what: str, where: str, call: Callable[[], Result]) -> Result:
    """Return the result of a detector's method; an exception, also that of `sys.exit`, becomes a sentence."""
    try:
        return call()
    except (Exception, SystemExit) as error:
        text = f": {error}" if str(error) else ""
        raise RuntimeError(f"{what} failed{where}: {type(error).__name__}{text}") from error


def checked_output(output: Any) -> Diagnosis | str | None:
    """Return the output of a detector.

    Raises:
        Refusal: it is neither a diagnosis nor a verdict nor None.
    """
    if output is None or isinstance(output, Diagnosis):
        return output
    if not isinstance(output, str) or output not in VERDICTS:
        known = f"{', '.join(VERDICTS)}{nearest(str(output), VERDICTS)}"
        raise Refusal(f"update returned {output!r}, which is not a verdict: return one of {known}")
    return str(output)


VehicleDetectorFactory = Callable[[VehicleDescription], Any]
"""Called with the description of the vehicle; returns a detector whose ``add(blocks)`` takes a block of every box by name."""


@dataclass(frozen=True)
class BoxSamples:
    """A block of one box of a vehicle."""

    index: int
    """Index of the first sample."""
    acceleration: npt.NDArray[Any]
    """Shape (samples, 2) [m/s^2]."""
    shaft_angle: npt.NDArray[Any] | None
    """Shape (samples,) [rad]; None without a tachometer."""
    temperatures: tuple[tuple[float, float, float], ...] = ()
    """Time [s], temperature of the bearing and of the air [deg C] of each reading during the block."""


class RunningVehicleDetector:
    """A detector of a vehicle during one scenario.

    A detector with a method ``take_temperature(box, time, temperature, ambient)`` receives the readings, too.
    """

    def __init__(self, factory: VehicleDetectorFactory, description: VehicleDescription) -> None:
        """Make the detector.

        Raises:
            Refusal: it has no ``add``.
            RuntimeError: it raised an exception.
        """
        self._detector: Any = _called("its class", "", lambda: factory(description))
        if not callable(getattr(self._detector, "add", None)):
            raise Refusal(f"the detector {self._detector!r} has no method add(blocks) for the blocks of all boxes: give it one")
        self._description = description

    def take(self, blocks: Mapping[str, BoxSamples]) -> dict[str, tuple[str, float | None]] | None:
        """Give it a block of every box; return verdict and score by status, or None.

        Raises:
            Refusal: its output is invalid.
            RuntimeError: it raised an exception.
        """
        where = f" at sample {min(block.index for block in blocks.values())}"
        output = _called("add", where, lambda: self._detector.add(blocks))
        if hasattr(self._detector, "take_temperature"):
            for name, block in blocks.items():
                for reading in block.temperatures:
                    _called("take_temperature", where, lambda: self._detector.take_temperature(name, *reading))  # noqa: B023
        return checked_statuses(output, self._description)


def checked_statuses(output: Any, description: VehicleDescription) -> dict[str, tuple[str, float | None]] | None:
    """Return verdict and score [dB] by status from the output of a detector of a vehicle; a mapping has no scores.

    Raises:
        Refusal: it is neither a `VehicleDiagnosis` nor a mapping from statuses to verdicts nor None, names a box that the vehicle lacks, or
            has an unknown verdict or a score that is no number.
    """
    if output is None:
        return None
    if isinstance(output, VehicleDiagnosis):
        returned: dict[Any, tuple[Any, Any]] = {name: (status.verdict, status.score) for name, status in output.statuses.items()}
    elif isinstance(output, Mapping):
        returned = {name: (verdict, None) for name, verdict in output.items()}
    else:
        raise Refusal(f"add returned {output!r}: return a VehicleDiagnosis, or a mapping such as {{'axle_1/left/bearing': 'outer_ring'}}")
    statuses: dict[str, tuple[str, float | None]] = {}
    for name, (verdict, score) in returned.items():
        kind = kind_of(str(name))
        if kind not in VEHICLE_VERDICTS:
            raise Refusal(f"add returned the status {name!r}: its last part must be one of {', '.join(VEHICLE_VERDICTS)}")
        known = (*QUIET_VERDICTS, *VEHICLE_VERDICTS[kind])
        if verdict not in known:
            raise Refusal(f"add returned {verdict!r} for {name}: return one of {', '.join(known)}{nearest(str(verdict), known)}")
        if score is not None and not (isinstance(score, numbers.Real) and math.isfinite(score)):
            raise Refusal(f"add returned the score {score!r} for {name}: return the evidence relative to its threshold [dB]")
        statuses[str(name)] = str(verdict), score if score is None else float(score)
    _check_boxes(statuses, description)
    return statuses


def _check_boxes(names: Iterable[str], description: VehicleDescription) -> None:
    """Refuse a status on a part of a box that the vehicle does not have; it would count for no box."""
    boxes = [box.name for box in description.boxes]
    for name in names:
        box, _, part = name.rpartition("/")
        if part in BOX_PARTS and box not in boxes:
            raise Refusal(f"add returned the status {name!r}: there is no box {box!r}{nearest(box, boxes)} (known: {', '.join(boxes)})")
