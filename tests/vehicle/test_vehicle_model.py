"""The vehicle around its bearings: numbers of the frequency-domain model, published laws, and causality, reciprocity and determinism."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.vehicle.description import Track, Vehicle, Wheel
from dcrb_ros.vehicle.file import read_vehicle
from dcrb_ros.vehicle.loads import quasi_static
from dcrb_ros.vehicle.model import FRAME, TICK, TrackEvent, VehicleModel
from dcrb_ros.vehicle.paths import BANDS, bearing_paths
from dcrb_ros.vehicle.structure import Structure, wheelset
from dcrb_ros.vehicle.track import PAGE, Rails, Random, coherence, irregularity
from dcrb_ros.vehicle.wheels import jump

SMOOTH = {"track.spectrum": "none", "track.roughness": -40.0}


def bogie(**changes: Any) -> Vehicle:
    return read_vehicle("healthy_bogie", {key.replace("__", "."): value for key, value in changes.items()})


def smooth(**changes: Any) -> Vehicle:
    return read_vehicle("healthy_bogie", SMOOTH | {key.replace("__", "."): value for key, value in changes.items()})


def run(vehicle: Vehicle, duration: float) -> tuple[np.ndarray, np.ndarray, list[TrackEvent]]:
    """Return motion by the track (boxes, steps), loads (frames, boxes) and events."""
    model = VehicleModel(vehicle)
    plans = [model.plan() for _ in range(round(duration * model.rate / FRAME))]
    return (
        np.concatenate([plan.motion for plan in plans], axis=1),
        -np.array([plan.load[:, 1] for plan in plans]),
        [event for plan in plans for event in plan.events],
    )


def lowpass(motion: np.ndarray, cutoff: float, rate: float) -> np.ndarray:
    return np.asarray(sosfiltfilt(butter(4, cutoff, fs=rate, output="sos"), motion))


def test_a_free_wheelset_bends_at_70_and_162_hz() -> None:
    # Of the finite-element model in the frequency domain, without rail and frame.
    assert wheelset().frequency[:4] / (2.0 * np.pi) == pytest.approx([0.0, 0.0, 70.4, 161.9], abs=0.5)


def test_a_box_peaks_at_48_59_77_and_162_hz() -> None:
    structure, frequency = Structure(bogie()), np.arange(20.0, 250.0, 1.0)
    level = np.array([abs(structure.response(f)[0, 0]) * f * f for f in frequency])
    peaks = frequency[1:-1][(level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])]
    assert peaks == pytest.approx([48.0, 59.0, 77.0, 162.0], rel=0.03)


@pytest.mark.parametrize(
    ("low", "high", "right", "behind", "diagonal"), [(20.0, 80.0, 0.0, -23.3, -22.7), (80.0, 200.0, -5.4, -26.7, -31.1)]
)
def test_a_contact_is_heard_elsewhere_as_in_the_frequency_domain(
    low: float, high: float, right: float, behind: float, diagonal: float
) -> None:
    structure = Structure(bogie())
    power = np.mean([abs(structure.response(f)[:, 0] * f * f) ** 2 for f in np.geomspace(low, high, 40)], axis=0)
    assert 10.0 * np.log10(power[1:] / power[0]) == pytest.approx([right, behind, diagonal], abs=3.0)


def test_the_modes_have_the_response_of_the_structure() -> None:
    vehicle = smooth()
    structure, interval = Structure(vehicle), TICK / 102400.0
    growth, before, after, read, direct = structure.modal(interval)
    for frequency in (5.0, 48.0, 162.0, 400.0):
        # The response of the recursion to exp(j w t), sampled; inputs between ticks are straight lines, which matters above.
        z = np.exp(2j * np.pi * frequency * interval)
        state = (before + after * z) / (z - growth)[:, None]
        expected = -((2.0 * np.pi * frequency) ** 2) * structure.response(frequency)
        assert (read @ state + direct)[:4] == pytest.approx(expected, rel=0.02, abs=0.005 * abs(expected).max())


@pytest.mark.slow
def test_irregularity_of_erri_gives_the_computed_levels() -> None:
    motion, load, _ = run(bogie(vehicle__speed_kmh=144.0, track__roughness=-40.0), 20.0)
    # 11.7 m/s^2 below 200 Hz and 1.2 kN below 20 Hz, in the frequency domain.
    assert lowpass(motion, 200.0, 102400.0).std(axis=1) == pytest.approx([11.7] * 4, rel=0.1)
    assert load.std(axis=0).mean() == pytest.approx(1200.0, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("wavelength", [100.0, 25.0, 10.0])
def test_rails_are_as_coherent_as_the_spectra_say(wavelength: float) -> None:
    assert coherence(100.0) == pytest.approx(0.92, abs=0.01)
    pair = irregularity(Track())
    assert pair is not None
    place = np.arange(0.0, 200.0 * PAGE, 0.5)
    left, right = pair[0].at(place) + pair[1].at(place), pair[0].at(place) - pair[1].at(place)
    from scipy.signal import csd, welch

    options = {"fs": 2.0, "nperseg": 4096}
    wavenumber, cross = csd(left, right, **options)
    power = welch(left, **options)[1] * welch(right, **options)[1]
    near = abs(wavenumber * wavelength - 1.0) < 0.15
    assert abs(cross[near].mean()) ** 2 / power[near].mean() == pytest.approx(coherence(wavelength), abs=0.06)


def test_a_random_function_has_its_spectrum_across_pages() -> None:
    value = Random("test", 0.05, lambda w: np.where(w < 10.0, 1e-6, 0.0)).at(np.arange(0.0, 40.0 * PAGE, 0.05))
    assert value.var() == pytest.approx(1e-5, rel=0.1)
    seams = np.abs(np.diff(value))[round(PAGE / 0.05) - 1 :: round(PAGE / 0.05)]
    assert seams.mean() < 1.5 * np.abs(np.diff(value)).mean()


@settings(deadline=None, max_examples=10)
@given(st.floats(100.0, 3000.0), st.floats(0.1, 50.0))
def test_the_track_is_the_same_in_any_order_and_direction(start: float, length: float) -> None:
    place = np.linspace(start, start + length, 500)
    forwards = Rails(Track(joint_spacing=25.0)).displacement(place, 1)
    other = Rails(Track(joint_spacing=25.0))
    other.displacement(np.array([5000.0]), 1)
    backwards = np.concatenate([other.displacement(part, 1) for part in np.array_split(place[::-1], 3)])[::-1]
    assert np.array_equal(forwards, backwards)


def test_a_joint_reaches_the_wheelsets_after_the_wheelbase() -> None:
    motion, _, events = run(smooth(vehicle__speed_kmh=120.0, track__joint_spacing=25.0), 1.0)
    first, second = [event.time for event in events if event.place == 1025.0 and event.box.endswith("left")]
    assert (second - first) * 51200.0 == pytest.approx(3932.2, abs=1.0)
    lag = round(2.56 / (120.0 / 3.6) * 102400.0)
    begin = round((first - 0.002) * 102400.0)
    ahead, behind = motion[0, begin : begin + 1024], motion[2, begin + lag - 40 : begin + lag + 1064]
    assert int(np.argmax(np.correlate(behind, ahead, "valid"))) - 40 == pytest.approx(0, abs=8)


@pytest.mark.parametrize(("kmh", "expected"), [(10.0, 0.24), (40.0, 0.46), (120.0, 0.46)])
def test_a_flat_strikes_with_the_jump_of_both_regimes(kmh: float, expected: float) -> None:
    assert jump(0.04, 1.0, 0.46, kmh / 3.6, 46e3) == pytest.approx(expected, abs=0.006)
    vehicle = smooth(vehicle__speed_kmh=kmh, axle_1__left__wheel__flat=0.04, axle_1__left__wheel__flat_worn=1.0)
    motion, _, events = run(vehicle, 1.5)
    turn = 2.0 * np.pi * 0.46 / (kmh / 3.6)
    assert {event.cause for event in events} == {"flat"}
    assert np.diff([event.time for event in events]) == pytest.approx([turn] * (len(events) - 1), rel=1e-6)
    peak = 20.0 * np.log10(abs(lowpass(motion, 1000.0, 102400.0)).max(axis=1))
    assert peak[1] - peak[0] == pytest.approx(-8.0, abs=2.0)
    assert peak[2] - peak[0] == pytest.approx(-13.0, abs=3.5)


def test_bearings_are_heard_with_the_levels_of_the_file() -> None:
    model = VehicleModel(smooth())
    plan = replace(model.plan(), motion=np.zeros((4, FRAME)))
    impulse, silence = np.zeros((4, FRAME, 2)), np.zeros((4, FRAME, 2))
    impulse[0, 0] = 1.0
    heard = np.concatenate([model.mix(impulse if k == 0 else silence, plan)[0] for k in range(200)], axis=1)[:, :, 1]
    frequency, power = np.fft.rfftfreq(heard.shape[1], 1.0 / model.rate), abs(np.fft.rfft(heard, axis=1)) ** 2
    aims = np.array([[-27, -13, -20, -25, -30], [-30, -24, -35, -40, -40], [-38, -24, -40, -45, -45]])
    for band in range(5):
        grid = np.geomspace(BANDS[band], BANDS[band + 1], 300)
        levels = [10.0 * np.log10(np.interp(grid, frequency, power[box]).mean()) for box in (1, 2, 3)]
        assert levels == pytest.approx(aims[:, band], abs=3.0)
    assert (np.flatnonzero(heard[1])[0], np.flatnonzero(heard[0])[0]) > (0, -1)
    assert not heard[1:, :TICK].any()


def test_paths_are_reciprocal_and_take_energy() -> None:
    paths = bearing_paths(bogie(), 102400.0)
    assert all(paths[a, b] is paths[b, a] for a, b in paths)
    with pytest.raises(Refusal, match="of a bearing's energy reaches other boxes"):
        bearing_paths(bogie(paths__same_side="-30, -6, -6, -6, -6", paths__diagonal="-6, -6, -6, -6, -6"), 102400.0)


def test_curve_wind_and_brakes_load_the_boxes() -> None:
    vehicle = bogie()
    rest = quasi_static(vehicle, 20.0, 0.0, 0.0, 0.0, 0.0)
    assert -rest[:, 1] == pytest.approx([vehicle.static_load] * 4)
    assert vehicle.static_load == pytest.approx(45.66e3, abs=10.0)
    curve = quasi_static(vehicle, 20.0, 1.0 / 400.0, 0.0, 0.0, 0.0) - rest  # 1 m/s^2 to the right
    wind = quasi_static(vehicle, 20.0, 0.0, 0.0, 40e3, 0.0) - rest
    brake = quasi_static(vehicle, 20.0, 0.0, 0.0, 0.0, 1.0) - rest
    assert -curve[:, 1] == pytest.approx([-5331.0, 5331.0] * 2, abs=1.0)
    assert -wind[:, 1] == pytest.approx([7500.0, -7500.0] * 2, abs=1.0)
    assert abs(brake[:, 0]) == pytest.approx([4654.0] * 4, abs=1.0)
    assert curve[:, 1].sum() == pytest.approx(0.0, abs=1.0)
    assert wind[:, 1].sum() == pytest.approx(0.0, abs=1.0)
    assert quasi_static(vehicle, 20.0, 1.0 / 400.0, 1.5 / 9.81, 0.0, 0.0) == pytest.approx(rest, abs=1e-6)


def test_a_millimetre_of_radius_drifts_by_a_turn_in_460() -> None:
    model = VehicleModel(smooth(axle_2__radius=0.459, vehicle__speed_kmh=120.0))
    speed = model.shaft_speed()
    turns = speed[0] / (speed[1] - speed[0])
    assert turns == pytest.approx(459.0, abs=2.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"track.corrugation": "0.05 left"}, "is not 2 numbers"),
        ({"track.corrugation": "0.05 1e-5 middle"}, "names no rail"),
        ({"track.crossings": "350"}, "is not a place with a rail"),
        ({"paths.diagonal": "-38, -24"}, "is not 5 numbers"),
        ({"paths.diagonal": "-38, -24, -40, -45, 3"}, "outside -120"),
        ({"axle_1.left.wheel.polygon": "3.5 1e-5"}, "whole order"),
    ],
)
def test_lists_are_refused_in_a_sentence(change: dict[str, str], message: str) -> None:
    with pytest.raises(Refusal, match=message):
        VehicleModel(read_vehicle("healthy_bogie", change))


def test_a_wheel_without_defects_and_smooth_rails_move_nothing() -> None:
    motion, load, events = run(smooth(), 0.1)
    assert not motion.any()
    assert np.ptp(load) == 0.0
    assert not events
    assert Wheel().flat == 0.0
