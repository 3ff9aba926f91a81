"""The fast spectral coherence against modulated noise, whose coherence is known."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.diagnosis.features.spectral_coherence import SpectralCoherence, spectral_coherence
from dcrb_ros.schema.refusal import Refusal

RATE = 25600
TIME = np.arange(8 * RATE) / RATE
DEPTH = 0.8
EXPECTED = DEPTH / (1.0 + 0.5 * DEPTH**2)
"""(1 + m cos)^2 n^2 has the Fourier coefficients 1 + m^2/2, m and m^2/4 at 0, alpha and 2 alpha."""


def modulated(frequency: float, seed: int = 3) -> SpectralCoherence:
    carrier = np.random.default_rng(seed).normal(size=len(TIME))
    return spectral_coherence((1.0 + DEPTH * np.cos(2.0 * np.pi * frequency * TIME)) * carrier, RATE, TIME, 2.2 * frequency)


def at_line(found: SpectralCoherence, order: float, inside: npt.NDArray[np.bool_]) -> tuple[float, float]:
    """Return the mean coherence over the carriers, and its order, at a line between the orders: by the main lobe of a Hann window."""
    line = int(np.abs(found.order - order).argmin())
    mean = np.abs(found.coherence[inside].mean(axis=0))
    side = 1 if mean[line + 1] > mean[line - 1] else -1
    ratio = mean[line + side] / mean[line]
    offset = (2.0 * ratio - 1.0) / (ratio + 1.0)
    loss = np.sinc(offset) / (1.0 - offset**2)
    return float(mean[line] / loss), float(found.order[line] + side * offset * found.order[1])


# The resolution of the carrier is 800 Hz: below it, near it and above it, where other authors' methods see nothing.
@pytest.mark.parametrize("frequency", [60.0, 400.0, 830.0, 1700.0])
def test_modulated_noise_has_the_coherence_of_its_modulation(frequency: float) -> None:
    found = modulated(frequency)
    inside = (found.frequency > 3.0 * frequency) & (found.frequency < 0.5 * RATE - 800.0)
    for multiple, expected in ((1, EXPECTED), (2, 0.25 * DEPTH**2 / (1.0 + 0.5 * DEPTH**2))):
        value, order = at_line(found, multiple * frequency, inside)
        assert np.abs(value) == pytest.approx(expected, rel=0.04)
        assert order == pytest.approx(multiple * frequency, abs=0.02)
    beside = np.abs(found.order - 1.4 * frequency).argmin()
    assert np.abs(found.coherence[inside, beside]).mean() < 0.1 * EXPECTED


def test_a_varying_speed_leaves_the_coherence_as_it_is() -> None:
    turns = 20.0 * TIME + 2.0 * np.sin(2.0 * np.pi * 0.3 * TIME)
    signal = (1.0 + DEPTH * np.cos(2.0 * np.pi * 7.3 * turns)) * np.random.default_rng(4).normal(size=len(TIME))
    found = spectral_coherence(signal, RATE, turns, 30.0)
    value, order = at_line(found, 7.3, (found.frequency > 1000.0) & (found.frequency < 12000.0))
    assert value == pytest.approx(EXPECTED, rel=0.04)
    assert order == pytest.approx(7.3, abs=0.01)


def test_the_carrier_of_a_modulated_band_is_found() -> None:
    rng = np.random.default_rng(5)
    line = np.fft.rfftfreq(len(TIME), 1.0 / RATE)
    spectrum = np.fft.rfft(rng.normal(size=len(TIME)))
    band = np.fft.irfft(np.where((line > 6000.0) & (line < 8000.0), spectrum, 0.0), len(TIME))
    signal = 0.2 * rng.normal(size=len(TIME)) + (1.0 + np.cos(2.0 * np.pi * 90.0 * TIME)) * band
    found = spectral_coherence(signal, RATE, TIME, 200.0)
    at = np.abs(found.coherence[:, np.abs(found.order - 90.0).argmin()])
    assert 6000.0 <= found.frequency[at.argmax()] <= 8000.0
    assert at[found.frequency < 5000.0].max() < 0.2
    inside, outside = (found.enhanced_envelope_spectrum(*edges) for edges in ((6000.0, 8000.0), (0.0, 5000.0)))
    assert np.abs(found.order[inside[50:].argmax() + 50] - 90.0) < 0.2
    assert inside.max() > 5.0 * outside[50:].max()


@pytest.mark.parametrize(
    ("samples", "turns", "highest", "sentence"),
    [
        (RATE, np.zeros(5), 10.0, "do not fit"),
        (100, np.arange(100.0), 10.0, "too few for a resolution of 800 Hz: give at least 512"),
        (RATE, np.zeros(RATE), 10.0, "must rise"),
        (RATE, np.arange(RATE) / RATE, 1e5, "reaches 1e\\+05 Hz: give one below 6400 Hz"),
        (RATE, np.arange(RATE) / RATE, float("nan"), "reaches nan Hz"),
    ],
)
def test_what_has_no_coherence_is_refused(samples: int, turns: np.ndarray, highest: float, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        spectral_coherence(np.ones(samples), RATE, turns, highest)


@pytest.mark.parametrize("resolution", [0.0, -1.0, 1601.0])
def test_a_resolution_that_the_signal_cannot_have_is_refused(resolution: float) -> None:
    with pytest.raises(Refusal, match=rf"resolution = {resolution:g} Hz is outside 0 \.\. 1600 Hz"):
        spectral_coherence(np.ones(RATE), RATE, np.arange(RATE) / RATE, 10.0, resolution=resolution)


def test_a_signal_that_is_not_finite_is_refused() -> None:
    with pytest.raises(Refusal, match="not finite: leave these samples out"):
        spectral_coherence(np.full(RATE, np.nan), RATE, np.arange(RATE) / RATE, 10.0)


def test_a_band_without_a_carrier_is_refused() -> None:
    with pytest.raises(Refusal, match=r"no carrier lies within 20000 \.\. 30000 Hz"):
        modulated(60.0).enhanced_envelope_spectrum(20000.0, 30000.0)
