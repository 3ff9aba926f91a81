"""The comparing detector of a vehicle: blocks of all axle boxes in, one diagnosis of the vehicle for every hop out.

Each box has a fault detector of its own. What they suspect is compared among the boxes before it becomes a verdict.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import ThermalFaultDetector
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import Status, VehicleDiagnosis

DEFAULTS = DetectorParameters()
VEHICLE_DEFAULTS = VehicleDetectorParameters()


@dataclass(frozen=True)
class BoxBlock:
    """Consecutive samples of one box; a `dcrb_ros.Block` serves as well."""

    index: int
    """Index of the first sample since the start."""
    acceleration: npt.NDArray[Any]
    """Shape (samples, axes) [m/s^2]."""
    shaft_angle: npt.NDArray[Any] | None = None
    """Rotation of the shaft, shape (samples,) [rad]; None without a tachometer."""


class BlockLike(Protocol):
    """What the detector reads of a block."""

    @property
    def index(self) -> int:
        """Index of the first sample since the start."""

    @property
    def acceleration(self) -> npt.NDArray[Any]:
        """Shape (samples, axes) [m/s^2]."""

    @property
    def shaft_angle(self) -> npt.NDArray[Any] | None:
        """Shape (samples,) [rad]."""


class VehicleDetector:
    """Diagnoses the bearings, wheels and sensors of a vehicle from the blocks of its axle boxes, hop by hop.

    The memory is bounded by one window of every box. The diagnoses do not depend on the length of the blocks, except that `add` returns
    only the last one of blocks that are longer than a hop.

    Examples
    --------
    >>> import dcrb_ros
    >>> from dcrb_ros.vehicle.description import described
    >>> from dcrb_ros.vehicle.file import read_vehicle
    >>> vehicle = read_vehicle("bogie")
    >>> detector = dcrb_ros.VehicleDetector(described(vehicle))
    """

    def __init__(
        self,
        description: VehicleDescription,
        parameters: VehicleDetectorParameters = VEHICLE_DEFAULTS,
        box_parameters: DetectorParameters = DEFAULTS,
    ) -> None:
        """Prepare for the boxes of a ``description``; ``box_parameters`` are those of the fault detector of each box.

        Raises
        ------
        Refusal
            The parameters do not fit each other or the sampling rate.
        """
        self.description, self.parameters = description, parameters
        self._detectors: dict[str, ThermalFaultDetector] = {}
        for box in description.boxes:
            detector = ThermalFaultDetector(Orders.from_dict(box.orders), description.sampling_rate, box_parameters)
            detector.take_bearing(box.bearing)
            detector.sensor_range = box.sensor_range
            self._detectors[box.name] = detector

    def add(self, blocks: Mapping[str, BlockLike]) -> VehicleDiagnosis | None:
        """Take a block of some or all boxes, by name such as ``axle_1/left``; return a diagnosis if they complete a hop of all boxes.

        Raises
        ------
        Refusal
            A box is unknown, or a block has arrays of another shape or type; the detector continues with the next blocks.
        """
        unknown = next((name for name in blocks if name not in self._detectors), None)
        if unknown is not None:
            raise Refusal(f"there is no box '{unknown}'{nearest(unknown, self._detectors)} (known: {', '.join(self._detectors)})")
        latest: dict[str, Diagnosis] = {}
        for name, block in blocks.items():
            diagnosis = self._detectors[name].update(block.index, block.acceleration, block.shaft_angle)
            if diagnosis is not None:
                latest[name] = diagnosis
        if not latest:
            return None
        last = max(latest.values(), key=lambda diagnosis: diagnosis.index)
        statuses = {f"{name}/bearing": Status(d.verdict, d.reason, d.confidence) for name, d in latest.items()}
        return VehicleDiagnosis(last.index, last.time, statuses, {}, latest)

    def take_temperature(self, box: str, time: float, temperature: float, ambient: float) -> None:
        """Take a reading at the outer ring of a box and one of the air at a time [s], both [deg C].

        Raises
        ------
        Refusal
            The box is unknown.
        """
        if box not in self._detectors:
            raise Refusal(f"there is no box '{box}'{nearest(box, self._detectors)} (known: {', '.join(self._detectors)})")
        self._detectors[box].take_temperature(time, temperature, ambient)
