"""The tacho of a running bench: the angle from its pulses, the same pulses for any block size, no effect on samples, and its limit."""

from __future__ import annotations

import math

import numpy as np
import pytest

import dcrb_ros
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

UNEVEN = {"operating.speed_fluctuation": 0.01, "operating.speed_ripple": 0.01}


def pulses(duration: float, **settings: object) -> tuple[list[int], list[int], bytes]:
    """Return times [ns] and numbers of the pulses of a dry bench, and its samples."""
    simulation = Simulation(load_configuration("dry", {key.replace("__", "."): value for key, value in settings.items()}))
    blocks = list(simulation.blocks(duration))
    for block in blocks:
        assert all(block.stamp_ns <= time < block.end_ns for time in block.pulse_ns.tolist())
    times, numbers = (np.concatenate([getattr(block, name) for block in blocks]).tolist() for name in ("pulse_ns", "pulse_number"))
    return times, numbers, b"".join(getattr(block, name).tobytes() for name in ("acceleration", "shaft_angle") for block in blocks)


@pytest.fixture(scope="module")
def uneven() -> dcrb_ros.SimulationResult:
    return dcrb_ros.simulate("dry", 0.5, settings=UNEVEN | {"tacho.pulses_per_turn": 100})


def angle_error(run: dcrb_ros.SimulationResult, every: int) -> float:
    """Return the largest difference of the angle from each ``every``-th pulse to that of the shaft [degrees]."""
    tacho = run.tacho
    found = np.interp(run.time, tacho.time[::every], tacho.number[::every] / tacho.pulses_per_turn, left=math.nan, right=math.nan)
    # The run begins at the angle 0, and the first pulse is that of the second tooth: a wheel begins at a tooth that it has not passed.
    true = run.turns + run.shaft_angle[0] / (2.0 * math.pi) - 1.0 / tacho.pulses_per_turn
    return 360.0 * float(np.nanmax(np.abs(found - true)))


def test_the_angle_from_pulses_is_that_of_a_fluctuating_shaft(uneven: dcrb_ros.SimulationResult) -> None:
    speed = uneven.truth.speed
    assert np.ptp(speed) > 0.005 * speed[0]
    # The angle of a sample is a single float of a turn: 2 pi / 2^24 rounds to 4e-5 degrees at the most, seen with some margin.
    fine, coarse, once = (angle_error(uneven, every) for every in (1, 10, 100))
    assert fine < 0.002  # measured: 0.0007, with every tenth pulse 0.07, with one per turn 1.9
    # The error of linear interpolation, a T^2 / 8, is quadratic in the time T between pulses as long as they follow the ripple.
    assert 30.0 < coarse / fine < 130.0
    assert once > 0.2  # one pulse per turn does not see a ripple of one and two periods per turn
    assert uneven.tacho.turns(uneven.time[-1] + 1.0) == pytest.approx(math.nan, nan_ok=True)


def test_the_speed_from_pulses_is_that_of_the_truth(uneven: dcrb_ros.SimulationResult) -> None:
    middle = 0.5 * (uneven.tacho.time[1:] + uneven.tacho.time[:-1])
    found = np.interp(uneven.truth.time[1:-1], middle, uneven.tacho.speed)
    assert np.allclose(found, uneven.truth.speed[1:-1], rtol=3e-4)


def test_pulses_are_the_same_for_any_block_size_and_in_a_fork() -> None:
    settings = {f"operating__{key}": 0.01 for key in ("speed_fluctuation", "speed_ripple")}
    found = [pulses(0.12, publishing__block_size=size, tacho__pulses_per_turn=90, **settings) for size in (256, 1000, 4096)]
    assert found[0] == found[1] == found[2]
    assert found[0][1] == list(range(len(found[0][0])))
    simulation = Simulation(load_configuration("dry", {"tacho.pulses_per_turn": 90}))
    next(simulation.blocks())
    other = simulation.fork()
    assert next(simulation.blocks()).pulse_ns.tolist() == next(other.blocks()).pulse_ns.tolist() != []


def test_a_tacho_changes_no_sample() -> None:
    without, beside = pulses(0.06), pulses(0.06, tacho__pulses_per_turn=100)
    assert without[0] == []
    assert beside[0] != []
    assert without[2] == beside[2]


def test_pulses_keep_the_clock_of_the_samples() -> None:
    run = dcrb_ros.simulate("dry", 0.2, settings={"tacho.pulses_per_turn": 100, "sensor.clock_offset_ppm": 900.0})
    true = dcrb_ros.simulate("dry", 0.2, settings={"tacho.pulses_per_turn": 100})
    assert angle_error(run, 1) < 1e-3 < 1e2 * 0.2 * 900e-6  # without the offset the error would be 0.13 degrees at the end
    assert run.tacho.time[300] == pytest.approx(true.tacho.time[300] / (1.0 + 900e-6), abs=2e-9)


def test_lost_blocks_lose_their_pulses_and_the_numbers_tell() -> None:
    run = dcrb_ros.simulate("dry", 0.3, settings={"tacho.pulses_per_turn": 60, "publishing.loss_probability": 0.4})
    lost = int(run.index[-1]) + 1 - len(run)
    assert lost > 0
    assert 0 < run.tacho.number[-1] + 1 - len(run.tacho) == pytest.approx(lost / 51200 * 1200, abs=12)
    assert run.tacho.turns(0.2) == pytest.approx(20.0 * (0.2 - run.tacho.time[0]), abs=2e-3)


def test_too_many_pulses_are_refused_also_at_run_time() -> None:
    with pytest.raises(Refusal, match=r"tacho.pulses_per_turn = 400 makes 8000 pulses .* above 6400, .*: give at most 319"):
        load_configuration("dry", {"tacho.pulses_per_turn": 400})
    simulation = Simulation(load_configuration("dry", {"tacho.pulses_per_turn": 300}))
    with pytest.raises(Refusal, match=r"tacho.pulses_per_turn = 300 makes"):
        simulation.command_speed(200.0)
    with pytest.raises(Refusal, match="fixed while the bench runs"):
        simulation.change({"tacho.pulses_per_turn": 30})
