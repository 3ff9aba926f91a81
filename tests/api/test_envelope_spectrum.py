"""The squared envelope spectrum, against signals whose spectrum is known in closed form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dry_benches import dry_bench
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros import Bearing, Recording, Refusal, envelope_spectrum, simulate
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.diagnosis.envelope_spectrum import trackable

RATE = 51200

BAGS = Path(__file__).parents[2] / "bags"


def modulated(turns: Any, order: float, depth: float = 0.5, carrier: float = 6000.0) -> Any:
    """Return a carrier [Hz] whose amplitude varies ``order`` times a turn: (1 + depth cos)^2 = 1 + depth^2/2 + 2 depth cos + ..."""
    time = np.arange(len(turns)) / RATE
    return (1.0 + depth * np.cos(2.0 * np.pi * order * turns)) * np.sin(2.0 * np.pi * carrier * time)


@given(frequency=st.floats(20.0, 400.0), depth=st.floats(0.1, 1.0), gain=st.floats(0.01, 100.0))
def test_lines_of_a_modulated_carrier(frequency: float, depth: float, gain: float) -> None:
    time = np.arange(RATE) / RATE
    spectrum = envelope_spectrum(gain * modulated(time, frequency, depth), RATE, band=(4000.0, 8000.0))
    # A line between two points of the spectrum loses up to 0.4 dB.
    assert spectrum.at_frequency(frequency) == pytest.approx(2.0 * depth * gain**2, rel=0.06)
    assert spectrum.at_frequency([2.0 * frequency])[0] == pytest.approx(0.5 * depth**2 * gain**2, rel=0.1, abs=0.004 * gain**2)
    assert spectrum.mean == pytest.approx((1.0 + 0.5 * depth**2) * gain**2, rel=0.02)


def test_order_tracking_sharpens_what_a_run_up_smears() -> None:
    time = np.arange(4 * RATE) / RATE
    turns = 10.0 * time + 2.5 * time**2  # from 10 to 30 Hz
    signal, angle = modulated(turns, 6.72), 2.0 * np.pi * turns
    tracked = envelope_spectrum(signal, RATE, band=(4000.0, 8000.0), shaft_angle=angle)
    smeared = envelope_spectrum(signal, RATE, band=(4000.0, 8000.0), shaft_angle=angle, order_tracking=False)
    assert tracked.tracked
    assert tracked.shaft_frequency == pytest.approx(20.0, rel=1e-3)
    assert tracked.at(6.72) == pytest.approx(1.0, rel=0.05)
    assert tracked.order[np.argmax(tracked.amplitude)] == pytest.approx(6.72, abs=0.02)
    assert smeared.amplitude.max() < 0.3
    assert tracked.frequency == pytest.approx(tracked.order * tracked.shaft_frequency)
    assert smeared.order == pytest.approx(smeared.frequency / 20.0, rel=1e-3)


def test_a_shaft_that_turns_backwards_has_the_same_orders() -> None:
    time = np.arange(2 * RATE) / RATE
    turns = 20.0 * time
    forth, back = (envelope_spectrum(modulated(turns, 5.0), RATE, shaft_angle=sign * 2.0 * np.pi * turns) for sign in (1.0, -1.0))
    assert back.at(5.0) == pytest.approx(forth.at(5.0), rel=1e-3)


def test_both_axes_add_up() -> None:
    signal = modulated(np.arange(RATE) / RATE, 100.0)
    one = envelope_spectrum(signal, RATE)
    both = envelope_spectrum(np.column_stack([signal, 2.0 * signal]), RATE)
    assert both.at_frequency(100.0) == pytest.approx(5.0 * one.at_frequency(100.0), rel=1e-3)


def test_a_defect_raises_the_lines_of_its_order() -> None:
    healthy, defective = (simulate(dry_bench(name), 1.0) for name in ("healthy", "outer_ring_defect"))
    lines = [envelope_spectrum(run).at(run.orders.bpfo * np.array([1.0, 2.0, 3.0])) for run in (healthy, defective)]
    assert (lines[1] > 100.0 * lines[0]).all()


def test_a_recording_is_taken_as_it_is() -> None:
    recording = Recording(BAGS / "outer_ring_defect")
    spectrum = envelope_spectrum(recording)
    assert np.array_equal(spectrum.amplitude, envelope_spectrum(recording.waveform()).amplitude)
    assert repr(spectrum) == "<EnvelopeSpectrum: 54001 lines, orders up to 450, of the band from 2 to 20 kHz>"


def test_the_default_band_follows_the_sampling_rate() -> None:
    assert envelope_spectrum(np.random.default_rng(1).standard_normal(25600), 25600).band == (2000.0, 11520.0)


ANGLE = np.linspace(0.0, 200.0, RATE)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"sampling_rate": None}, "sampling_rate is missing: give it in Hz"),
        ({"band": (8000.0, 4000.0)}, r"band = \(8000, 4000\) Hz is not within 0 .. 25600 Hz"),
        ({"band": (2000.0, 30000.0)}, "half the sampling rate"),
        ({"band": 5}, "band = 5 is not a pair of frequencies"),
        ({"band": ("a", "b")}, "the lower edge of the band, 'a' is not a number: give it in Hz"),
        ({"band": (4000.0, 4060.0)}, "51200 samples are too few for the band of .*: give at least 54614"),
        ({"order_tracking": True}, "cannot be order-tracked: give shaft_angle"),
        ({"shaft_angle": ANGLE / 100.0}, "the shaft makes 0.32 turns where order tracking needs 4"),
        ({"shaft_angle": 100.0 * np.abs(np.linspace(-0.5, 1.0, RATE))}, "the shaft turns back"),
        ({"shaft_angle": ANGLE[:-1]}, "is not a waveform"),
    ],
)
def test_refusals(arguments: dict[str, Any], sentence: str) -> None:
    noise = np.random.default_rng(1).standard_normal(RATE)
    with pytest.raises(Refusal, match=sentence):
        envelope_spectrum(noise, **{"sampling_rate": RATE, **arguments})


@pytest.mark.parametrize("order", [900.0, -3.0, np.nan, [1.0, 900.0]])
def test_places_outside_the_spectrum_are_refused(order: Any) -> None:
    spectrum = envelope_spectrum(np.random.default_rng(1).standard_normal(RATE), RATE, shaft_angle=ANGLE)
    with pytest.raises(Refusal, match=r"order (900|-3|nan) is outside 0 \.\. "):
        spectrum.at(order)
    with pytest.raises(Refusal, match=r"frequency 1e\+06 Hz is outside 0 \.\. "):
        spectrum.at_frequency(1e6)
    with pytest.raises(Refusal, match="order = True is not a number"):
        spectrum.at(True)
    for wrong in ("a", "5", [[1.0], [1.0, 2.0]]):
        with pytest.raises(Refusal, match="order is not an array of real numbers"):
            spectrum.at(wrong)  # type: ignore[arg-type]
    assert spectrum.at(spectrum.order[-1]) > 0.0


def test_orders_of_a_signal_without_speed_are_refused() -> None:
    with pytest.raises(Refusal, match="the spectrum has no orders"):
        envelope_spectrum(np.random.default_rng(1).standard_normal(RATE), RATE).at(1.0)


def test_a_signal_of_a_few_samples_is_refused() -> None:
    with pytest.raises(Refusal, match=r"10 samples are too few for the band of .*: give at least 183"):
        envelope_spectrum(np.ones(10), RATE)


def test_lost_samples_and_values_that_are_not_finite_are_refused() -> None:
    run = simulate("dry", 0.5, settings={"publishing.loss_probability": 0.3})
    with pytest.raises(Refusal, match="lacks samples after"):
        envelope_spectrum(run)
    noise = np.random.default_rng(1).standard_normal(RATE)
    noise[5] = np.nan
    with pytest.raises(Refusal, match="not finite"):
        envelope_spectrum(noise, RATE)


def test_a_run_has_its_own_rate_and_bearing() -> None:
    run = simulate("dry", 0.3)
    with pytest.raises(Refusal, match="bearing is given beside <SimulationResult"):
        envelope_spectrum(run, bearing=Bearing())


@pytest.mark.parametrize(
    ("turns", "expected"),
    [
        (np.linspace(0.0, 4.01, 1000), True),
        (np.linspace(0.0, -4.01, 1000), True),
        (np.linspace(0.0, 3.99, 1000), False),
        (np.concatenate([np.linspace(0.0, 6.0, 1000), np.linspace(6.0, 5.0, 200)]), False),
        (None, False),
    ],
    ids=["forwards", "backwards", "too short", "to and fro", "no angle"],
)
def test_order_tracking_needs_four_turns_in_one_direction(turns: Any, expected: bool) -> None:
    angle = None if turns is None else 2.0 * np.pi * turns
    assert trackable(Waveform.from_arrays(np.zeros(1000 if turns is None else len(turns)), RATE, shaft_angle=angle)) is expected
