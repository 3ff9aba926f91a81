"""The example detectors on signals made without the simulation: impulses that ring, modulated noise, and tones."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dcrb_ros import Orders

pytestmark = pytest.mark.slow

FOLDER = Path(__file__).parents[2] / "examples" / "detectors"
RATE, TURNS = 25600, 20.0
"""Sampling rate and shaft frequency [Hz]."""
ORDERS = Orders(ftf=0.42, bpfo=6.72, bpfi=9.28, bsf=3.05)
ONSET, END = 4.0, 8.0
"""[s]"""
BLOCK = 1000
LONGEST = 150
"""Most lines of a detector [-]."""


@pytest.fixture(autouse=True)
def examples(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Make the folder importable, as `dcrb score --python` does."""
    monkeypatch.syspath_prepend(str(FOLDER))
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        if getattr(sys.modules[name], "__file__", None) and Path(str(sys.modules[name].__file__)).parent == FOLDER:
            del sys.modules[name]


def noise(seed: int = 1) -> np.ndarray[Any, Any]:
    return np.random.default_rng(seed).normal(0.0, 1.0, int(END * RATE))


def impacts(order: float, level: float, *, ring: float = 5000.0, modulated: bool = False) -> np.ndarray[Any, Any]:
    """Return ringing impacts from the onset on, at a characteristic order whose period varies by 1 % (McFadden and Smith 1984)."""
    random, found, time = np.random.default_rng(2), np.zeros(int(END * RATE)), ONSET
    burst = np.arange(int(0.004 * RATE)) / RATE
    while time < END - 0.01:
        first = int(time * RATE)
        strength = level * (1.0 + np.cos(2.0 * np.pi * TURNS * time) if modulated else 1.0)
        found[first : first + len(burst)] += strength * np.exp(-burst / 0.0008) * np.sin(2.0 * np.pi * ring * burst)
        time += (1.0 + 0.01 * random.normal()) / (order * TURNS)
    return found


def run(detector: Any, signal: np.ndarray[Any, Any]) -> list[tuple[float, str, float | None]]:
    """Return time, verdict and score of every diagnosis."""
    angle = np.mod(2.0 * np.pi * TURNS * np.arange(len(signal)) / RATE, 2.0 * np.pi).astype(np.float32)
    both = np.stack([0.1 * signal, signal], axis=1).astype(np.float32)
    found = []
    for index in range(0, len(signal), BLOCK):
        diagnosis = detector.update(index, both[index : index + BLOCK], angle[index : index + BLOCK])
        if isinstance(diagnosis, str):
            found.append(((index + BLOCK) / RATE, diagnosis, None))
        elif diagnosis is not None:
            found.append((diagnosis.time, diagnosis.verdict, max(diagnosis.scores.values(), default=None)))
    return found


def made(name: str) -> Any:
    module, _, kind = name.partition(":")
    return getattr(importlib.import_module(module), kind)(ORDERS, RATE)


def verdicts(name: str, signal: np.ndarray[Any, Any]) -> tuple[set[str], str]:
    """Return the verdicts before the onset, and the last one."""
    found = run(made(name), signal)
    return {verdict for time, verdict, _ in found if time <= ONSET} - {"waiting"}, found[-1][1]


NAMING = ("squared_envelope:SquaredEnvelope", "kurtogram:Kurtogram", "autogram:Autogram", "momeda:Momeda", "cycbd:Cycbd")
LEVELS = ("rms_kurtosis:RmsKurtosis", "iso_band:IsoBand", "naive_bpfo:NaiveBpfo")


def test_every_detector_has_less_than_150_lines() -> None:
    lengths = {file.name: len(file.read_text(encoding="utf-8").splitlines()) for file in FOLDER.glob("*.py")}
    assert len(lengths) >= 9
    assert max(lengths.values()) < LONGEST


@pytest.mark.parametrize("name", ["zero_rule:ZeroRule", *LEVELS, *NAMING])
def test_steady_noise_is_healthy(name: str) -> None:
    assert verdicts(name, noise()) == ({"healthy"}, "healthy")


@pytest.mark.parametrize("name", NAMING)
@pytest.mark.parametrize(("part", "order"), [("outer_ring", ORDERS.bpfo), ("inner_ring", ORDERS.bpfi), ("roller", 2.0 * ORDERS.bsf)])
def test_a_defect_is_found_and_named(name: str, part: str, order: float) -> None:
    assert verdicts(name, noise() + impacts(order, 6.0, modulated=part == "inner_ring")) == ({"healthy"}, part)


@pytest.mark.parametrize(("part", "order"), [("outer_ring", ORDERS.bpfo), ("inner_ring", ORDERS.bpfi)])
def test_the_classifier_trained_on_simulations_names_defects_of_signals_made_without_them(part: str, order: float) -> None:
    assert verdicts("classifier:Classifier", noise()) == ({"healthy"}, "healthy")
    for gain in (0.01, 100.0):
        assert verdicts("classifier:Classifier", gain * (noise() + impacts(order, 6.0, modulated=part == "inner_ring"))) == (
            {"healthy"},
            part,
        )


@pytest.mark.parametrize("name", NAMING)
def test_the_score_grows_with_the_defect(name: str) -> None:
    small, large = (run(made(name), noise() + impacts(ORDERS.bpfo, level))[-1][2] for level in (2.0, 8.0))
    assert small is not None
    assert large is not None
    assert small < large


def test_rms_and_kurtosis_see_impacts_and_noise() -> None:
    assert verdicts("rms_kurtosis:RmsKurtosis", noise() + impacts(ORDERS.bpfo, 15.0))[1] == "outer_ring"
    louder = noise() * np.where(np.arange(int(END * RATE)) < ONSET * RATE, 1.0, 2.5)
    assert verdicts("rms_kurtosis:RmsKurtosis", louder)[1] == "outer_ring"


@pytest.mark.parametrize(("velocity", "verdict"), [(0.8e-3, "healthy"), (2.5e-3, "outer_ring")])
def test_the_band_alarm_is_a_quarter_of_zone_b_above_the_healthy_level(velocity: float, verdict: str) -> None:
    time = np.arange(int(END * RATE)) / RATE
    tone = np.sqrt(2.0) * velocity * 2.0 * np.pi * 50.0 * np.sin(2.0 * np.pi * 50.0 * time) * (time >= ONSET)
    assert verdicts("iso_band:IsoBand", 0.1 * noise() + tone) == ({"healthy"}, verdict)
    assert verdicts("iso_band:IsoBand", 0.1 * noise() + impacts(ORDERS.bpfo, 6.0))[1] == "healthy"  # beyond 1 kHz


def test_the_naive_detector_takes_a_healthy_modulation_for_a_defect() -> None:
    time = np.arange(int(END * RATE)) / RATE
    modulated = noise() * (1.0 + 0.8 * np.cos(2.0 * np.pi * ORDERS.bpfo * TURNS * time))
    before, last = verdicts("naive_bpfo:NaiveBpfo", modulated)
    assert ("outer_ring" in before, last) == (True, "outer_ring")
    assert verdicts("squared_envelope:SquaredEnvelope", modulated)[1] == "healthy"  # it was there from the start


def best_band(score: Callable[[Any], float], signal: np.ndarray[Any, Any]) -> tuple[float, float]:
    """Return the edges of the band with the largest score [Hz]."""
    trending = importlib.import_module("trending")
    low, high, _ = max((band for band in trending.bands(signal) if len(band[2]) >= len(signal) / 64), key=lambda band: score(band[2]))
    return low * RATE, high * RATE


def test_the_kurtogram_finds_the_band_in_which_impacts_ring() -> None:
    kurtogram = importlib.import_module("kurtogram")
    low, high = best_band(
        kurtogram.spectral_kurtosis, (noise() + impacts(ORDERS.bpfo, 4.0, ring=7000.0))[int(6.0 * RATE) : int(7.0 * RATE)]
    )
    assert low < 7000.0 < high


def test_the_kurtosis_of_a_complex_noise_envelope_is_zero_and_that_of_a_tone_is_minus_one() -> None:
    kurtogram = importlib.import_module("kurtogram")
    random = np.random.default_rng(3)
    envelope = random.normal(size=200_000) ** 2 + random.normal(size=200_000) ** 2
    assert kurtogram.spectral_kurtosis(envelope) == pytest.approx(0.0, abs=0.05)
    assert kurtogram.spectral_kurtosis(np.ones(10)) == -1.0


def test_a_single_impact_attracts_the_kurtogram_and_not_the_autogram() -> None:
    kurtogram, autogram = importlib.import_module("kurtogram"), importlib.import_module("autogram")
    signal = (noise() + impacts(ORDERS.bpfo, 4.0, ring=7000.0))[int(6.0 * RATE) : int(7.0 * RATE)]
    burst = np.arange(-150, 150) / RATE
    # Smooth, so that it stays in its band.
    signal[9000:9300] += 30.0 * np.exp(-((burst / 0.001) ** 2)) * np.sin(2.0 * np.pi * 2000.0 * burst)
    low, high = best_band(kurtogram.spectral_kurtosis, signal)
    assert high < 5000.0
    low, high, _ = autogram.most_periodic(signal, ORDERS.bpfi * TURNS)
    assert low * RATE < 7000.0 < high * RATE


def test_the_multi_d_norm_is_that_of_the_output_of_its_filter() -> None:
    """Compared with the matrices written out, as in McDonald and Zhao 2017."""
    momeda = importlib.import_module("momeda")
    period, count = 80, 60
    signal = np.random.default_rng(4).normal(size=period * count)
    signal[17::period] += 3.0
    matrix = np.stack([np.roll(signal, lag) for lag in range(momeda.TAPS)])
    norms = []
    for position in range(period):
        target = np.zeros(len(signal))
        target[position::period] = 1.0
        output = matrix.T @ np.linalg.solve(matrix @ matrix.T, matrix @ target)
        norms.append(target @ output / np.linalg.norm(target) / np.linalg.norm(output))
    assert momeda.multi_d_norm(signal, float(period)) == pytest.approx(max(norms), rel=0.02)
    # An impulse train reaches 1, and a wrong period much less.
    train = np.zeros(8000)
    train[5::80] = 1.0
    assert momeda.multi_d_norm(train, 80.0) == pytest.approx(1.0, abs=0.02)
    assert momeda.multi_d_norm(train, 73.0) < 0.5


def test_lost_blocks_start_a_new_window() -> None:
    detector = made("squared_envelope:SquaredEnvelope")
    block, angle = np.zeros((BLOCK, 2), np.float32), np.zeros(BLOCK, np.float32)
    ends = [
        index for index in [*range(0, 20 * BLOCK, BLOCK), *range(30 * BLOCK, 60 * BLOCK, BLOCK)] if detector.update(index, block, angle)
    ]
    assert ends == [55 * BLOCK]


def test_no_band_has_the_jump_between_the_ends_of_a_window() -> None:
    from trending import HIGHEST, bands  # type: ignore[import-not-found]

    # A quarter of a period: the window ends at another level than it begins, as any window of a low-frequency vibration does.
    slow = 100.0 * np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, RATE)) + 1e-3 * noise()[:RATE]
    edges = []
    for low, high, envelope in bands(slow):
        edges.append(high)
        if low > 0.05:
            ends = max(1, len(envelope) // 100)
            assert max(envelope[:ends].max(), envelope[-ends:].max()) < 10.0 * np.median(envelope)
    assert max(edges) <= HIGHEST


def test_noise_exceeds_the_level_of_the_templates_as_often_as_stated() -> None:
    templates = importlib.import_module("envelope_templates")
    random = np.random.default_rng(3)
    detector = templates.EnvelopeTemplates(ORDERS, 12000, chance=0.01)
    angle = 2.0 * np.pi * 30.0 * np.arange(6000) / 12000
    windows = [detector.features(random.normal(size=6000), angle) for _ in range(500)]
    assert 2 <= sum(value > 1.0 for window in windows for value in window.values()) <= 40


def test_the_autogram_takes_its_widest_band_where_no_band_separates_the_impacts() -> None:
    autogram = importlib.import_module("autogram")
    signal = np.random.default_rng(1).normal(size=2560)
    low, high, envelope = autogram.most_periodic(signal, 1000.0)
    widths = {len(band[2]) for band in importlib.import_module("trending").bands(signal)}
    assert len(envelope) == max(widths) < 4000.0
    assert high - low == pytest.approx(0.215, abs=0.001)
