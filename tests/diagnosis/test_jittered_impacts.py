"""The detector on signals that the simulation did not make: no false alarms, and impacts are named."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import pytest
from jittered_impacts import Machine

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.measured import diagnose_as_a_whole

pytestmark = pytest.mark.slow


def machine(seed: int, **more: Any) -> Machine:
    """Return one of many machines: 7 to 14 balls, contact ratios of 0.15 to 0.27, 12 or 25.6 kHz, 15 to 44 Hz."""
    return Machine(
        seed, balls=7 + seed % 8, ratio=0.15 + 0.02 * (seed % 7), rate=(12000, 25600)[seed % 2], speed=15.0 + seed * 7 % 30, **more
    )


def verdict(one: Machine, signal: Any) -> str:
    return diagnose_as_a_whole(signal, one.rate, one.speed, one.orders, DetectorParameters()).verdict


@pytest.mark.parametrize(
    "parts",
    [{}, {"shaft": 0.4}, {"gear": 0.7, "shaft": 0.2}, {"compliance": 0.05}],
    ids=["coloured noise", "shaft", "gear", "compliance"],
)
@pytest.mark.parametrize("seconds", [1.0, 3.0])
def test_healthy_machines_raise_no_alarm(parts: dict[str, float], seconds: float) -> None:
    """Each of 25 machines may raise one with a probability of 4e-4, one for each of four faults: together 1 %."""
    verdicts = []
    for seed in range(25):
        one = machine(seed)
        verdicts.append(verdict(one, one.healthy(seconds, **parts)))
    assert set(verdicts) == {"healthy"}


@pytest.mark.parametrize("seconds", [1.0, 4.0])
def test_no_rule_finds_significant_lines_in_noise_more_often_than_stated(seconds: float) -> None:
    """With thresholds of depth that any line reaches, only significance is left: one in a hundred windows per fault."""
    depths = {"outer_depth": 1e-6, "inner_depth": 1e-6, "roller_depth": 1e-6, "cage_depth": 1e-6}
    p = DetectorParameters(**depths, false_alarm=0.01, cage_scatter=0.0)
    count, found = 300 if seconds < 2.0 else 100, Counter[str]()
    for seed in range(count):
        one = machine(seed)
        scores = diagnose_as_a_whole(one.healthy(seconds), one.rate, one.speed, one.orders, p).scores
        found.update(fault for fault, score in scores.items() if score > 0.0)
    assert max(found.values(), default=0) <= 0.01 * count + 3.0 * math.sqrt(0.01 * count), found


@pytest.mark.parametrize("departure", [-0.015, 0.0, 0.015])
@pytest.mark.parametrize("fault", ["outer_ring", "inner_ring", "roller"])
@pytest.mark.parametrize("seconds", [1.0, 3.0])
def test_impacts_of_the_power_of_the_noise_are_named(fault: str, seconds: float, departure: float) -> None:
    """Two resonances may fall below the band at 12 kHz, hence all but one; a roller whose 2 BSF departs onto BPFO may be called either."""
    machines = [machine(seed, departure=departure) for seed in range(7)]
    near = [abs(2.0 * one.orders.bsf * (1.0 + departure) / one.orders.bpfo - 1.0) < 0.02 for one in machines]
    machines = [one for one, ambiguous in zip(machines, near, strict=True) if fault != "roller" or not ambiguous]
    verdicts = [verdict(one, one.healthy(seconds, shaft=0.2, gear=0.3) + one.impacts(seconds, fault)) for one in machines]
    assert verdicts.count(fault) >= len(machines) - 1 >= 4, verdicts
    assert set(verdicts) <= {fault, "healthy"}, verdicts


@pytest.mark.parametrize("departure", [-0.01, 0.01])
def test_a_ball_whose_spin_wanders_is_named(departure: float) -> None:
    """It loses its phase once per turn of the cage, so that no sharp line is at 2 BSF: without humps, half of them are named."""
    machines = [machine(seed, departure=departure) for seed in range(8)]
    verdicts = [verdict(one, one.healthy(8.0, shaft=0.2) + one.wandering_ball(8.0)) for one in machines]
    assert verdicts.count("roller") >= 7, verdicts


@pytest.mark.parametrize("gain", [0.01, 100.0])
@pytest.mark.parametrize("fault", ["outer_ring", "inner_ring", "roller"])
def test_no_gain_changes_the_verdict(fault: str, gain: float) -> None:
    one = machine(3)
    signal = one.healthy(2.0) + one.impacts(2.0, fault)
    assert verdict(one, gain * signal) == verdict(one, signal) == fault
