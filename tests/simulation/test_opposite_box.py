"""The healthy bearing across the axle: it has the weather, the speed and the load of the simulated one."""

from __future__ import annotations

import pytest

from dcrb_ros.bearing.axle_heat import Surroundings
from dcrb_ros.bearing.quasi_steady import QuasiSteady
from dcrb_ros.settings.files import changed, load_configuration
from dcrb_ros.settings.loaded_contacts import load_and_weight
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.opposite_box import OppositeBox

WARM = {"thermal.law": "network", "operating.speed": 125.5}


@pytest.mark.parametrize(
    "change",
    [
        {"thermal.exposure": 0.0},
        {"thermal.air_speed": 5.0},
        {"thermal.sun": 500.0},
        {"thermal.ambient": 0.0},
        {"operating.load": 50e3},
        {"operating.speed": 60.0},
    ],
    ids=str,
)
def test_after_a_change_at_run_time_it_settles_as_if_configured_so(change: dict[str, float]) -> None:
    before = load_configuration("healthy", WARM | {"faults.lubrication.loss": 0.5})
    after = changed(before, change, "a change")
    opposite = OppositeBox(before)
    for _ in range(50):
        opposite.follow(after, after.operating.speed, after.operating.load, 600.0)
    steady = QuasiSteady(load_configuration("healthy", WARM | change))
    assert opposite.box == pytest.approx(steady.steady(steady.running())[steady.network.box], abs=0.01)


@pytest.mark.slow
def test_it_has_the_air_of_the_vehicle_and_the_load_that_is_commanded() -> None:
    run = Simulation(load_configuration("healthy", WARM), surroundings=Surroundings(air=0.8))
    c = run.configuration
    run.command_load(0.0, -50e3)
    run.surround(Surroundings(air=0.85))
    for _ in run.blocks(1.15):
        pass
    assert run._heating._opposite is not None
    (inside, _, load) = run._heating._opposite._operation
    assert inside.thermal.exposure == pytest.approx(0.85 * c.thermal.exposure)
    assert load == pytest.approx(load_and_weight(changed(c, {"operating.load": 50e3}, "a load")))
