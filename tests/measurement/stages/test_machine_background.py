"""Background of the machine: level, lines, speed, the floor under a defect, bits and refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from chain import SPEED, chain
from hypothesis import given, settings
from hypothesis import strategies as st

from dcrb_ros import Refusal, Simulation, load_configuration
from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.measurement.stage import Span
from dcrb_ros.measurement.stages.machine_background import MachineBackground, MachineBackgroundParameters
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.simulation.scenario import starting_configuration

RATE = 102400.0
LEVEL = 2.0


def stage(seed: int = 1, simulation_seed: int = 1, **structure: Any) -> MachineBackground:
    """Return the stage of a laboratory rig with a healthy level of 2 m/s^2."""
    given = {"housing": "laboratory", "healthy_level": LEVEL, "seed": seed, **structure}
    return MachineBackground(chain(structure=given, simulation={"seed": simulation_seed}).measurement, RATE)


def after(background: MachineBackground, acceleration: Floats, speed: float = SPEED) -> Floats:
    """Return acceleration with the background at a speed [rad/s]."""
    return background.process(acceleration, Span(0, speed * np.arange(len(acceleration) + 1) / RATE))


def still(seconds: float) -> Floats:
    """Return an acceleration of zero."""
    return np.zeros((round(seconds * RATE), 2))


def rms(samples: Floats) -> float:
    """Return the root of the mean power of both axes up to 20 kHz, after 0.1 s."""
    settled = samples[round(0.1 * RATE) :]
    power = np.abs(np.fft.rfft(settled, axis=0)) ** 2 * 2.0 / len(settled) ** 2
    return float(np.sqrt(power[np.fft.rfftfreq(len(settled), 1.0 / RATE) <= 20000.0].sum(axis=0).mean()))


def test_it_is_off_without_a_level() -> None:
    assert not MachineBackground(chain(structure={"housing": "laboratory"}).measurement, RATE).active
    assert stage().active


def test_its_noise_passes_the_mounted_housing() -> None:
    assert not np.array_equal(after(stage(), still(0.2)), after(stage(mounting=1), still(0.2)))


@pytest.mark.parametrize("housing", ["laboratory", "axle_box"])
@pytest.mark.parametrize("lines", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("decibels", [0.0, 6.0, -20.0])
def test_it_has_its_level_over_the_healthy_bearing(housing: str, lines: float, decibels: float) -> None:
    found = rms(after(stage(3, housing=housing, background=decibels, background_lines=lines), still(2.1)))
    assert found == pytest.approx(LEVEL * 10.0 ** (decibels / 20.0), rel=0.05)


def test_lines_have_their_share_of_the_power() -> None:
    noise, both = after(stage(), still(1.1)), after(stage(background_lines=0.3), still(1.1))
    lines = both - np.sqrt(0.7) * noise
    # The fifth multiple of the shaft falls on twice the mains frequency.
    assert rms(lines) ** 2 == pytest.approx(0.3 * LEVEL**2, rel=0.15)
    power = np.sort(np.abs(np.fft.rfft(lines[:, 1] * np.hanning(len(lines)))) ** 2)[::-1]
    assert power[: 16 * 4].sum() / power.sum() > 0.999


def test_broadband_noise_is_gaussian_and_differs_between_axes_and_runs() -> None:
    found, other = after(stage(), still(2.0)), after(stage(simulation_seed=2), still(2.0))
    normal = (found / found.std(axis=0)) ** 4
    assert normal.mean(axis=0) == pytest.approx([3.0, 3.0], abs=0.15)
    assert abs(np.corrcoef(found.T)[0, 1]) < 0.05
    assert abs(np.corrcoef(found[:, 0], other[:, 0])[0, 1]) < 0.05


def test_the_level_is_proportional_to_the_speed() -> None:
    half, whole = (rms(after(stage(), still(1.0), speed)) for speed in (0.5 * SPEED, SPEED))
    assert half == pytest.approx(0.5 * whole, rel=1e-9)
    assert not after(stage(), still(0.1), 0.0).any()


def test_axle_boxes_have_lines_of_the_shaft_only() -> None:
    found = after(stage(housing="axle_box", background_lines=1.0), still(1.0))
    orders = 2.0 * np.pi * np.fft.rfftfreq(len(found), 1.0 / RATE) / SPEED
    power = np.abs(np.fft.rfft(found[:, 1] * np.hanning(len(found)))) ** 2
    assert power[orders < 6.3].sum() / power.sum() > 0.999


@pytest.mark.parametrize(("floor", "added"), [(0.0, 3.0), (0.18, 3.0), (0.7, 3.0), (0.7, 0.0)])
def test_the_floor_rises_with_the_added_power(floor: float, added: float) -> None:
    """Acceleration of a power of (1 + added) times the healthy one adds floor times the added power."""
    ring = np.random.default_rng(5).normal(0.0, LEVEL * np.sqrt(1.0 + added), (round(4.0 * RATE), 2))
    extra = (after(stage(background=-60.0, floor=floor), ring) - ring)[round(3.0 * RATE) :]
    expected = LEVEL**2 * (1e-6 + floor * added)
    # The smoothed power of random acceleration deviates by 0.4 %.
    assert np.mean(extra**2) == pytest.approx(expected, rel=0.1, abs=0.005 * max(floor, 0.001) * LEVEL**2)


@pytest.mark.parametrize("added", [0.0, 3.0])
def test_the_floor_is_that_of_both_axes_together_from_the_first_second_on(added: float) -> None:
    """Axes of a healthy bearing with 1.6 and 0.4 times its power have no floor, and no axis of a damaged one waits for it."""
    shares = np.array([1.6, 0.4])
    ring = np.random.default_rng(5).normal(0.0, LEVEL * np.sqrt(1.0 + added), (round(0.5 * RATE), 2)) * np.sqrt(shares)
    extra = after(stage(background=-60.0, floor=0.7), ring) - ring
    floor = (extra[round(0.1 * RATE) :] ** 2).mean(axis=0) / (0.7 * LEVEL**2)
    assert floor == pytest.approx(added * shares, rel=0.15, abs=0.03)


def test_the_level_holds_at_its_own_speed() -> None:
    half = rms(after(stage(healthy_speed=0.5 * SPEED), still(1.0)))
    assert half == pytest.approx(2.0 * rms(after(stage(), still(1.0))), rel=1e-9)


def test_a_scenario_that_starts_slowly_keeps_the_speed_of_the_level() -> None:
    bench = load_configuration("healthy", {"structure.healthy_level": LEVEL, "structure.housing": "axle_box"})
    slow = starting_configuration({"start": {"operating": {"speed": -31.0}}}, bench, "run-up")
    level = slow.measurement.parameters[MachineBackgroundParameters]
    assert (level.healthy_speed, slow.operating.speed) == (bench.operating.speed, -31.0)
    given = {"start": {"operating": {"speed": 31.0}, "structure": {"healthy_speed": 60.0}}}
    assert starting_configuration(given, bench, "own").model_dump()["structure"]["healthy_speed"] == 60.0
    off = starting_configuration({"start": {"operating": {"speed": 31.0}}}, load_configuration("healthy"), "off")
    assert off.model_dump()["structure"]["healthy_speed"] == 0.0
    resting = load_configuration("healthy", {"structure.healthy_level": 1.0, "structure.housing": "axle_box", "operating.speed": 0.0})
    with pytest.raises(Refusal, match=r"a level at operating\.speed, which is 0"):
        starting_configuration({"start": {"operating": {"speed": 31.0}}}, resting, "run-up")


@settings(deadline=None, max_examples=15)
@given(st.lists(st.integers(1, 6000), min_size=1, max_size=6))
def test_no_split_changes_a_bit(cuts: list[int]) -> None:
    options = {"background_lines": 0.4, "floor": 0.5}
    ring, angle = np.random.default_rng(6).normal(0.0, 5.0, (sum(cuts), 2)), 1e-3 * np.arange(sum(cuts) + 1)
    whole, split, parts, start = stage(**options).process(ring, Span(0, angle)), stage(**options), [], 0
    for count in cuts:
        parts.append(split.process(ring[start : start + count], Span(start, angle[start : start + count + 1])))
        start += count
    assert np.array_equal(np.concatenate(parts), whole)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"structure.background": 3.0}, "structure.background = 3 needs structure.healthy_level"),
        ({"structure.floor": 0.2}, "structure.floor = 0.2 needs structure.healthy_level"),
        ({"structure.healthy_speed": 60.0}, "structure.healthy_speed = 60 needs structure.healthy_level"),
        ({"structure.healthy_level": 1.0, "structure.housing": "none"}, "needs a housing of the background"),
        (
            {"structure.healthy_level": 1.0, "structure.housing": "axle_box", "structure.bearing_share": 0.5, "structure.noise_x": 1.0},
            "both add noise of the machine: give a level of 0 or a share of 1",
        ),
    ],
)
def test_what_a_background_cannot_work_with_is_refused(changes: dict[str, Any], reason: str) -> None:
    with pytest.raises(Refusal, match=reason):
        load_configuration("healthy", changes)


def test_a_level_needs_a_speed_at_the_start_and_the_shaft_may_stop_later() -> None:
    level = {"structure.healthy_level": 1.0, "structure.housing": "axle_box"}
    with pytest.raises(Refusal, match=r"a level at operating\.speed, which is 0: give the speed at which it was measured"):
        Simulation(load_configuration("healthy", {**level, "operating.speed": 0.0}))
    Simulation(load_configuration("healthy", {**level, "operating.speed": 0.0, "structure.healthy_speed": 60.0}))
    assert altered(load_configuration("healthy", level), {"operating.speed": 0.0}).operating.speed == 0.0
