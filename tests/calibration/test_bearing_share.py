"""The bearing's share of the healthy power."""

from __future__ import annotations

import math

import numpy as np
import pytest
from synthetic_bearing import ORDERS

import dcrb_ros
from dcrb_ros.calibration.bearing_share import Lines, _drawn_shares, _part, lines_in
from dcrb_ros.calibration.source import INDIVIDUALS
from dcrb_ros.schema.arrays import Floats

pytestmark = pytest.mark.slow

RATE, SHAFT = 25600, 20.0
BANDS = [(1000.0, 2000.0), (2000.0, 4000.0), (4000.0, 8000.0)]


def lines(depth: float, share: float, *, seed: int, slip: float = 0.0, seconds: float = 6.0) -> Lines:
    """Return the lines of noise whose power is modulated at BPFO, as a share of the power, in noise that is not."""
    random = np.random.default_rng(seed)
    turns: Floats = SHAFT * np.arange(round(seconds * RATE)) / RATE
    bearing, other = random.standard_normal((2, len(turns)))
    modulated = bearing * np.sqrt(1.0 + depth * np.cos(2.0 * math.pi * ORDERS.bpfo * (1.0 + slip) * turns))
    return lines_in(math.sqrt(share) * modulated + math.sqrt(1.0 - share) * other, turns, RATE, BANDS, ORDERS)


@pytest.mark.parametrize(("share", "seed"), [(0.15, 13), (0.3, 11), (0.6, 11)])
def test_a_share_is_within_its_interval_wherever_slip_moves_the_lines(share: float, seed: int) -> None:
    bench = [lines(0.9, 1.0, seed=k) for k in range(INDIVIDUALS)]
    drawn = _drawn_shares([(lines(0.9, share, seed=seed, slip=0.01), bench)])
    low, high = np.quantile(drawn, [0.05, 0.95])
    assert low <= share <= high
    assert np.median(drawn) == pytest.approx(share, rel=0.1)


def test_noise_alone_leaves_an_upper_bound_and_says_that_the_lower_one_is_a_convention() -> None:
    bench = [lines(0.9, 1.0, seed=k) for k in range(INDIVIDUALS)]
    part = _part(_drawn_shares([(lines(0.0, 1.0, seed=12), bench)]))
    share = part.estimates[0]
    assert share.high < 0.3
    assert share.low == pytest.approx(share.high / 10.0)
    assert any("convention" in sentence for sentence in part.remarks)


def test_all_of_the_power_is_the_bearings_where_its_lines_are_as_deep_as_the_benchs() -> None:
    part = _part(_drawn_shares([(lines(0.9, 1.0, seed=12), [lines(0.9, 1.0, seed=k) for k in range(INDIVIDUALS)])]))
    assert part.estimates[0].value > 0.95
    assert part.estimates[0].high == 1.0
    assert part.remarks == []


def test_a_bench_without_lines_says_that_the_share_is_unknown() -> None:
    part = _part(_drawn_shares([(lines(0.9, 1.0, seed=12), [lines(0.0, 1.0, seed=k) for k in range(INDIVIDUALS)])]))
    assert part.estimates[0].value == part.estimates[0].high == 1.0


def test_a_machine_with_noise_of_its_own_gets_its_share_and_its_spectrum_back() -> None:
    plant = {
        "structure.bearing_share": 0.1,
        "structure.noise_x": 0.02,
        "structure.noise_y": 0.02,
        "structure.noise_path_x": "2000 0.1 4000 0.3",
        "structure.noise_path_y": "2000 0.1 4000 0.3",
        "sensor.noise_density": 1e-4,
        "surfaces.seed": 5,
    }
    run = dcrb_ros.simulate("healthy", 4.0, settings=plant)
    found = dcrb_ros.calibrate(run, base="healthy", trust=True)
    assert found["structure.bearing_share"].value < 0.5
    twin = dcrb_ros.simulate(found.configuration, 3.0)
    for one in dcrb_ros.compare(run.between(0.5), twin.between(0.5)).axes:
        heard = one.frequency >= 250.0
        assert np.sqrt(np.mean(one.difference[heard] ** 2)) < 1.5
        assert one.envelope_distance < 0.7
