"""Passages over damage that differ: their random numbers, strengths, times, and the spin of balls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from dcrb_ros.bearing.unequal_impacts import impacts_of, mean_strength, unequal_damage
from dcrb_ros.core.contacts.chance import key_of, normal_of
from dcrb_ros.core.contacts.impacts import Impacts, delay_of, latitude_of, mark_strength, met, passage_of, strength_of
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration

COUNT = 4000
SPALL = {"kind": "spall", "width": 5e-4, "depth": 1e-4, "share": 1.0, "row": 1}


def impacts(faults: dict[str, Any] | None = None, seed: int = 1, **values: float) -> Impacts:
    """Return the impacts of the bench with balls, without the waviness of its surfaces."""
    settings: dict[str, Any] = {"impacts": values, "faults": faults or {"outer_1": SPALL}, "surfaces": {"seed": seed}}
    made = load_configuration("ball_bearing_6205", settings)
    nothing = np.zeros((2, 1, 1), np.int64)
    return impacts_of(made, unequal_damage(made, made.faults.damage(made.bearing)), nothing, nothing)


def strengths(of: Impacts, count: int = COUNT, angle: float = 0.0) -> Floats:
    """Return the strengths of successive passages, the shaft turning by ``angle`` [rad] between two."""
    rollers = of.elements.shape[1]
    return np.array([strength_of(of, int(of.names[0]), 0, -k % rollers, k, angle * k) for k in range(count)])


def test_normal_numbers_are_normal_and_independent() -> None:
    drawn = np.array([normal_of(key_of(3, 1, 2, k)) for k in range(-COUNT, COUNT)])
    assert drawn.mean() == pytest.approx(0.0, abs=4.0 / math.sqrt(2 * COUNT))
    assert drawn.std() == pytest.approx(1.0, abs=0.04)
    assert np.mean(drawn**4) == pytest.approx(3.0, abs=0.35)
    for lag in (1, 2, 9):
        assert np.corrcoef(drawn[lag:], drawn[:-lag])[0, 1] == pytest.approx(0.0, abs=0.045)
    for other in ((4, 1, 2), (3, 2, 2), (3, 1, 3)):
        assert abs(np.corrcoef(drawn, [normal_of(key_of(*other, k)) for k in range(-COUNT, COUNT)])[0, 1]) < 0.045


@pytest.mark.parametrize("spread", [0.1, 0.4, 0.8, 1.3])
def test_strengths_have_a_mean_of_one_and_their_spread(spread: float) -> None:
    drawn = strengths(impacts(spread=spread))
    assert drawn.mean() == pytest.approx(1.0, abs=0.06)
    reference = np.maximum(0.0, 1.0 + spread * np.random.default_rng(1).standard_normal(200000))
    assert drawn.std() == pytest.approx(reference.std() / reference.mean(), rel=0.06)


@pytest.mark.parametrize("spread", [0.1, 0.4, 0.8])
def test_the_lines_of_a_train_of_impacts_rise_over_their_background_as_its_scatter_says(spread: float) -> None:
    """0.98 sum over three harmonics of sqrt(N)/c_E for N impacts in the window and a relative scatter of energy c_E."""
    count, rate, ratios = 107, 16384, []
    for seed in (1, 2, 3, 4):
        energy = strengths(impacts(seed=seed, spread=spread), count) ** 2
        train = np.zeros(rate)
        train[((np.arange(count) + 0.5) / count * rate).astype(int)] = energy
        spectrum = np.abs(np.fft.rfft(train * np.hanning(rate)))
        places = [np.arange(k * count - count // 2, k * count + count // 2) for k in (1, 2, 3)]
        found = sum(spectrum[at].max() / np.median(spectrum[at]) for at in places)
        ratios.append(found / (0.98 * 3.0 * math.sqrt(count) * energy.mean() / energy.std()))
    assert np.median(ratios) == pytest.approx(1.0, abs=0.25)


def test_the_white_part_is_weaker_after_a_strong_impact() -> None:
    """-0.2/(1 + 0.2^2) at lag one."""
    drawn = strengths(impacts(spread=0.2))
    assert np.corrcoef(drawn[1:], drawn[:-1])[0, 1] == pytest.approx(-0.192, abs=0.045)
    assert np.corrcoef(drawn[9:], drawn[:-9])[0, 1] == pytest.approx(0.0, abs=0.045)


def test_shares_of_element_and_shaft_are_those_of_the_variance() -> None:
    of = impacts(spread=0.2, element_share=0.5, shaft_share=0.3)
    drawn = strengths(of, angle=1.0)
    assert np.corrcoef(drawn[9:], drawn[:-9])[0, 1] == pytest.approx(0.5 + 0.3 * math.cos(9.0), abs=0.06)
    wave = abs(2.0 * np.mean((drawn - 1.0) * np.exp(-1j * np.arange(COUNT)))) ** 2 / 2.0
    assert wave / drawn.var() == pytest.approx(0.3, abs=0.05)
    assert mean_strength(np.zeros((1, 9)), 0.0, 1.0) == pytest.approx(1.0833, abs=1e-4)  # Phi(1) + phi(1)


def test_a_bearing_has_its_own_strengths() -> None:
    first, again, other = (strengths(impacts(seed=seed, spread=0.4), 200) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.25


def test_a_passage_has_one_number_and_one_strength_and_the_next_roller_another() -> None:
    of, pitch = impacts(spread=0.5, shaft_share=0.3), 2.0 * math.pi / 9
    passages, found = [], []
    for k in range(20):
        i = -k % 9
        orbits = pitch * k  # of the cage when roller i is at the middle
        several = set()
        for offset in (-0.02, 0.0, 0.02):
            assert passage_of(orbits + offset, 0.0, pitch * i, offset, 0.0, 9, i) == k
            several.add(round(met(of, 1, 0, i, offset, 0, orbits + offset, (orbits + offset) / of.orbit, 188.0)[0], 9))
        assert len(several) == 1
        passages.append(k)
        found.append(several.pop())
    assert len(set(found)) == len(found)


def test_times_are_independent_and_limited() -> None:
    of = impacts(time_spread=4e-5)
    drawn = np.array([delay_of(of, int(of.names[0]), 0, k) for k in range(COUNT)])
    assert drawn.std() == pytest.approx(4e-5, rel=0.05)
    assert np.abs(drawn).max() == pytest.approx(1.2e-4)
    assert np.corrcoef(drawn[1:], drawn[:-1])[0, 1] == pytest.approx(0.0, abs=0.045)
    strength, shift = met(of, 1, 0, 0, 0.0, 0, 0.0, 0.0, 188.0)
    assert strength == 1.0
    assert shift == pytest.approx(of.orbit * 188.0 * delay_of(of, int(of.names[0]), 0, 0))


def test_a_mark_on_a_ball_is_hit_as_often_as_an_axis_of_any_direction_says() -> None:
    """sin(delta) of 1000 memories for directions that are uniform on the sphere; delta = (d/2 + a)/r."""
    of = impacts({"roller_1": {"width": 5e-4}}, spin_memory=0.05)
    times = 0.05 / 6.0 * np.arange(6000)
    for ring in (0, 1):
        hits = np.array([mark_strength(of, ring, 0, time) > 0.0 for time in times])
        assert hits.mean() == pytest.approx(math.sin(of.latitudes[ring, 0]), rel=0.1)
        # A strength d/(2 a) gives the semimajor axis a; the mark is 0.5 mm wide and the ball has a radius of 3.97 mm.
        assert 0.0 < of.mark_strengths[ring, 0] < 1.0
        assert 3.97e-3 * of.latitudes[ring, 0] == pytest.approx(0.25e-3 * (1.0 + 1.0 / of.mark_strengths[ring, 0]), rel=1e-3)
    latitudes = np.array([latitude_of(of, int(of.marked[0]), time) for time in times])
    assert np.sin(latitudes).mean() == pytest.approx(0.0, abs=0.06)
    assert np.sin(latitudes).std() == pytest.approx(1.0 / math.sqrt(3.0), rel=0.05)
    assert np.corrcoef(latitudes[1:], latitudes[:-1])[0, 1] > 0.9
    assert abs(np.corrcoef(latitudes[12:], latitudes[:-12])[0, 1]) < 0.1


@pytest.mark.parametrize(
    ("bench", "setting", "words"),
    [
        ("ball_bearing_6205", "impacts.axial_share=0.9", r"impacts\.axial_share = 0\.9 is between 0\.8 and 1: give 0 \.\. 0\.8"),
        ("healthy", "impacts.spin_memory=1.0", r"impacts\.spin_memory = 1 s belongs to balls, and contact\.law = johnson"),
        (
            "healthy",
            "impacts.element_share=0.5",
            r"element_share = 0\.5 is a share of the variance of impacts\.spread, which is 0",
        ),
        ("paper", "impacts.spread=0.5", r"impacts\.spread = 0\.5 needs surfaces\.law = profile, and it is smooth"),
    ],
)
def test_impossible_impacts_are_refused(bench: str, setting: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        load_configuration(bench, [setting])


def test_shares_of_more_than_the_whole_are_refused() -> None:
    with pytest.raises(ValueError, match=r"impacts\.element_share \+ impacts\.shaft_share = 1\.2 is above 1"):
        load_configuration("healthy", ["impacts.element_share=0.6", "impacts.shaft_share=0.6"])
