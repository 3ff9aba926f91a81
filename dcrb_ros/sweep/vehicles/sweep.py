"""A sweep over vehicles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dcrb_ros.sweep.design import Point
from dcrb_ros.sweep.sweep_file import Sweep
from dcrb_ros.vehicle.description import Vehicle

VEHICLE = "vehicle"
"""Key of a sweep file with the vehicle on which all runs are based."""
VEHICLE_SEED = "vehicle.seed"
"""Key of the seed from which the bearings, the housings and the noise of a vehicle follow."""
BOX = "box"
"""In the keys of a case, the box in question; as an axis, the boxes among which it is."""


@dataclass(frozen=True)
class VehicleSweep(Sweep):
    """A sweep with the parameters of a vehicle as its base, by dotted keys."""

    source: str
    """Vehicle as named in the file."""
    vehicle: Vehicle
    """The vehicle of the base."""
    kinds: Mapping[str, type]
    """Types of the varied parameters."""
    benches: Mapping[str, Any]
    """Parameters of the benches that are files of the user, by the names of the files."""

    @property
    def count(self) -> int:
        """Number of runs, including duplicates that the plan leaves out [-]."""
        return super().count * len(self.vehicle.boxes)

    @property
    def rate(self) -> int:
        """Sampling rate of the base [Hz]."""
        return self.vehicle.boxes[0].configuration.sensor.sampling_rate

    @property
    def subject(self) -> str:
        """What is simulated, in words."""
        return f"vehicle with {len(self.vehicle.boxes)} axle boxes"

    @property
    def inputs(self) -> dict[str, Any]:
        """All inputs of the plan apart from the base, as written to the description of the data set."""
        return {**super().inputs, VEHICLE: self.source, **({"benches": dict(self.benches)} if self.benches else {})}

    @property
    def varied(self) -> Mapping[str, type]:
        """Varied parameters, each of which has a column of the labels, with their types."""
        return self.kinds


def placed(values: Point) -> Point:
    """Return the values of a case with the key ``box`` replaced by its value."""
    box = values.get(BOX)
    own = {key: value for key, value in values.items() if key != BOX}
    return {f"{box}.{key.removeprefix(f'{BOX}.')}" if key.startswith(f"{BOX}.") else key: value for key, value in own.items()}
