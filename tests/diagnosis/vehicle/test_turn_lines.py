"""Polygons and gears in synthetic bogies, and the spectrum over the angle of a wheelset."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest
from synthetic_bearing import RATE, TURN
from synthetic_bogie import BOXES, DESCRIPTION, SECONDS, Boxes, bogie, diagnosed, last, verdicts

from dcrb_ros.diagnosis.segments import Segmenter
from dcrb_ros.diagnosis.vehicle.detector import VehicleDetector
from dcrb_ros.diagnosis.vehicle.turn_spectrum import TurnSpectrum
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import Status

HOP = RATE // 2


def statuses(signals: Boxes, description: VehicleDescription = DESCRIPTION) -> dict[str, Status]:
    """Return the last status of each part."""
    return dict(diagnosed(signals, detector=VehicleDetector(description))[-1].statuses)


def with_lines(orders: npt.ArrayLike, amplitude: float, signals: Boxes) -> Boxes:
    """Return signals in which all boxes have lines of one amplitude at orders of the wheelset, at random phases."""
    changed = {}
    for number, (name, (acceleration, angle)) in enumerate(signals.items()):
        phases = np.random.default_rng(number).uniform(0.0, TURN, np.size(orders))
        turning = np.unwrap(angle.astype(np.float64))
        louder = acceleration.copy()
        for order, phase in zip(np.atleast_1d(orders), phases, strict=True):
            louder[:, 1] += (amplitude * np.cos(order * turning + phase)).astype(np.float32)
        changed[name] = louder, angle
    return changed


@pytest.mark.parametrize(("box", "order"), [(BOXES[0], 3), (BOXES[1], 18), (BOXES[2], 24), (BOXES[3], 9)])
def test_a_polygon_is_its_wheels(box: str, order: int) -> None:
    found = statuses(bogie(polygons={box: (order, 3.0)}))
    assert {name for name, status in found.items() if status.verdict != "healthy"} == {f"{box}/wheel"}
    assert found[f"{box}/wheel"].verdict == "polygon"
    assert f"order {order} of the wheel" in found[f"{box}/wheel"].reason


def test_a_quiet_sensor_keeps_its_polygon() -> None:
    assert verdicts(last(bogie(polygons={"axle_1/left": (18, 3.0)}, gains={"axle_1/left": 0.2})), "wheel") == {"axle_1/left": "polygon"}


def test_an_order_that_two_boxes_measure_alike_is_no_polygon() -> None:
    signals = bogie(polygons={"axle_1/left": (18, 3.0)})
    signals["axle_1/right"] = signals["axle_1/left"]
    found = statuses(signals)["axle_1/left/wheel"]
    assert found.verdict == "healthy"


def test_a_rough_wheel_with_lines_at_all_orders_is_no_polygon() -> None:
    rough = bogie()
    rough["axle_2/left"] = with_lines(np.arange(1, 40), 0.08, rough)["axle_2/left"]
    assert verdicts(last(rough), "wheel") == {}


def test_an_unbalance_is_no_polygon() -> None:
    assert verdicts(last(bogie(polygons={"axle_1/left": (1, 5.0)})), "wheel") == {}


def test_a_flat_is_no_polygon() -> None:
    assert verdicts(last(bogie(flats={"axle_1/left": 60.0}, polygons={"axle_1/left": (18, 3.0)})), "wheel") == {"axle_1/left": "flat"}


@pytest.mark.parametrize("right", [1.0, 0.4])
def test_a_mesh_in_both_boxes_is_the_gears(right: float) -> None:
    found = statuses(bogie(mesh={"axle_1/left": 1.0, "axle_1/right": right}))
    assert {name: status.verdict for name, status in found.items() if status.verdict != "healthy"} == {"axle_1/gear": "gear"}
    sidebands = float(found["axle_1/gear"].reason.partition("sidebands of ")[2].split()[0])
    assert sidebands == pytest.approx(-20.0, abs=1.5)  # a modulation of 0.2


def test_a_mesh_in_one_box_is_no_gears() -> None:
    found = statuses(bogie(mesh={"axle_1/left": 1.0}))["axle_1/gear"]
    assert (found.verdict, "in both boxes" in found.reason) == ("healthy", True)


def test_a_mesh_that_one_box_has_far_more_of_is_no_gears() -> None:
    found = statuses(bogie(mesh={"axle_1/left": 2.0, "axle_1/right": 0.2}))["axle_1/gear"]
    assert (found.verdict, "alike" in found.reason) == ("healthy", True)


@pytest.mark.parametrize(("there", "verdict"), [(3.0, "healthy"), (0.5, "undecided"), (0.2, "gear")])
def test_a_mesh_belongs_to_the_wheelset_that_has_more(there: float, verdict: str) -> None:
    levels = {"axle_1/left": 0.5, "axle_1/right": 0.5, "axle_2/left": there, "axle_2/right": there}
    assert statuses(bogie(mesh=levels))["axle_1/gear"].verdict == verdict


def test_lines_at_orders_beside_the_mesh_are_no_gears() -> None:
    rough = with_lines(np.arange(78, 97), 0.5, {name: signal for name, signal in bogie().items() if name.startswith("axle_1")})
    assert statuses({**bogie(), **rough})["axle_1/gear"].verdict == "healthy"


def test_a_gear_waits_for_both_boxes() -> None:
    signals = bogie(mesh={"axle_1/left": 1.0, "axle_1/right": 1.0})
    acceleration, angle = signals["axle_1/right"]
    signals["axle_1/right"] = acceleration, np.full_like(angle, np.nan)
    assert statuses(signals)["axle_1/gear"].verdict == "waiting"


def test_a_hop_without_angle_and_a_slow_wheelset_are_no_failure() -> None:
    signals = bogie(polygons={"axle_1/left": (18, 3.0)}, mesh={"axle_1/left": 1.0, "axle_1/right": 1.0})
    acceleration, angle = signals["axle_1/right"]
    signals["axle_1/right"] = acceleration, np.where(np.arange(len(angle)) // HOP == 1, np.nan, angle).astype(np.float32)
    acceleration, angle = signals["axle_2/left"]
    signals["axle_2/left"] = acceleration, np.mod(0.3 * np.unwrap(angle.astype(np.float64)), TURN).astype(np.float32)
    found = statuses(signals)
    assert (found["axle_1/left/wheel"].verdict, found["axle_1/gear"].verdict) == ("polygon", "gear")


def test_an_order_above_the_spectrum_is_not_judged() -> None:
    axles = (dataclasses.replace(DESCRIPTION.axles[0], gear_teeth=213), DESCRIPTION.axles[1])
    found = statuses(bogie(), dataclasses.replace(DESCRIPTION, axles=axles))["axle_1/gear"]
    assert (found.verdict, "213, is too high" in found.reason) == ("waiting", True)


def spectrum_of(turns: npt.NDArray[np.float64], wave: npt.NDArray[np.float64]) -> TurnSpectrum:
    """Return the spectrum of a wave after hops of half a second."""
    margin = RATE // 100
    spectrum, segmenter = TurnSpectrum(HOP, margin, 8), Segmenter(HOP, margin, 0)
    angle = np.mod(TURN * turns, TURN).astype(np.float32)
    for segment in segmenter.add(0, np.column_stack([np.zeros_like(wave), wave]), angle):
        spectrum.add(segment)
    return spectrum


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_line_keeps_its_order_and_amplitude_while_the_speed_rises(direction: float) -> None:
    time = np.arange(round(SECONDS * RATE)) / RATE
    turns = direction * (10.0 * time + 2.0 * time**2)
    found = spectrum_of(turns, 3.0 * np.cos(TURN * 87.0 * turns)).spectrum()
    assert found is not None
    middle = (found.orders > 80.0) & (found.orders < 95.0)
    assert found.orders[middle][np.argmax(found.amplitude[middle])] == pytest.approx(87.0, abs=0.02)
    assert found.lines([87.0])[0] == pytest.approx(3.0, rel=0.06)


def test_tones_above_the_spectrum_are_not_folded_into_it() -> None:
    time = np.arange(round(SECONDS * RATE)) / RATE
    found = spectrum_of(10.0 * time, np.sin(TURN * 5500.0 * time)).spectrum()  # 640 - 550 = order 90
    assert found is not None
    assert found.amplitude[found.orders > 50.0].max() < 1e-3


def test_a_spectrum_needs_turns_in_one_direction() -> None:
    time = np.arange(round(SECONDS * RATE)) / RATE
    assert spectrum_of(5.0 * time, np.sin(time)).spectrum() is None
    assert spectrum_of(20.0 * np.abs(time - 2.3), np.sin(time)).spectrum() is None
