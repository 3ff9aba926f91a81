"""The loop: timing, commands, repeatability."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.events import SpeedCommand


def bench(block_size: int = 1024, **groups: Any) -> Simulation:
    return Simulation(Configuration.model_validate({"publishing": {"block_size": block_size}, **groups}))


def samples(blocks: list[Block]) -> npt.NDArray[np.float32]:
    return np.concatenate([np.column_stack([block.acceleration, block.shaft_angle]) for block in blocks])


def test_blocks_are_contiguous_and_have_the_exact_duration() -> None:
    blocks = list(bench().blocks(0.25))
    assert sum(len(block.acceleration) for block in blocks) == 12800
    ends = [block.index + len(block.acceleration) for block in blocks]
    assert [block.index for block in blocks] == [0, *ends[:-1]]


def test_same_samples_for_any_block_size_and_run() -> None:
    once = samples(list(bench(1024).blocks(0.1)))
    for size in (16, 1000, 1024):
        assert np.array_equal(once, samples(list(bench(size).blocks(0.1))))


def test_the_seed_changes_only_the_noise() -> None:
    one, other = (next(bench(simulation={"seed": seed}).blocks(0.02)) for seed in (1, 2))
    assert not np.array_equal(one.acceleration, other.acceleration)
    assert np.array_equal(one.clean, other.clean)


def test_noise_has_the_configured_density() -> None:
    blocks = list(bench(sensor={"noise_density": 0.01, "adc_bits": 0}).blocks(0.5))
    noise = np.concatenate([block.acceleration - block.clean for block in blocks])
    assert noise.std() == pytest.approx(0.01 * np.sqrt(25600.0), rel=0.02)


def test_range_clips_and_counts() -> None:
    blocks = list(bench(sensor={"range": 100.0}, faults={"outer_1": {"width": 0.002}}).blocks(0.1))
    joined = np.concatenate([block.acceleration for block in blocks])
    assert np.abs(joined).max() <= 100.0
    assert sum(block.clipped for block in blocks) > 0


def test_stamps_of_states_and_truths() -> None:
    blocks = list(bench(1000).blocks(0.5))
    states = [s for block in blocks for s in block.states]
    truths = [t for block in blocks for t in block.truths]
    assert [s.time_ns for s in states] == [10_000_000 * k for k in range(1, 50)]
    assert [t.time_ns for t in truths] == [100_000_000 * k for k in range(5)]
    for block in blocks:
        assert all(block.stamp_ns <= s.time_ns < block.end_ns for s in block.states)


def test_shaft_angle_follows_the_speed() -> None:
    angle = np.unwrap(np.concatenate([block.shaft_angle for block in bench().blocks(0.2)]).astype(float))
    assert angle == pytest.approx(125.664 * np.arange(len(angle)) / 51200, abs=2e-5)


def test_speed_command_follows_its_ramp() -> None:
    simulation = bench(512, operating={"speed_ramp": 100.0})
    blocks = [next(simulation.blocks(0.01))]
    simulation.command_speed(130.0)
    blocks += list(simulation.blocks(0.3))
    noted = [t for block in blocks for t in block.truths if isinstance(t.event, SpeedCommand)]
    assert len(noted) == 1
    assert blocks[0].end_ns <= noted[0].time_ns <= blocks[0].end_ns + 1_000_000
    assert noted[0].speed == pytest.approx(125.664)
    after = [t for block in blocks for t in block.truths if t.time_ns > noted[0].time_ns + 60_000_000]
    assert after[0].speed == pytest.approx(130.0)
    assert after[0].frequencies["BPFO"] == pytest.approx(6.7234 * 130.0 / (2.0 * np.pi), rel=1e-4)


def test_a_load_command_reaches_the_ring() -> None:
    simulation = bench(operating={"load_ramp": 1e6})
    simulation.command_load(0.0, -60e3)
    states = [s for block in simulation.blocks(0.3) for s in block.states]
    assert np.mean([s.inner_ring_force[1] for s in states[-10:]]) == pytest.approx(60e3 + 71.8, rel=0.01)


@given(st.sampled_from([float("nan"), float("inf"), -float("inf"), 1e4, -2000.0, 1e300]))
def test_commands_out_of_range_are_refused(value: float) -> None:
    simulation = SHARED
    with pytest.raises(Refusal, match=r"command/speed = .* rad/s is refused: .* -1000 \.\. 1000 rad/s"):
        simulation.command_speed(value)
    with pytest.raises(Refusal, match=r"command/load force\.y"):
        simulation.command_load(0.0, value * 1e5)


SHARED = bench()


def test_a_load_too_large_for_the_bearing_is_refused() -> None:
    with pytest.raises(Refusal, match=r"command/load: operating.load = 5e\+06 N .* presses the rings .* at most about .* N"):
        SHARED.command_load(0.0, -5e6)


def test_a_model_outside_its_domain_fails_with_the_reason() -> None:
    simulation = bench()
    simulation._payload = simulation._payload._replace(housing_stiffness=1e3)  # a configuration with it is refused
    with pytest.raises(ModelFailure, match=r"outer ring is .* m off its seat"):
        list(simulation.blocks(0.1))


@pytest.mark.parametrize("rate", [12800, 25600, 102400])
def test_the_spectrum_does_not_depend_on_the_sampling_rate(rate: int) -> None:
    step = 1.0 / max(102400, 2 * rate)
    groups = {"simulation": {"step": step}, "cage": {"joint": "revolute"}}
    one, other = (bench(sensor={"sampling_rate": r, "preset": "ideal"}, **groups) for r in (rate, 51200 if rate < 51200 else 25600))
    found, known = (samples(list(simulation.blocks(0.08)))[:, :2] for simulation in (one, other))
    assert len(found) == round(0.08 * rate)
    spectrum, expected = (np.fft.rfft(s, axis=0)[:300] / len(s) for s in (found, known))  # to 3.7 kHz, in the passband of both
    assert np.abs(spectrum - expected).max() < 2e-3 * np.abs(expected).max()
