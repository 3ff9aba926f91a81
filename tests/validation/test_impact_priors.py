"""Priors of unequal impacts."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

from impact_priors import AXLE_BOX, LABORATORY, ImpactPriors, draw_impacts, remaining

from dcrb_ros.settings.files import load_configuration


@pytest.mark.parametrize(("priors", "median", "highest"), [(LABORATORY, 0.5, 1.3), (AXLE_BOX, 0.25, 0.81)])
def test_drawn_machines_have_the_medians_and_limits_of_their_priors(priors: ImpactPriors, median: float, highest: float) -> None:
    random = np.random.default_rng(1)
    drawn = [draw_impacts(priors, random, balls=True) for _ in range(1000)]
    spreads = np.array([values["impacts.spread"] for values in drawn])
    assert np.median(spreads) == pytest.approx(median, rel=0.08)
    assert spreads.max() == pytest.approx(highest, rel=0.01)
    assert np.median([values["impacts.time_spread"] for values in drawn]) == pytest.approx(priors.time_spread.median, rel=0.12)
    assert np.mean([values["impacts.element_share"] for values in drawn]) == pytest.approx(1.0 / (1.0 + priors.element_share[1]), rel=0.1)


def sidebands(share: float) -> float:
    """Return the depth of an inner ring's sidebands at the shaft frequency, if the energy of an impact follows the square of the load."""
    root = share ** (2.0 / 3.0)
    cosine = np.cos(np.arange(3600) * np.pi / 1800.0)
    energy = np.maximum(root / (1.0 - root) + cosine, 0.0) ** 3
    return float((energy * cosine).mean() / energy.mean())


def test_axial_preload_in_a_laboratory_gives_the_sidebands_of_three_rigs() -> None:
    # Medians of CWRU, HIT and MFPT in docs/results/signals.md; without preload the depth is 3 pi/8 / (4/3).
    assert sidebands(0.0) == pytest.approx(9.0 * np.pi / 32.0, rel=1e-3)
    low, high = LABORATORY.axial_share
    for measured in (0.40, 0.38, 0.73):
        assert sidebands(high) < measured < sidebands(low)


def test_every_drawn_machine_is_a_valid_configuration() -> None:
    random = np.random.default_rng(2)
    for bench, priors, balls in (("ball_bearing_6205", LABORATORY, True), ("healthy", AXLE_BOX, False)):
        for _ in range(50):
            load_configuration(bench, [f"{key}={value}" for key, value in draw_impacts(priors, random, balls=balls).items()])


def test_what_a_bench_causes_itself_is_taken_off_once() -> None:
    alone = draw_impacts(LABORATORY, np.random.default_rng(3), balls=False)
    spread, share = alone["impacts.spread"], alone["impacts.element_share"]
    part = 0.5 * spread * share**0.5
    less = draw_impacts(LABORATORY, np.random.default_rng(3), balls=False, of_element=part)
    assert less["impacts.spread"] ** 2 + part**2 == pytest.approx(spread**2)
    assert less["impacts.spread"] ** 2 * less["impacts.shaft_share"] == pytest.approx(spread**2 * alone["impacts.shaft_share"])
    without = draw_impacts(LABORATORY, np.random.default_rng(3), balls=False, of_element=10.0)
    assert without["impacts.element_share"] == 0.0
    assert remaining(0.3, (0.4,)) == 0.0
