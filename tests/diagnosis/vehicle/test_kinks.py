"""Impacts that meet one wheelset after the other, from the times at which boxes measured them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from synthetic_bogie import DESCRIPTION, FREQUENCY, HALF, SECONDS

from dcrb_ros.diagnosis.vehicle.causes import Kinks, kinks_of, track
from dcrb_ros.diagnosis.vehicle.contact import Contact, Impact
from dcrb_ros.stream.vehicle_description import AxleDescription, VehicleDescription

TOLERANCE = 0.004
TURN = 1.0 / FREQUENCY
RADIUS = 2.0 * HALF / (2.0 * np.pi)
"""Radius of wheels that turn once within the distance of the wheelsets [m]."""
NEAR = replace(DESCRIPTION, axles=tuple(replace(axle, wheel_radius=RADIUS) for axle in DESCRIPTION.axles))
Times = Mapping[str, Sequence[float]]


def kinks(times: Times, description: VehicleDescription = NEAR, frequency: float = FREQUENCY) -> Kinks:
    """Return the kinks in the impacts of some boxes, whose wheelsets turn at a frequency [Hz]."""
    turns, wave = frequency * SECONDS, np.zeros(10)
    found = kinks_of(
        description,
        {
            box: Contact(0, 1.0, 1.0, 0.0, turns, 0.5 * turns, SECONDS, [Impact(at, 18.0) for at in sorted(impacts)], 6.0, wave, None)
            for box, impacts in times.items()
        },
        {},
        TOLERANCE,
    )
    assert found is not None
    return found


def test_impacts_in_every_turn_are_those_of_a_wheel_wherever_they_are_measured() -> None:
    """The distance of the wheelsets is the circumference; the box across counts only some of the impacts."""
    strikes = np.arange(0.2, SECONDS, TURN)
    times = {"axle_1/left": strikes, "axle_1/right": strikes[[3, 10, 11, 30, 31]] + 1e-3, "axle_2/left": strikes[::2], "axle_2/right": []}
    assert track(kinks(times)).verdict == "healthy"


@pytest.mark.parametrize("missed", [(5, 12, 13), (8,), (20, 22, 24)])
def test_the_wheel_is_known_by_impacts_of_which_some_are_too_faint(missed: tuple[int, ...]) -> None:
    strikes = np.delete(np.arange(0.2, SECONDS, TURN), missed)
    assert track(kinks({"axle_1/left": strikes, "axle_1/right": [], "axle_2/left": [], "axle_2/right": []})).verdict == "healthy"


def test_the_impacts_of_a_sliding_wheelset_are_at_angles_of_its_own() -> None:
    """The trailing wheelset turns by a tenth less, and once within the lag."""
    slower = replace(NEAR, axles=(replace(NEAR.axles[0], wheel_radius=0.9 * RADIUS), NEAR.axles[1]))
    strikes = np.arange(0.2, SECONDS, TURN / 0.9)
    sliding = Contact(0, 1.0, 1.0, 0.0, 54.0, 27.0, SECONDS, [], 6.0, np.zeros(10), None)
    rolling = replace(sliding, turns=60.0, first_turns=30.0, impacts=[Impact(at, 18.0) for at in strikes])
    found = kinks_of(slower, {"axle_1/left": rolling, "axle_2/left": sliding}, {}, TOLERANCE)
    assert track(found).verdict == "healthy"


@pytest.mark.parametrize("spacing", [0.43, 8.0 * TURN])
def test_joints_that_a_box_hears_from_both_wheelsets_are_the_tracks(spacing: float) -> None:
    """A turn apart, as the distance of the wheelsets is the circumference."""
    first = np.arange(0.2, SECONDS - 0.1, spacing)
    heard = np.concatenate([first, first + TURN])
    found = kinks(dict.fromkeys((box.name for box in NEAR.boxes), heard))
    assert found.first == pytest.approx(first)
    assert track(found).verdict == "joint"


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_joint_of_which_one_side_is_measured_is_no_crossing(side: str) -> None:
    found = kinks({f"axle_1/{side}": [0.5, 1.3], f"axle_2/{side}": [0.55, 1.35]})
    status = track(found)
    assert (status.verdict, status.reason.endswith("; only one side is measured")) == ("joint", True)
    assert np.isnan(found.louder).all()


@pytest.mark.parametrize(("frequency", "expected"), [(FREQUENCY, [0.0, 0.02, 0.05]), (-FREQUENCY, [0.0, 0.03, 0.05])])
def test_kinks_meet_every_wheelset_between_the_first_and_the_last(frequency: float, expected: list[float]) -> None:
    between = AxleDescription("axle_3", 0.2 * HALF, RADIUS)  # after 0.4 of the distance forward, 0.6 backwards
    three = VehicleDescription(DESCRIPTION.sampling_rate, (NEAR.axles[0], between, NEAR.axles[1]), NEAR.boxes)
    found = kinks({"axle_1/left": [0.5, 0.55], "axle_2/left": []}, three, frequency)
    assert found.times == pytest.approx(0.5 + np.array(expected))
