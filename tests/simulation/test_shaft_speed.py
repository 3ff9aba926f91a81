"""The fluctuation of the shaft's speed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.shaft_speed import FADE, HIGHEST, ShaftSpeed

SPEED = 125.664


def configured(**operating: Any) -> Configuration:
    return Configuration.model_validate({"operating": {"speed": SPEED, **operating}, "bearing": {"rows": 1}})


def fluctuation(duration: float, seed: int = 1, **operating: Any) -> np.ndarray:
    """Return the relative fluctuation at every millisecond after it began, of a shaft that turns evenly."""
    made = configured(**operating).model_copy(update={"simulation": Configuration().simulation.model_copy(update={"seed": seed})})
    shaft = ShaftSpeed(made)
    return np.array([shaft.relative(float(t), SPEED * float(t)) for t in np.arange(FADE, duration, 1e-3)])


def angles(simulation: Simulation, duration: float) -> np.ndarray:
    return np.unwrap(np.concatenate([block.shaft_angle for block in simulation.blocks(duration)]).astype(np.float64))


def test_its_root_mean_square_is_as_configured_and_it_is_bounded() -> None:
    slow, ripple = fluctuation(200.0, speed_fluctuation=0.003), fluctuation(20.0, speed_ripple=0.002)
    assert slow.std() == pytest.approx(0.003, rel=0.05)
    assert ripple.std() == pytest.approx(0.002, rel=0.01)
    assert np.abs(slow).max() <= 5.7 * 0.003
    assert np.abs(ripple).max() <= 1.9 * 0.002


def test_the_ripple_has_orders_of_the_shaft_and_the_rest_is_slow() -> None:
    both = fluctuation(20.1, speed_fluctuation=0.001, speed_ripple=0.001)
    power = np.abs(np.fft.rfft((both - both.mean()) * np.hanning(len(both)))) ** 2
    frequency = np.fft.rfftfreq(len(both), 1e-3)
    ours = frequency < HIGHEST + 0.5
    for order in (1, 2):
        ours |= np.abs(frequency - order * SPEED / (2.0 * np.pi)) < 0.5
    assert power[~ours].sum() < 1e-5 * power.sum()


def test_other_seeds_fluctuate_otherwise() -> None:
    one, other = (fluctuation(50.0, seed, speed_fluctuation=0.002) for seed in (1, 2))
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.5


def test_the_shaft_of_a_bench_turns_as_prescribed() -> None:
    simulation = Simulation(configured(speed_ripple=0.005))
    turned = angles(simulation, 1.0)[round(0.2 * 51200) :]
    time = np.arange(len(turned)) / 51200
    departure = turned - np.polyval(np.polyfit(time, turned, 1), time)
    # A ripple of 0.5 % has the amplitude 0.0063 at order 1, and its integral an angle of as much.
    assert departure.std() == pytest.approx(0.0063 / np.sqrt(2.0), rel=0.05)


def test_the_samples_do_not_depend_on_the_blocks() -> None:
    def samples(size: int) -> np.ndarray:
        made = configured(speed_fluctuation=0.002, speed_ripple=0.002)
        made = made.model_copy(update={"publishing": made.publishing.model_copy(update={"block_size": size})})
        return np.concatenate([np.column_stack([block.acceleration, block.shaft_angle]) for block in Simulation(made).blocks(0.06)])

    assert np.array_equal(samples(1024), samples(100))


def test_without_fluctuation_the_speed_is_the_commanded_one() -> None:
    assert not ShaftSpeed(configured()).fluctuates
    simulation = Simulation(configured())
    list(simulation.blocks(0.02))
    assert float(simulation._state.shaft[1]) == SPEED


def test_a_fluctuating_shaft_follows_its_ramp_and_takes_faults_on_the_way() -> None:
    simulation = Simulation(configured(speed_ripple=0.002, speed_ramp=100.0))
    simulation.command_speed(SPEED + 20.0)
    list(simulation.blocks(0.1))
    assert float(simulation._state.shaft[1]) == pytest.approx(SPEED + 10.0, rel=0.01)
    simulation.change({"faults.outer_1.width": 0.001, "operating.speed_ramp": 50.0})
    list(simulation.blocks(0.1))
    assert float(simulation._state.shaft[1]) == pytest.approx(SPEED + 15.0, rel=0.01)
    list(simulation.blocks(0.3))
    truth = [truth.speed for block in simulation.blocks(0.3) for truth in block.truths]
    assert np.mean(truth) == pytest.approx(SPEED + 20.0, rel=0.003)
    assert np.std(truth) > 0.0
