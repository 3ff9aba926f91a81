"""A corrugated rail and a motor in synthetic bogies: lines at no whole orders of a wheelset."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from synthetic_bearing import TURN
from synthetic_bogie import BOXES, LAG, Boxes, bogie, last, verdicts

from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.vehicle.rolling_lines import prominent

QUIET: Boxes = bogie()


def with_line(order: float, amplitudes: Mapping[str, float]) -> Boxes:
    """Return signals with a line at an order of the wheelsets; the trailing wheelset has it after the lag."""
    changed = {}
    for number, (name, (acceleration, angle)) in enumerate(QUIET.items()):
        turns = np.unwrap(angle.astype(np.float64)) / TURN - (number // 2) * LAG * 20.0
        louder = acceleration.copy()
        louder[:, 1] += (amplitudes.get(name, 0.0) * np.cos(TURN * order * turns)).astype(np.float32)
        changed[name] = louder, angle
    return changed


@pytest.mark.parametrize("order", [36.12, 36.125, 36.135])
def test_a_line_lies_between_the_values_of_a_spectrum(order: float) -> None:
    """A line whose level is a parabola, 60 dB above the rest."""
    orders = np.arange(0.0, 60.0, 0.02)
    amplitude = 1e-3 + np.exp(-(((orders - order) / 0.03) ** 2))
    for least, found in ((59.0, [pytest.approx(order, abs=2e-4)]), (61.0, [])):
        assert list(prominent(OrderSpectrum(orders, amplitude.astype(np.float32), 1.0), (20.0, 50.0), least)) == found


@pytest.mark.parametrize("side", ["left", "right"])
def test_waves_of_one_rail_are_a_corrugation_of_their_length(side: str) -> None:
    diagnosis = last(with_line(36.13, {name: 2.0 if name.endswith(side) else 0.3 for name in BOXES}))
    assert verdicts(diagnosis) == {"track": "corrugation"}
    assert f"over the {side} rail" in diagnosis.statuses["track"].reason
    assert diagnosis.indicators["track/corrugation"] == pytest.approx(TURN * 0.46 / 36.13, rel=1e-3)


@pytest.mark.parametrize(
    ("order", "amplitudes"),
    [
        (36.13, dict.fromkeys(BOXES, 2.0)),  # both rails
        (36.0, {"axle_1/left": 2.0, "axle_2/left": 1.0}),  # a wheel that the other wheelset measures, too
        (36.13, {"axle_2/left": 2.0}),  # one wheelset only
    ],
)
def test_other_lines_are_no_corrugation(order: float, amplitudes: dict[str, float]) -> None:
    assert last(with_line(order, amplitudes)).statuses["track"].verdict == "healthy"


def test_without_a_sound_sensor_the_track_waits_for_it() -> None:
    signals = with_line(36.13, {name: 2.0 if name.endswith("left") else 0.3 for name in BOXES})
    signals["axle_2/right"] = np.zeros_like(signals["axle_2/right"][0]), signals["axle_2/right"][1]
    track = last(signals).statuses["track"]
    assert track.verdict == "waiting"
    assert track.reason == "a corrugated rail cannot be recognised without a spectrum of axle_2/right"


def test_a_line_in_both_boxes_of_the_driven_wheelset_is_the_motors() -> None:
    diagnosis = last(with_line(4.14, {"axle_1/left": 4.0, "axle_1/right": 2.5, "axle_2/left": 0.3}))
    assert verdicts(diagnosis) == {"axle_1/gear": "motor"}
    assert "order 4.14" in diagnosis.statuses["axle_1/gear"].reason


@pytest.mark.parametrize(
    ("order", "amplitudes"),
    [
        (4.14, {"axle_1/left": 4.0}),  # one box only
        (4.0, {"axle_1/left": 4.0, "axle_1/right": 4.0}),  # a whole order
        (4.14, dict.fromkeys(BOXES, 4.0)),  # both wheelsets
        (4.14, {"axle_2/left": 4.0, "axle_2/right": 4.0}),  # a wheelset without a motor
        (16.73, {"axle_1/left": 8.0, "axle_1/right": 0.8}),  # not alike
    ],
)
def test_other_lines_are_no_motors(order: float, amplitudes: dict[str, float]) -> None:
    assert last(with_line(order, amplitudes)).statuses["axle_1/gear"].verdict == "healthy"
