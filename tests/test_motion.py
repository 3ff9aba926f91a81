"""The moving bearing against physics.md section 5 and Fan et al. 2025, in the paper's `revolute` mode."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from conftest import PAPER_SPEED, simulated
from scipy import signal

from dcrb_ros.configuration import Configuration
from dcrb_ros.kinematics import characteristic_orders
from dcrb_ros.model import cage_speed, degrees_of_freedom

ROLLERS = slice(0, 32)
SETTLED = 200  # states of 1 kHz left out at the start
WEIGHT = 7.316 * 9.81  # inner ring, Table 1


def test_degrees_of_freedom() -> None:
    # Fan et al. 2025, section 2.2.2; a bar in either row frees four rollers, the paper counts two
    for bars, free in (("", 10), ("row1/bar15", 14), ("row1/bar15, row2/bar15", 18)):
        assert degrees_of_freedom(Configuration.model_validate({"faults": {"broken_bars": bars}})) == free + 32
    assert degrees_of_freedom(Configuration.model_validate({"cage": {"joint": "pocket"}})) == 10 + 3 * 32


def test_total_force_on_the_inner_ring() -> None:
    force = np.array([states.inner_ring_force[1] for states in simulated(2.0).states[SETTLED:]])
    assert force.mean() == pytest.approx(100e3 + WEIGHT, rel=1e-3)  # Fan et al. 2025, Fig. 9a
    assert force.std() < 0.01 * force.mean()


def test_largest_roller_force_and_loading_zone() -> None:
    run = simulated(2.0)
    force, azimuth = run.series("inner_force")[SETTLED:, ROLLERS], run.series("azimuth")[SETTLED:, ROLLERS]
    assert 28.5e3 <= force.max() <= 31.5e3  # about 30 kN at 0 deg, Fig. 9a
    assert abs(math.degrees(azimuth.ravel()[force.argmax()])) < 5.0
    bearing = np.degrees(azimuth[force > 50.0])
    assert 26.0 <= -bearing.min() <= 34.0  # loading zone of +-30 deg, Fig. 9a
    assert 26.0 <= bearing.max() <= 34.0


def test_cage_speed() -> None:
    run = simulated(2.0)
    speed = run.series("speed")[SETTLED:, 32:34]
    assert speed.mean(axis=0) == pytest.approx(cage_speed(run.configuration, PAPER_SPEED), rel=5e-4)  # physics.md section 5
    assert speed.mean() == pytest.approx(52.4, rel=2e-3)  # the paper prints 52.4 rad/s


def test_roller_spin_in_the_loading_zone() -> None:
    run = simulated(2.0)
    force, spin = run.series("inner_force")[SETTLED:, ROLLERS], run.series("speed")[SETTLED:, ROLLERS]
    loaded = spin[force > 5e3].mean()
    assert loaded == pytest.approx(-328.1, rel=0.015)  # physics.md section 5, absolute
    assert loaded - run.series("speed")[SETTLED:, 32:34].mean() == pytest.approx(-380.5, rel=0.015)  # Fig. 8, against the cage


def test_friction_stays_inside_its_cone() -> None:
    run = simulated(2.0)
    force, friction = run.series("inner_force")[:, ROLLERS], run.series("friction")[:, ROLLERS]
    assert np.all(np.abs(friction) <= 0.06 * force * 1.02 + 1e-9)


def test_slip_small_in_the_zone_large_outside() -> None:
    run = simulated(2.0)
    azimuth, slip = run.series("azimuth")[SETTLED:, ROLLERS], np.abs(run.series("slip")[SETTLED:, ROLLERS])
    inside = slip[np.abs(azimuth) < math.radians(20.0)].mean()
    outside = slip[np.abs(azimuth) > math.radians(40.0)].mean()
    assert inside < 1e-3  # physics.md section 5; Fig. 9c: about 0
    assert outside > 10.0 * inside


def test_cold_start_settles_like_figure_8() -> None:
    run = simulated(0.3, start="cold")
    spin = run.series("speed")[:, ROLLERS].mean(axis=1)
    times = np.array([states.time_ns for states in run.states]) * 1e-9
    final = spin[-50:].mean()
    settled = times[np.flatnonzero(np.abs(spin / final - 1.0) > 0.02)[-1]]
    assert spin[0] > 0.5 * final  # the spins are negative: still far from rolling
    assert 0.06 <= settled <= 0.13  # about 0.1 s, Fig. 8


def envelope_spectrum(acceleration: npt.NDArray[np.float64], rate: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return frequencies [Hz] and amplitudes of the envelope of the raw vertical signal, as in the paper's Fig. 11."""
    envelope = np.abs(signal.hilbert(signal.detrend(acceleration)))
    window = signal.windows.hann(len(envelope))
    spectrum = np.abs(np.fft.rfft((envelope - envelope.mean()) * window)) * 2.0 / window.sum()
    return np.fft.rfftfreq(len(envelope), 1.0 / rate), spectrum


def line(frequency: npt.NDArray[np.float64], spectrum: npt.NDArray[np.float64], near: float, width: float) -> tuple[float, float, float]:
    """Return frequency, amplitude and floor (median within 8 Hz) of the largest line within ``width`` of ``near``."""
    inside = np.flatnonzero(np.abs(frequency - near) <= width)
    best = inside[spectrum[inside].argmax()]
    floor = float(np.median(spectrum[np.abs(frequency - frequency[best]) < 8.0]))
    return float(frequency[best]), float(spectrum[best]), floor


def test_line_of_an_outer_defect() -> None:
    run = simulated(3.0, fault="outer_1", state_rate=100)
    frequency, spectrum = envelope_spectrum(run.clean[10240:, 1], 51200)
    cage = run.series("speed")[20:, 32:34].mean() / (2.0 * math.pi)
    strongest = frequency[(frequency > 20.0)][spectrum[frequency > 20.0].argmax()]
    found, _, _ = line(frequency, spectrum, 16.0 * cage, 10.0)
    assert found == pytest.approx(16.0 * cage, rel=0.01)  # physics.md section 5
    assert found == pytest.approx(133.0, rel=0.01)  # Fan et al. 2025, Fig. 11c
    assert strongest / found == pytest.approx(round(strongest / found), abs=0.02)


def test_lines_of_an_inner_defect() -> None:
    run = simulated(3.0, fault="inner_1", state_rate=100)
    frequency, spectrum = envelope_spectrum(run.clean[10240:, 1], 51200)
    cage = run.series("speed")[20:, 32:34].mean() / (2.0 * math.pi)
    shaft = PAPER_SPEED / (2.0 * math.pi)
    expected = 16.0 * (shaft - cage)
    found, _, _ = line(frequency, spectrum, expected, 5.0)
    pairs = []
    assert found == pytest.approx(expected, rel=0.01)
    assert found == pytest.approx(184.0, rel=0.01)  # Fan et al. 2025, Fig. 11b
    for pair in (1, 2, 3, 4):
        sides = [line(frequency, spectrum, found + side * shaft, 1.0) for side in (-pair, pair)]
        assert all(20.0 * math.log10(height / floor) > 10.0 for _, height, floor in sides)  # at the shaft frequency, Fig. 11b
        pairs.append(sum(height for _, height, _ in sides))
    assert pairs == sorted(pairs, reverse=True)  # "decreasing in magnitude progressively", section 3.2


def test_inner_bursts_come_from_the_loading_zone() -> None:
    # A burst of the defect is a jump of force on the roller above it, so the defect's own azimuth tells where it happens.
    run = simulated(3.0, fault="inner_1", state_rate=100)
    y = run.clean[10240:, 1]
    healthy = simulated(2.0).clean[10240:, 1]
    times = (np.flatnonzero(np.abs(y) > 8.0 * np.abs(healthy).max()) + 10240) / 51200
    azimuth = np.angle(np.exp(1j * PAPER_SPEED * times))
    assert len(times) > 100
    assert np.mean(np.abs(azimuth) < math.radians(35.0)) >= 0.9  # physics.md section 5


def test_severity_grows_with_width() -> None:
    # Up to the width at which the notch is as deep as the loaded roller is pressed in and relieves it wholly.
    rms = [simulated(1.0, fault="outer_1", width=width, state_rate=100).clean[10240:, 1].std() for width in (0.0005, 0.001, 0.0015, 0.002)]
    assert np.all(np.diff(rms) > 0.0)


def test_healthy_line_lies_far_below_a_defect() -> None:
    orders = characteristic_orders(Configuration().bearing)
    near = orders.bpfo * PAPER_SPEED / (2.0 * math.pi)

    def level(fault: str) -> float:
        y = simulated(3.0, fault=fault, state_rate=100).clean[10240:, 1]
        frequency, spectrum = envelope_spectrum(y, 51200)
        return line(frequency, spectrum, near, 3.0)[1]

    assert 20.0 * math.log10(level("outer_1") / level("")) >= 25.0  # physics.md section 5
