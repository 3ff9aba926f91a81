"""The bearing's share of the healthy power."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from synthetic_bearing import ORDERS

import dcrb_ros
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.calibration.bearing_share import SHALLOW, UNKNOWN, EnvelopeLines, _decoys, _drawn_shares, _one_more, _part, lines_in
from dcrb_ros.calibration.simulated_bearing import INDIVIDUALS
from dcrb_ros.schema.arrays import Floats

pytestmark = pytest.mark.slow

RATE, SHAFT = 25600, 20.0
BANDS = [(1000.0, 2000.0), (2000.0, 4000.0), (4000.0, 8000.0)]


def lines(depth: float, share: float, *, seed: int, slip: float = 0.0, seconds: float = 6.0) -> EnvelopeLines:
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
    assert (part.estimates[0].low, part.estimates[0].high) == (1.0 / UNKNOWN, 1.0)
    assert any("unknown" in sentence for sentence in part.remarks)


def test_a_machine_below_its_orders_without_lines_leaves_the_share_unknown() -> None:
    part = _part(np.zeros(100))
    assert (part.estimates[0].low, part.estimates[0].high) == (1.0 / UNKNOWN, 1.0)
    assert part.estimates[0].value == pytest.approx(1.0 / math.sqrt(UNKNOWN))
    assert any("unknown" in sentence for sentence in part.remarks)


def exact(family: float, decoy: float = 0.0, *, mean: float = 1.0, windows: int = 20) -> EnvelopeLines:
    """Return lines of equal squares in all windows, two bands and all families."""
    return EnvelopeLines(np.full((windows, 2, 3), family), np.full((windows, 2, 8), decoy), np.full(2, mean))


def test_the_share_is_the_ratio_of_the_lines_above_those_at_orders_without_lines() -> None:
    bench = [exact(4.3, 0.3, mean=2.0)] * INDIVIDUALS
    assert _drawn_shares([(exact(1.1, 0.1, mean=7.0), bench)]) == pytest.approx(0.5)


def test_an_individual_of_another_power_than_the_source_has_lines_of_the_same_depth() -> None:
    others = [exact(4.0 * power**2, mean=power) for power in (0.3, 2.0, 5.0)]
    assert _drawn_shares([(exact(1.0, mean=7.0), [exact(4.0), *others])]) == pytest.approx(0.5)


def test_bands_in_which_the_bench_has_shallow_lines_count_little() -> None:
    loud = np.array([1.0, 10.0])  # the bench's lines of the second band are shallow, and the machine has none there
    bench = [dataclasses.replace(exact(4.0), mean=loud)] * INDIVIDUALS
    machine = exact(1.0)
    machine.families[:, 1] = 0.0
    assert _drawn_shares([(machine, bench)]) == pytest.approx(0.5, rel=1e-3)


def test_noise_as_strong_as_the_constant_halves_the_weight_of_a_band() -> None:
    bench = [exact(4.0), *[exact(4.0 * 0.3**2, mean=0.3)] * (INDIVIDUALS - 1)]
    machine = exact(1.0)
    machine.families[:, 1], machine.decoys[:, 1] = SHALLOW**2, SHALLOW**2
    assert _drawn_shares([(machine, bench)]) == pytest.approx(math.sqrt(1.0 / 6.0))


def test_noise_of_a_loud_band_does_not_cover_the_lines_of_another() -> None:
    loud, random = exact(4.0), np.random.default_rng(4)
    loud.families[:, 1] = 100.0 * random.standard_normal((20, 3))
    loud.mean[1] = 5.0
    assert len(_drawn_shares([(exact(1.0), [*[exact(4.0)] * (INDIVIDUALS - 1), loud])])) > 2


def test_an_individual_whose_lines_come_and_go_like_noise_leaves_the_share_unknown() -> None:
    doubtful = exact(0.0)
    doubtful.families[::2], doubtful.families[1::2] = 3.0, -2.0
    assert _drawn_shares([(exact(1.0), [*[exact(4.0)] * (INDIVIDUALS - 1), doubtful])]).tolist() == [0.0, math.inf]


def test_a_family_below_its_neighbours_in_the_bench_is_not_a_line() -> None:
    bench, machine = exact(4.0), exact(1.0)
    bench.families[..., 2], machine.families[..., 2] = -9.0, 0.0
    assert _drawn_shares([(machine, [bench] * INDIVIDUALS)]) == pytest.approx(0.5)


def test_an_individual_without_lines_leaves_the_share_unknown() -> None:
    bench = [*[exact(4.0)] * (INDIVIDUALS - 1), exact(0.0)]
    assert _drawn_shares([(exact(1.0), bench)]).tolist() == [0.0, math.inf]


def test_the_interval_contains_one_more_individual_in_nine_of_ten_cases() -> None:
    random = np.random.default_rng(1)
    sums = np.exp(random.normal(2.0, 0.5, (1500, INDIVIDUALS + 1)))
    below = [np.mean([_one_more(row[:-1], random) < row[-1] for _ in range(40)]) for row in sums]
    assert np.mean(np.abs(np.array(below) - 0.5) < 0.45) == pytest.approx(0.9, abs=0.02)


def test_windows_that_overlap_by_half_count_half() -> None:
    random, count = np.random.default_rng(2), 60
    families = 1.0 + 0.1 * random.standard_normal((count, 1, 1)) * np.ones((1, 2, 3))
    drawn = _drawn_shares([(dataclasses.replace(exact(1.0, windows=count), families=families), [exact(1.0)] * INDIVIDUALS)])
    assert np.std(drawn**2) == pytest.approx(0.1 / math.sqrt(count / 2), rel=0.2)


def test_windows_overlap_by_half() -> None:
    assert len(lines(0.9, 1.0, seed=1, seconds=3.0).families) == 5


def test_harmonics_of_the_shaft_are_no_lines_of_the_bearing() -> None:
    random = np.random.default_rng(3)
    turns: Floats = SHAFT * np.arange(6 * RATE) / RATE
    signal = random.standard_normal(len(turns)) * np.sqrt(1.0 + 0.9 * np.cos(2.0 * math.pi * 7.0 * turns))
    near = Orders(ORDERS.ftf, 6.95, ORDERS.bpfi, ORDERS.bsf)
    found = lines_in(signal, turns, RATE, BANDS, near)
    assert np.all(np.abs(found.families.mean(axis=0)[:, 0] / found.mean**2) < 0.05)


@pytest.mark.parametrize("fundamentals", [(6.72, 9.28, 6.1), (3.5848, 5.4152, 4.7139)])
def test_orders_without_lines_keep_away_from_all_harmonics(fundamentals: tuple[float, ...]) -> None:
    found = np.array(_decoys(fundamentals))
    harmonics = np.outer(fundamentals, (1.0, 2.0, 3.0)).ravel()
    assert len(found) >= 4
    assert np.abs(found[:, None] / harmonics - 1.0).min() > 0.045


@pytest.mark.parametrize(
    ("nothing", "low", "value", "high"),
    [(0.0, 0.05, 0.5, 0.95), (0.2, 0.08, 0.8, 0.8), (0.6, 0.08, 0.8 / math.sqrt(10.0), 0.8), (0.6, 0.1, 1.0 / math.sqrt(10.0), 1.0)],
)
def test_the_interval_of_90_percent_ends_10_db_below_its_upper_end_where_no_line_stands_out(
    nothing: float, low: float, value: float, high: float
) -> None:
    drawn = np.linspace(0.0, 1.0, 101) if nothing == 0.0 else np.where(np.arange(100) < 100 * nothing, 0.0, high if high < 1.0 else 3.0)
    share = _part(drawn).estimates[0]
    assert (share.low, share.value, share.high) == pytest.approx((low, value, high))


def test_a_share_above_1_is_1() -> None:
    share = _part(np.full(100, 2.0)).estimates[0]
    assert share.low == share.value == share.high == 1.0


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
