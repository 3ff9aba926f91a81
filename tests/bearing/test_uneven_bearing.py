"""A whole bearing on surfaces with heights: energy, lines, individuals, and changes while it runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from even_surfaces import EVEN

from dcrb_ros.core.contacts.heights import unpacked
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation

BENCH: dict[str, Any] = {"lubrication": {"law": "film_with_cages"}, "friction": {"convection": 0.7}, "contact": {"loss_time": 1e-5}}
RATE = 51200


def bench(surfaces: dict[str, Any] | None = None, **groups: Any) -> Simulation:
    return Simulation(Configuration.model_validate({**BENCH, "surfaces": EVEN | (surfaces or {}), **groups}))


def acceleration(simulation: Simulation, duration: float) -> npt.NDArray[np.float64]:
    return np.concatenate([block.clean for block in simulation.blocks(duration)]).astype(np.float64)


def test_the_shaft_pays_for_every_climb() -> None:
    """A spall over the whole length takes its work from the shaft; the paper's notch removes some 40 J/s that nobody accounts for."""
    spall = {"outer_1": {"kind": "spall", "width": 2e-3, "depth": 6e-5, "share": 1.0}}
    accounts = [block.energy for block in bench(faults=spall).blocks(0.5) if block.energy is not None]
    assert accounts[-1].loss > 5.0
    assert accounts[-1].notch == pytest.approx(0.0, abs=1e-3)
    # A blow that is under way holds some tenths of a joule.
    assert abs(np.median([account.residual for account in accounts[-10:]])) < 0.02 * accounts[-1].loss


def test_the_share_of_the_length_scales_the_blows() -> None:
    level = {}
    for share in (0.15, 0.3, 1.0):
        fault = {"outer_1": {"kind": "spall", "width": 2e-3, "depth": 6e-5, "share": share}}
        level[share] = float(acceleration(bench(faults=fault), 0.4)[5120:, 1].std())
    assert 1.5 < level[0.3] / level[0.15] < 3.0
    assert 2.0 < level[1.0] / level[0.3] < 6.0


def test_fluting_sounds_at_the_speed_of_the_surface_over_its_period() -> None:
    """5.76 m/s over 2 mm is 2.88 kHz."""
    fault = {"outer_1": {"kind": "fluting", "width": 0.04, "depth": 4e-6, "period": 2e-3}}
    signal = acceleration(bench(faults=fault), 1.0)[5120:, 1]
    power = np.abs(np.fft.rfft(signal * np.hanning(len(signal)))) ** 2
    frequency = np.fft.rfftfreq(len(signal), 1.0 / RATE)
    inside = (frequency > 2000.0) & (frequency < 4000.0)
    centre = float((frequency * power)[inside].sum() / power[inside].sum())
    assert centre == pytest.approx(5.76 / 2e-3, rel=0.05)


def test_a_thicker_roller_carries_more() -> None:
    """0.84 kN per micrometre of both contacts in series, of which the ring gives a part to the neighbours and the other row."""
    even, changes, thicknesses = bench()._state.inner_force, [], []
    for seed in range(1, 13):
        uneven = bench({"roller_spread": 4e-7, "seed": seed})
        diameters = 2e6 * unpacked(uneven._payload.surfaces.rollers[0, :, 0])[0].reshape(2, 16)  # [um]
        loaded = [(0, 0), (1, 0), (0, 1), (0, 15), (1, 1), (1, 15)]
        changes.append(float(uneven._state.inner_force[0, 0] - even[0, 0]))
        thicknesses.append(diameters[0, 0] - np.mean([diameters[at] for at in loaded]))
    slope = float(np.dot(changes, thicknesses) / np.dot(thicknesses, thicknesses))
    assert slope == pytest.approx(840.0, rel=0.25)


def test_the_same_bearing_has_the_same_samples_in_blocks_of_any_size() -> None:
    whole = acceleration(bench({"waviness": 1e-7, "seed": 5}), 0.06)
    parts = acceleration(bench({"waviness": 1e-7, "seed": 5}, publishing={"block_size": 100}), 0.06)
    other = acceleration(bench({"waviness": 1e-7, "seed": 6}), 0.06)
    count = min(len(whole), len(parts))
    assert np.array_equal(whole[:count], parts[:count])
    assert not np.array_equal(whole, other)


def test_a_defect_appears_and_grows_while_the_bearing_turns() -> None:
    simulation = bench()
    before = acceleration(simulation, 0.2)
    simulation.change({"faults.outer_1.kind": "spall", "faults.outer_1.width": 1e-3, "faults.outer_1.depth": 6e-5})
    small = acceleration(simulation, 0.2)
    simulation.change({"faults.outer_1.width": 3e-3})
    large = acceleration(simulation, 0.2)
    assert before[5120:, 1].std() < small[:, 1].std() < large[:, 1].std()
    assert np.isfinite(large).all()


@pytest.mark.parametrize("speed", [0.0, -125.664, 0.5])
def test_any_speed_is_stable(speed: float) -> None:
    fault = {"outer_1": {"kind": "spall", "width": 2e-3, "depth": 6e-5}, "roller_1": {"width": 2e-3}}
    simulation = bench({"waviness": 1e-7}, faults=fault, operating={"speed": speed})
    assert np.abs(acceleration(simulation, 0.1)).max() < 2000.0
