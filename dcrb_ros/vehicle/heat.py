"""What a vehicle does to the heat of its boxes: the bearing at the other end of the axle, the brakes, the train ahead and wind."""

from __future__ import annotations

from collections.abc import Mapping

from dcrb_ros.bearing.axle_heat import ALONE, Surroundings
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.vehicle.description import Box, Vehicle
from dcrb_ros.vehicle.traction import WHEELSET_MASS

BRAKE_SHARE = 0.02
"""Share of the power of a wheelset's brakes that reaches its journals [-] (an assumption)."""
TRAILING_AIR, LEE_AIR = 0.8, 0.85
"""Share of the air that reaches boxes behind the leading wheelset, and boxes on the lee side of a wind [-] (an assumption)."""


class VehicleHeat:
    """Gives each box its surroundings, from the temperatures at the end of the frame before."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._boxes = vehicle.boxes
        foremost = max(axle.x for axle in vehicle.axles)
        self._trailing = {box.name: vehicle.axles[box.axle].x < foremost for box in vehicle.boxes}
        self._opposite = {
            box.name: other.name for box in vehicle.boxes for other in vehicle.boxes if box.axle == other.axle and box is not other
        }
        # A bogie carries half of the body on two wheelsets.
        self._braked = 0.25 * vehicle.body.mass + 0.5 * vehicle.frame.mass + WHEELSET_MASS

    def at_start(self, box: Box, wind: float) -> Surroundings:
        """Return the surroundings of a box before anything is known of the others."""
        air = air_share(box.side, wind, trailing=self._trailing[box.name])
        return ALONE if air == 1.0 else Surroundings(air=air)

    def brakes(self, speed: float, brake: float) -> float:
        """Return the heat of the brakes in a journal [W]: half the share of m a v, with the mass m that a wheelset brakes."""
        return 0.5 * BRAKE_SHARE * self._braked * brake * speed

    def surroundings(self, speed: float, wind: float, brake: float, boxes: Mapping[str, Simulation]) -> dict[str, Surroundings]:
        """Return the surroundings of those of ``boxes`` with a thermal network at a speed [m/s], wind [N] and brake [m/s^2]."""
        temperatures = {name: box.temperatures for name, box in boxes.items()}
        heat, given = self.brakes(speed, brake), {}
        for box in self._boxes:
            if temperatures.get(box.name) is not None:
                opposite = temperatures.get(self._opposite.get(box.name, ""))
                surroundings = Surroundings(opposite, heat, air_share(box.side, wind, trailing=self._trailing[box.name]))
                given[box.name] = ALONE if surroundings == ALONE else surroundings
        return given


def air_share(side: int, wind: float, *, trailing: bool) -> float:
    """Return the share of the air at a box on the left (1) or right (-1) side; the force of the wind is positive to the left [N]."""
    return (TRAILING_AIR if trailing else 1.0) * (LEE_AIR if side * wind > 0.0 else 1.0)
