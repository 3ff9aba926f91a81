"""Heat across the axle: sun on a side, conduction between the boxes, brakes, air, and the same samples for a single bearing."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.bearing.axle_heat import Surroundings, box_temperatures
from dcrb_ros.bearing.heat_network import Vector, surface_exchange
from dcrb_ros.bearing.quasi_steady import QuasiSteady
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.vehicle.file import read_vehicle, vehicle_of
from dcrb_ros.vehicle.heat import VehicleHeat, air_share
from dcrb_ros.vehicle.simulation import VehicleSimulation

SMOOTH = {"track.spectrum": "none", "track.roughness": -40.0}
NETWORK = {f"axle_{axle}.{side}.thermal.law": "network" for axle in (1, 2) for side in ("left", "right")}


def bench(kmh: float, sun: float) -> Configuration:
    return load_configuration("healthy", {"thermal.law": "network", "thermal.sun": sun, "operating.speed": kmh / 3.6 / 0.46})


def settled(*boxes: Configuration) -> list[Vector]:
    """Return the temperatures of the boxes of an axle after six hours of steady running, with the axle between them."""
    steady = [QuasiSteady(box) for box in boxes]
    running = [each.running() for each in steady]
    temperatures = [each.steady(at) for each, at in zip(steady, running, strict=True)]
    for _ in range(360):
        felt = [box_temperatures(each.network, now) for each, now in zip(steady, temperatures, strict=True)]
        for k, each in enumerate(steady):
            surroundings = Surroundings(felt[1 - k] if len(boxes) == 2 else None)
            rows = each.network.heat(each.power(running[k], temperatures[k]), boxes[k].thermal.sun)
            heat = surroundings.heated(each.network, rows, temperatures[k])
            temperatures[k] = each.network.after(temperatures[k], each.conductances(running[k]), heat, boxes[k].thermal.ambient, 60.0)
    return temperatures


@pytest.mark.parametrize(("kmh", "surface", "rise"), [(0.0, 18.5, None), (72.0, 5.0, 3.2), (216.0, 2.5, 1.7)])
def test_the_sun_warms_its_side_alone(kmh: float, surface: float, rise: float | None) -> None:
    thermal = bench(kmh or 5.0, 0.0).thermal
    # The surface of the box alone would lose 100 W at 18.5 K at rest, 5.0 K at 72 km/h and 2.5 K at 216 km/h.
    exchange = thermal.box_area * surface_exchange(thermal.exposure * kmh / 3.6, thermal.box_size)
    assert 100.0 / exchange == pytest.approx(surface, abs=0.3)
    if rise is None:
        return
    # Bearing and axle take a quarter of it, and warmer oil makes less heat.
    shaded, lit = settled(bench(kmh, 0.0), bench(kmh, 0.0)), settled(bench(kmh, 100.0), bench(kmh, 0.0))
    assert lit[0][-1] - shaded[0][-1] == pytest.approx(rise, abs=0.1)
    assert 0.0 < lit[1][-1] - shaded[1][-1] < 0.2


def test_what_one_journal_gains_across_the_axle_the_other_loses() -> None:
    steady = QuasiSteady(bench(72.0, 0.0))
    network = steady.network
    hot, cold = [80.0 + node for node in range(network.box + 1)], [30.0 + node for node in range(network.box + 1)]
    nothing = [0.0] * (network.box + 1)
    gained = Surroundings(box_temperatures(network, hot)).heated(network, nothing, cold)
    lost = Surroundings(box_temperatures(network, cold)).heated(network, nothing, hot)
    assert sum(gained) == pytest.approx(0.5 * 50.0, rel=1e-12)  # 0.5 W/K
    assert sum(gained) == pytest.approx(-sum(lost), rel=1e-12)


def test_brakes_heat_the_journals_with_two_per_cent_of_their_power() -> None:
    vehicle = read_vehicle("healthy_bogie")
    # Both journals of both wheelsets of both bogies at 1 m/s^2 and 20 m/s, of the whole vehicle.
    whole = vehicle.body.mass + 2.0 * vehicle.frame.mass + 4.0 * 1813.0
    assert 8.0 * VehicleHeat(vehicle).brakes(20.0, 1.0) == pytest.approx(0.02 * whole * 20.0)


def test_trailing_and_lee_boxes_have_less_air() -> None:
    assert air_share(1, 0.0, trailing=False) == 1.0
    assert air_share(1, 0.0, trailing=True) == 0.8
    # A force to the left comes from a wind from the right: the left side is the lee.
    assert air_share(1, 1e4, trailing=False) == air_share(-1, -1e4, trailing=False) == 0.85
    assert air_share(-1, 1e4, trailing=True) == 0.8


def test_the_air_at_a_box_has_the_speed_of_the_vehicle() -> None:
    vehicle = read_vehicle("healthy_bogie", {"axle_1.radius": 0.35, "vehicle.speed_kmh": 72.0})
    operating = [box.configuration.operating for box in vehicle.boxes]
    assert [each.speed * 0.5 * each.wheel_diameter for each in operating] == pytest.approx([20.0] * 4, rel=1e-12)


@pytest.mark.slow
def test_a_vehicle_of_one_box_with_a_network_is_the_bench() -> None:
    vehicle = vehicle_of({**SMOOTH, "axle_1.left.thermal.law": "network", "vehicle.speed_kmh": 100.0}, "one box")
    (box,) = vehicle.boxes
    blocks = list(VehicleSimulation(vehicle).blocks(0.22))
    alone = list(Simulation(box.configuration).blocks(0.22))
    for block, other in zip(blocks, alone, strict=True):
        assert np.array_equal(block.boxes[box.name].acceleration, other.acceleration)
        assert [truth.thermal for truth in block.boxes[box.name].truths] == [truth.thermal for truth in other.truths]


@pytest.mark.slow
def test_boxes_of_a_wheelset_are_each_other_s_neighbour() -> None:
    changes = {"axle_1.left.thermal.sun": 1000.0, "vehicle.wind": 2e4, "vehicle.brake": 0.5, "vehicle.speed_kmh": 72.0}
    runs = []
    for threads, size in ((1, 1024), (2, 256)):
        blocks = {f"axle_{axle}.{side}.publishing.block_size": size for axle in (1, 2) for side in ("left", "right")}
        vehicle = read_vehicle("healthy_bogie", {**SMOOTH, **NETWORK, **changes, **blocks})
        runs.append(list(VehicleSimulation(vehicle, threads=threads).blocks(0.22)))
    last = {name: [truth.thermal for block in runs[0] for truth in block.boxes[name].truths][-1] for name in runs[0][-1].boxes}
    for name in last:
        assert last[name] == [truth.thermal for block in runs[1] for truth in block.boxes[name].truths][-1]
        assert last[name]["brakes [W]"] == pytest.approx(VehicleHeat(read_vehicle("healthy_bogie")).brakes(20.0, 0.5), rel=1e-6)
    for name, other in (("axle_1.left", "axle_1.right"), ("axle_2.right", "axle_2.left")):
        assert last[name]["opposite_box [deg C]"] == pytest.approx(last[other]["box [deg C]"], abs=0.01)
    # Sun, then the trailing wheelset and the lee on the left.
    box = {name: thermal["box [deg C]"] for name, thermal in last.items()}
    assert box["axle_1.left"] > box["axle_2.left"] > box["axle_2.right"] > box["axle_1.right"]


@pytest.mark.slow
def test_a_box_that_failed_heats_its_neighbour_no_longer() -> None:
    simulation = VehicleSimulation(read_vehicle("healthy_bogie", {**SMOOTH, **NETWORK, "vehicle.on_failure": "continue"}))
    next(simulation.blocks(0.02))
    simulation._failed["axle_1.left"] = "axle_1.left: the model failed on purpose"
    next(simulation.blocks(0.02))
    opposite = {name: box._heating.surroundings.opposite for name, box in simulation.simulations.items() if name != "axle_1.left"}
    assert [name for name, temperatures in opposite.items() if temperatures is None] == ["axle_1.right"]


@pytest.mark.slow
def test_beside_a_box_that_failed_the_healthy_bearing_has_the_time_that_has_passed() -> None:
    changes = {f"{box.rpartition('.')[0]}.{key}": value for box in NETWORK for key, value in (("start", "cold"), ("acceleration", 3000.0))}
    simulation = VehicleSimulation(read_vehicle("healthy_bogie", {**SMOOTH, **NETWORK, **changes}))
    list(simulation.blocks(1.1))
    right = simulation.simulations["axle_1.right"]._heating
    assert right._opposite is not None
    assert right._opposite.box > 25.0  # it began at 20 deg C
