"""The view of a bench with temperatures: what is seen without choosing a tab, and the verdict that follows from them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.viewer import blueprint
from dcrb_ros.viewer.content import TimedWaveform
from dcrb_ros.viewer.drawing import Drawing
from dcrb_ros.viewer.spectrum import diagnoses

RATE, SECONDS = 12800, 8


def in_front(container: Any) -> list[str]:
    """Return the names of the views that are seen first, from left to right and from above."""
    if not hasattr(container, "contents") or isinstance(container.contents, str) or not container.contents:
        return [str(container.name)]
    if all(isinstance(one, str) for one in container.contents):  # a view with chosen entities
        return [str(container.name)]
    shown = (
        [container.contents[container.active_tab or 0]] if hasattr(container, "active_tab") and container.active_tab is not None else None
    )
    return [name for one in (shown or container.contents) for name in in_front(one)]


def seen(*, warm: bool, lubricated: bool = True) -> list[str]:
    found = blueprint.arrangement(Drawing(Bearing(), 1.0), [], around=(-0.1, 0.1), warm=warm, lubricated=lubricated)
    return [name.split()[0].strip(":") for name in in_front(found)]


def test_temperatures_noise_and_films_are_seen_first_where_there_are_temperatures() -> None:
    assert seen(warm=True) == ["Bearing", "Vibration", "Temperatures", "Oil", "Recording"]
    assert seen(warm=True, lubricated=False) == ["Bearing", "Vibration", "Temperatures", "Recording"]
    assert seen(warm=False) == ["Bearing", "Acceleration", "Squared", "Recording", "Roller"]


def test_the_verdict_takes_temperatures_into_account_at_the_time_lapse_of_the_bench() -> None:
    count = RATE * SECONDS
    time = np.arange(count)
    noise = np.random.default_rng(1).standard_normal((count, 2)).astype(np.float32)
    angle = (2.0 * math.pi * 15.0 * time / RATE % (2.0 * math.pi)).astype(np.float32)
    waveform = TimedWaveform(time * 1_000_000_000 // RATE, noise, angle, RATE)
    read = np.arange(0.0, SECONDS)
    hot = TemperatureReadings(time=read, outer_ring=np.full(SECONDS, 150.0), box=np.full(SECONDS, 120.0), ambient=np.full(SECONDS, 20.0))
    orders = characteristic_orders(Bearing())
    assert "overheating" not in {one.verdict for one in diagnoses(waveform, orders)}
    assert diagnoses(waveform, orders, hot)[-1].verdict == "overheating"
    # A rise of 57 K that lasts for hours was there from the beginning; after some seconds that is unknown.
    warm = TemperatureReadings(time=read, outer_ring=np.full(SECONDS, 77.0), box=read, ambient=np.full(SECONDS, 20.0))
    real, fast = (diagnoses(waveform, orders, warm, lapse)[-1].verdict for lapse in (1.0, 3000.0))
    assert real != "overheating"
    assert fast == "overheating"
