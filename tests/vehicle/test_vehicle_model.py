"""The vehicle around its bearings: numbers of the frequency-domain model, published laws, and causality, reciprocity and determinism."""

from __future__ import annotations

import itertools
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d
from scipy.signal import butter, sosfiltfilt

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.vehicle.description import Track, Vehicle, Wheel
from dcrb_ros.vehicle.file import read_vehicle, vehicle_of
from dcrb_ros.vehicle.frame import FRAME, TICK, Plan, TrackEvent
from dcrb_ros.vehicle.loads import quasi_static
from dcrb_ros.vehicle.model import AHEAD, BEFORE, VehicleModel, tick_weights
from dcrb_ros.vehicle.paths import BANDS, Paths, bearing_paths, contact_paths
from dcrb_ros.vehicle.structure import Structure, wheelset
from dcrb_ros.vehicle.track import IRREGULARITY, PAGE, Rails, Random, irregularity
from dcrb_ros.vehicle.wheels import WheelSurface, jump, positions

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


def test_the_layers_together_have_the_levels_of_the_frequency_domain_from_100_to_400_hz() -> None:
    vehicle, frequency = smooth(), np.linspace(100.0, 400.0, 151)
    structure, z = Structure(vehicle), np.exp(-2j * np.pi * frequency / 102400.0)
    motion = np.array([structure.response(f)[:, 0] for f in frequency])
    grids = [np.geomspace(low, high, 40) for low, high in itertools.pairwise(BANDS)]
    paths = contact_paths(vehicle, 102400.0, [np.sqrt(np.mean([abs(structure.response(f)[0, 0]) ** 2 for f in grid])) for grid in grids])
    for box in range(4):
        for (gain, a1, a2), delay in zip(paths[0, box].sections, paths[0, box].delays, strict=True):
            motion[:, box] += gain * (1.0 - z**2) / (1.0 - a1 * z - a2 * z**2) * z**delay
    # Acceleration by a displacement of constant amplitude, over that at 100 Hz, from an endless rail in the frequency domain. The drawn
    # paths to the other wheelset have one level from 200 to 500 Hz.
    level = 10.0 * np.log10(np.mean(np.square(abs(motion) * (frequency[:, None] / 100.0) ** 2), axis=0))
    assert level[:2] == pytest.approx([3.3, -0.8], abs=1.5)
    assert level[2:] == pytest.approx([-5.9, -11.4], abs=9.0)


@pytest.mark.parametrize("x", [None, 1.28, 0.0])
def test_the_modes_have_the_response_of_the_structure(x: float | None) -> None:
    """Of a bogie, and of a single wheelset, which does not pitch the frame from its middle."""
    vehicle = smooth() if x is None else vehicle_of({"axle_1": {"x": x, "left": {}, "right": {}}}, "test")
    structure, interval = Structure(vehicle), TICK / 102400.0
    growth, before, after, read, direct = structure.modal(interval)
    for frequency in (5.0, 48.0, 162.0, 400.0):
        # The response of the recursion to exp(j w t), sampled; inputs between ticks are straight lines, which matters above.
        z = np.exp(2j * np.pi * frequency * interval)
        state = (before + after * z) / (z - growth)[:, None]
        expected = -((2.0 * np.pi * frequency) ** 2) * structure.response(frequency)
        # Relative to each input's own effect: inputs are metres and newtons.
        assert (abs((read @ state + direct)[: len(expected)] - expected).max(axis=0) < 0.01 * abs(expected).max(axis=0)).all()


@pytest.mark.slow
def test_irregularity_of_erri_gives_the_computed_levels() -> None:
    motion, load, _ = run(bogie(vehicle__speed_kmh=144.0, track__roughness=-40.0), 20.0)
    # 11.7 m/s^2 below 200 Hz and 1.2 kN below 20 Hz, in the frequency domain.
    assert lowpass(motion, 200.0, 102400.0).std(axis=1) == pytest.approx([11.7] * 4, rel=0.1)
    assert load.std(axis=0).mean() == pytest.approx(1200.0, rel=0.1)


def coherence(wavelength: float) -> float:
    """Return the coherence of left and right irregularity of ERRI at a wavelength [m], ((S_v - S_x) / (S_v + S_x))^2."""
    w, (_, (_, _, s)) = 2.0 * np.pi / wavelength, IRREGULARITY["erri_low"]
    cross = w**2 / (w**2 + s**2)
    return float((1.0 - cross) / (1.0 + cross)) ** 2


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


def test_rails_share_the_vertical_irregularity_and_lean_to_either_side() -> None:
    track = Track(roughness=-40.0)
    pair, place = irregularity(track), np.linspace(0.0, 300.0, 1000)
    assert pair is not None
    vertical, cross = (part.at(place) for part in pair)
    left, right = (Rails(track).displacements(place, (side,))[side] for side in (1, -1))
    assert 0.5 * (left + right) == pytest.approx(vertical, abs=1e-12)
    assert 0.5 * (left - right) == pytest.approx(cross, abs=1e-12)


def test_a_random_function_has_its_spectrum_across_pages() -> None:
    value = Random("test", 0.05, lambda w: np.where(w < 10.0, 1e-6, 0.0)).at(np.arange(0.0, 40.0 * PAGE, 0.05))
    assert value.var() == pytest.approx(1e-5, rel=0.1)
    seams = np.abs(np.diff(value))[round(PAGE / 0.05) - 1 :: round(PAGE / 0.05)]
    assert seams.mean() < 1.5 * np.abs(np.diff(value)).mean()


@settings(deadline=None, max_examples=10)
@given(st.floats(100.0, 3000.0), st.floats(0.1, 50.0))
def test_the_track_is_the_same_in_any_order_and_direction(start: float, length: float) -> None:
    place = np.linspace(start, start + length, 500)
    forwards = Rails(Track(joint_spacing=25.0)).displacements(place, (1,))[1]
    other = Rails(Track(joint_spacing=25.0))
    other.displacements(np.array([5000.0]), (1,))
    backwards = np.concatenate([other.displacements(part, (1,))[1] for part in np.array_split(place[::-1], 3)])[::-1]
    assert np.array_equal(forwards, backwards)


def test_the_curvature_of_a_rail_is_that_of_its_roughness_and_has_shorter_waves() -> None:
    rails, step = Rails(Track(spectrum="none")), 5e-4
    place = np.arange(300.0, 310.0, step)
    bent = np.gradient(np.gradient(rails.displacements(place, (1,))[1], step), step)
    curvature = rails.curvature(place, 1)
    smoothed = [gaussian_filter1d(values, 60)[500:-500] for values in (bent, curvature)]
    assert np.corrcoef(*smoothed)[0, 1] > 0.999
    assert smoothed[0].std() == pytest.approx(smoothed[1].std(), rel=0.01)


def test_rails_are_as_rough_as_wheels_down_to_waves_of_3_mm() -> None:
    vehicle = bogie(track__spectrum="none")
    wheel, radius = WheelSurface(vehicle, vehicle.boxes[0]), 0.46
    place = np.linspace(0.0, 20.0, 1 << 16, endpoint=False)
    both = [Rails(vehicle.track).curvature(place, 1), wheel.curvature(positions(place / radius))]
    wavenumber, hann = np.fft.rfftfreq(len(place), place[1]), np.hanning(len(place))
    power = [abs(np.fft.rfft(values * hann)) ** 2 for values in both]
    for longest, shortest in ((0.02, 0.01), (0.01, 0.0056), (0.0056, 0.003)):
        band = (wavenumber > 1.0 / longest) & (wavenumber < 1.0 / shortest)
        assert 10.0 * np.log10(power[0][band].sum() / power[1][band].sum()) == pytest.approx(0.0, abs=1.5)


def test_a_joint_reaches_the_wheelsets_after_the_wheelbase() -> None:
    motion, _, events = run(smooth(vehicle__speed_kmh=120.0, track__joint_spacing=25.0), 1.0)
    first, second = [event.time for event in events if event.place == 25.0 and event.box.endswith("left")]
    assert (second - first) * 51200.0 == pytest.approx(3932.2, abs=1.0)
    lag = round(2.56 / (120.0 / 3.6) * 102400.0)
    begin = round((first - 0.002) * 102400.0)
    ahead, behind = motion[0, begin : begin + 1024], motion[2, begin + lag - 40 : begin + lag + 1064]
    assert int(np.argmax(np.correlate(behind, ahead, "valid"))) - 40 == pytest.approx(0, abs=8)


def test_a_joint_reaches_a_turned_bogie_in_the_other_order() -> None:
    turned = smooth(vehicle__speed_kmh=120.0, track__joint_spacing=25.0, axle_1__x=-1.28, axle_2__x=1.28)
    times = {event.box: event.time for event in run(turned, 1.0)[2] if event.place == 25.0}
    assert (times["axle_2.left"] - times["axle_1.left"]) * 51200.0 == pytest.approx(-3932.2, abs=1.0)


def test_a_crossing_is_met_on_its_rail_alone_where_the_file_says() -> None:
    _, _, events = run(
        smooth(vehicle__speed_kmh=120.0, track__crossings="12 left", track__joint_spacing=10.0, track__joint_rail="right"), 0.6
    )
    crossing = [event for event in events if event.cause == "crossing"]
    assert [(event.box, event.place) for event in crossing] == [("axle_1.left", 12.0), ("axle_2.left", 12.0)]
    assert [event.time * 120.0 / 3.6 for event in crossing] == pytest.approx([12.0 - 1.28, 12.0 + 1.28], abs=1e-3)
    joints = [event for event in events if event.cause == "joint"]
    assert {event.box for event in joints} == {"axle_1.right", "axle_2.right"}
    assert [event.place for event in joints if event.box == "axle_2.right"] == [0.0, 10.0]


def test_a_kink_between_two_frames_is_that_within_a_frame() -> None:
    """A kink 0.4 steps before the end of a frame, and one some ticks before it: the same motion, later."""
    speed, rate, later = 30.0, 102400.0, 3 * TICK

    def motion(step: float) -> np.ndarray:
        place = 1.28 + speed * step / rate  # met by the leading wheelset at this step
        vehicle = smooth(vehicle__speed_kmh=3.6 * speed, track__crossings=f"{place!r} left", track__joint_angle=0.01)
        return run(vehicle, 6 * FRAME / rate)[0][0]

    across = motion(4 * FRAME - 0.4)
    within = motion(4 * FRAME - 0.4 - later)
    assert abs(across).max() > 1.0
    assert across[later:] == pytest.approx(within[:-later], abs=1e-6 * float(abs(across).max()))


def test_classes_of_the_fra_lie_in_order_around_erri() -> None:
    def density(name: str, wavelength: float) -> float:
        pair = irregularity(Track(spectrum=name))  # type: ignore[arg-type]
        assert pair is not None
        value = pair[0].at(np.arange(0.0, 60.0 * PAGE, 0.25))
        power = np.abs(np.fft.rfft(value)) ** 2
        number = np.fft.rfftfreq(len(value), 0.25) * wavelength
        return float(power[(number > 0.8) & (number < 1.25)].mean())

    # A_v falls from class 1 to class 6, which lies between ERRI low and high: k A_v is 8.5e-7 m rad.
    names = ["fra_1", "fra_2", "fra_3", "fra_4", "fra_5", "erri_high", "fra_6", "erri_low"]
    levels = [density(name, 20.0) for name in names]
    assert levels == sorted(levels, reverse=True)
    assert 10.0 * np.log10(levels[0] / levels[6]) == pytest.approx(10.0 * np.log10(1.2107 / 0.0339), abs=0.5)


def test_an_unbalance_shakes_its_wheelset_once_per_revolution() -> None:
    speed = 216.0 / 3.6
    motion, _, events = run(smooth(vehicle__speed_kmh=216.0, axle_1__left__wheel__unbalance=0.075), 2.0)
    assert not events
    turn = speed / 0.46
    time = np.arange(motion.shape[1]) / 102400.0
    whole = time < int(2.0 * turn / (2.0 * np.pi)) * 2.0 * np.pi / turn
    line = 2.0 * (motion[:, whole] * np.exp(-1j * turn * time[whole])).mean(axis=1)
    structure = Structure(smooth())
    column = 2 * 4 + 2  # the wheel of axle_1.left, after contacts, bearings and gears
    expected = abs(structure.response(turn / (2.0 * np.pi))[:, column]) * turn**2 * 0.075 * turn**2
    assert abs(line) == pytest.approx(expected, rel=0.01)
    residual = motion[:, whole] - np.real(line[:, None] * np.exp(1j * turn * time[whole]))
    assert residual.std() < 0.01 * motion[0].std()


def test_a_gear_in_the_middle_of_the_axle_reaches_both_boxes_alike() -> None:
    middle, _, _ = run(smooth(axle_1__gear__teeth=87, axle_1__gear__position=0.0), 0.3)
    beside, _, _ = run(smooth(axle_1__gear__teeth=87, axle_1__gear__position=0.35), 0.3)
    assert middle[0] == pytest.approx(middle[1], rel=1e-6, abs=1e-6 * abs(middle).max())
    assert abs(20.0 * np.log10(beside[0].std() / beside[1].std())) > 1.0


def test_a_motor_has_lines_at_its_supply_and_its_rotor() -> None:
    motor = {
        "axle_1.gear.teeth": 87,
        "axle_1.gear.level": 0.0,
        "axle_1.motor.level": 2.0,
        "axle_1.motor.slip": 0.02,
        "vehicle.speed_kmh": 144.0,
    }
    motion, _, _ = run(read_vehicle("healthy_bogie", SMOOTH | motor), 4.0)
    frequency = np.fft.rfftfreq(motion.shape[1], 1.0 / 102400.0)
    power = abs(np.fft.rfft(motion[0] * np.hanning(motion.shape[1]))) ** 2
    turn = 40.0 / (2.0 * np.pi * 0.46)
    lines = []
    for _ in range(2):
        lines.append(frequency[int(np.argmax(power))])
        power[abs(frequency - lines[-1]) < 3.0] = 0.0
    # 2 p i / (1 - s) and i orders of the axle, with two pairs of poles and a ratio of 4.14.
    assert sorted(lines) == pytest.approx([4.14 * turn, 2.0 * 2 * 4.14 / 0.98 * turn], abs=0.3)


def test_a_tone_has_no_images_at_the_rate_of_the_ticks() -> None:
    vehicle = smooth(track__corrugation="0.03 10e-6 left", vehicle__speed_kmh=100.0, axle_1__gear__teeth=0)
    motion, _, _ = run(vehicle, 0.5)
    window = np.hanning(motion.shape[1])
    spectrum = np.abs(np.fft.rfft(motion[0] * window))
    step = VehicleModel(vehicle).rate / motion.shape[1]

    def level(frequency: float) -> float:
        middle = round(frequency / step)
        return 20.0 * np.log10(spectrum[middle - 3 : middle + 4].max())

    tone, ticks = 100.0 / 3.6 / 0.03, VehicleModel(vehicle).rate / TICK
    # Straight lines between the ticks give -44 dB.
    assert max(level(ticks - tone), level(ticks + tone)) < level(tone) - 75.0


def test_images_of_tones_up_to_2_khz_are_75_db_below_them() -> None:
    rate, weights = 102400.0, tick_weights()
    late = np.arange(TICK)[:, None] - TICK * np.arange(-BEFORE, AHEAD + 1)  # steps from each tick to the step that it enters

    def gain(frequency: float) -> float:
        return float(abs((weights * np.exp(-2j * np.pi * frequency / rate * late)).sum()) / TICK)

    for tone in np.arange(10.0, 2001.0, 10.0):
        assert gain(tone) == pytest.approx(1.0, abs=1e-3)
        images = [gain(number * rate / TICK + side * tone) for number in range(1, TICK // 2 + 1) for side in (-1.0, 1.0)]
        assert 20.0 * np.log10(max(images) / gain(tone)) < -75.0


def test_a_slide_slows_the_wheelset_and_the_truth_has_time_and_place() -> None:
    model = VehicleModel(smooth(vehicle__speed_kmh=72.0))
    free = model.shaft_speed()
    plans = [model.plan() for _ in range(10)]
    model.slides[1] = 0.2
    plans += [model.plan() for _ in range(100)]
    model.slides[1] = 0.0
    plans += [model.plan() for _ in range(100)]
    speeds = np.array([plan.shaft_speed for plan in plans])
    assert (speeds[:, 0] == free[0]).all()
    assert speeds[:, 1].min() == pytest.approx(0.8 * free[1], rel=1e-9)
    assert speeds[-1, 1] == pytest.approx(free[1], rel=1e-12)
    # The circumference slows by 10 m/s^2.
    assert np.diff(speeds[:, 1]).min() * 0.46 / 0.005 == pytest.approx(-10.0, rel=1e-6)
    begin, end = [event for plan in plans for event in plan.events]
    assert (begin.cause, begin.box, end.cause, end.box) == ("slide", "axle_2", "slide_end", "axle_2")
    assert (begin.time, end.time) == pytest.approx((0.055, 0.555), abs=1e-9)
    assert begin.place == pytest.approx(20.0 * begin.time - 1.28, abs=1e-6)
    assert begin.jump == pytest.approx(4.0)
    assert min(plan.creep[1] for plan in plans) == pytest.approx(-0.2)


def test_a_slide_that_grows_begins_and_ends_once() -> None:
    model = VehicleModel(smooth(vehicle__speed_kmh=72.0))
    events = []
    for slide in (0.0, *np.linspace(0.01, 0.2, 20), *np.linspace(0.19, 0.0, 20)):
        model.slides[1] = slide
        events += model.plan().events
    events += model.plan().events
    assert [(event.cause, event.jump) for event in events] == [("slide", pytest.approx(0.2)), ("slide_end", pytest.approx(4.0))]


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


def test_a_wheel_that_changes_acts_on_structure_paths_and_events_from_the_same_frame_on() -> None:
    time = [event.time for event in run(smooth(axle_1__left__wheel__flat=0.04), 0.2)[2]][1]
    struck = int(time * 102400.0) // FRAME

    def strike(before: int) -> Plan:
        """Return the frame of the strike, with the flat given before another frame is planned."""
        model = VehicleModel(smooth())
        for number in range(struck + 1):
            if number == before:
                model.wear(0, Wheel(flat=0.04))
            plan = model.plan()
        return plan

    late = strike(struck)  # the frame was rolled before
    assert not late.events
    assert not late.motion[:, : FRAME - AHEAD * TICK].any()
    assert [event.time for event in strike(struck - 1).events] == pytest.approx([time])


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
    assert not heard[1:, :TICK].any()
    # The paths alone: nothing is faster than 3000 m/s, over 2 m of the axle and 2.56 m of the rail.
    paths = Paths(bearing_paths(model.vehicle, model.rate), 4, 1)
    source, target = np.zeros((4, 1, FRAME)), np.zeros((4, 1, FRAME))
    source[0, 0, 0] = 1.0
    paths.add(source, target)
    arrival = np.array([np.flatnonzero(target[box, 0])[0] for box in (1, 2, 3)]) / model.rate
    assert arrival == pytest.approx(np.array([2.0, 2.56, 4.56]) / 3000.0, abs=0.1e-3)


def test_contacts_are_heard_with_the_levels_of_the_structure_and_fall_above_it() -> None:
    vehicle, rate = smooth(), 102400.0
    paths = contact_paths(vehicle, rate, (0.2, 0.5, 9.0, 9.0, 9.0))

    def levels(box: int, bands: range) -> list[float]:
        grids = [np.geomspace(BANDS[band], BANDS[band + 1], 400) for band in bands]
        return [10.0 * float(np.log10(paths[0, box].response(grid, rate).mean())) for grid in grids]

    # 0.2 and 0.5 are -14.0 and -6.0 dB; the middles of the next bands are 2 and 4.5 times that of the second.
    fall = [40.0 * float(np.log10(ratio)) for ratio in (2.0, 20.0**0.5)]
    assert levels(0, range(2, 4)) == pytest.approx([-6.0 - fall[0], -6.0 - fall[1]], abs=0.5)
    assert levels(2, range(2)) == pytest.approx([-14.0 - 7.0, -6.0 - 8.0], abs=0.5)
    assert levels(1, range(2, 3)) == pytest.approx([-6.0 - fall[0] - 11.0], abs=0.5)


def test_paths_are_reciprocal_and_take_energy() -> None:
    paths = bearing_paths(bogie(), 102400.0)
    assert all(paths[a, b] is paths[b, a] for a, b in paths)
    with pytest.raises(Refusal, match="of a bearing's energy reaches other boxes"):
        bearing_paths(bogie(paths__same_side="-30, -6, -6, -6, -6", paths__diagonal="-6, -6, -6, -6, -6"), 102400.0)


@pytest.mark.parametrize("seed", range(4))
def test_drawn_paths_that_carry_more_energy_than_a_bearing_has_are_refused(seed: int) -> None:
    loud = {
        f"paths.{kind}": ", ".join([level] * 5) for kind, level in (("same_wheelset", "-6"), ("same_side", "-9.5"), ("diagonal", "-10"))
    }
    message = (
        r"third octave at \d+ Hz, 1\.\d\d of the energy of the bearing of axle_\d\.\w+ .*: lower the levels, or give another paths\.seed$"
    )
    with pytest.raises(Refusal, match=message):
        bearing_paths(read_vehicle("healthy_bogie", {**loud, "paths.seed": seed}), 102400.0)


def test_drawn_paths_keep_their_bits() -> None:
    path = bearing_paths(bogie(paths__seed=3), 102400.0)[0, 1]
    # Of commit 584becef, which evaluated every resonance in each of the 60 steps.
    assert path.sections[[0, -1], 0].tolist() == [-6.526953279300049e-05, -0.0016806971566057133]
    assert path.delays[[0, -1]].tolist() == [165.0, 68.0]


def test_a_second_vehicle_of_a_rate_needs_no_design_of_filters() -> None:
    VehicleModel(bogie())
    code = (
        "import sys; from dcrb_ros.vehicle.file import read_vehicle; from dcrb_ros.vehicle.model import VehicleModel; "
        "VehicleModel(read_vehicle('healthy_bogie')); sys.exit('scipy.signal' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


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
    # Inertia presses forward, against X; 547 N come from the other bogie, and 1.8 kN from the trailing wheelset.
    assert brake[:, 0] == pytest.approx([-4654.0] * 4, abs=1.0)
    assert -brake[:, 1] == pytest.approx([547.0 + 1800.0] * 2 + [547.0 - 1800.0] * 2, abs=1.0)
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
        ({"track.corrugation": "  "}, "names no rail"),
        ({"track.crossings": "1e999 left"}, "is not a place with a rail"),
        ({"track.crossings": "350"}, "is not a place with a rail"),
        ({"paths.diagonal": "-38, -24"}, "is not 5 numbers"),
        ({"paths.diagonal": "-38, -24, -40, -45, 3"}, "outside -120"),
        ({"axle_1.left.wheel.polygon": "3.5 1e-5"}, "whole order"),
        ({"axle_1.left.wheel.polygon": "3 1e-5, 4"}, "is not 2 numbers"),
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
