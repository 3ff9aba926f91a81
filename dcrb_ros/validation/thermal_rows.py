"""Comparisons of the thermal network with numbers worked out by hand; they need no simulation.

The numbers are those of `docs/explanation/thermal.md`: the bearing of Table 1 with grease at 1200 rpm under 100 kN, 20 deg C outside.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from dcrb_ros.bearing.quasi_steady import QuasiSteady
from dcrb_ros.bearing.thermal_fit import expansion
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.validation.report_row import ReportRow, about, between

CHAPTER = "Heat"
AMBIENT = 20.0
"""[deg C]"""
RACEWAYS = [(62.8, 73.6)] * 2
"""Conductances of inner and outer raceway [W/K]."""
VEHICLE = 57.8
"""[m/s]"""


def bearing(**lubrication: Any) -> QuasiSteady:
    """Return the bearing with a thermal network, with some parameters of lubrication."""
    oil = {"law": "film"} | lubrication
    return QuasiSteady(Configuration.model_validate({"lubrication": oil, "thermal": {"law": "network"}}))


def thermal_rows() -> Iterator[ReportRow]:
    """Yield the comparisons of network, steady states, clearance and loss of lubricant."""
    yield from _network()
    yield from _steady()
    yield from _loss()


def _network() -> Iterator[ReportRow]:
    network = bearing().network
    flow, box = network.conductances(RACEWAYS, VEHICLE, 0.4 * VEHICLE), network.box
    warmed = network.steady(flow, [0.0] * box + [100.0], AMBIENT)
    yield about(CHAPTER, "Resistance from the axle box to the air", (warmed[box] - AMBIENT) / 100.0, 0.02069, 1e-3, "K/W")
    begin, heat = [AMBIENT + 10.0 * node for node in range(box + 1)], [100.0] * (box + 1)
    after = network.after(begin, flow, heat, AMBIENT, 20.0)
    stored = math.fsum(c * (now - before) for c, now, before in zip(network.capacity, after, begin, strict=True))
    lost = 20.0 * math.fsum(g * (now - AMBIENT) for g, now in zip(flow.ambient, after, strict=True))
    yield about(CHAPTER, "Heat stored and lost over heat put in, in a step", (stored + lost) / (20.0 * sum(heat)), 1.0, 1e-9)
    hot = [AMBIENT + 60.0 * (node < 2) for node in range(box + 1)]
    grown = expansion(bearing().configuration, network, hot).clearance
    yield about(CHAPTER, "Clearance taken by inner rings that are 60 K hotter", 1e6 * grown, -56.3, 0.01, "um")


def _steady() -> Iterator[ReportRow]:
    for lubricant, heat in (("grease", 849.0), ("vg100", 1268.0), ("vg220", 1508.0)):
        steady = bearing(lubricant=lubricant)
        running = steady.running()
        temperatures = steady.steady(running)
        yield about(CHAPTER, f"Heat in the steady state, {lubricant}", sum(map(sum, steady.power(running, temperatures))), heat, 0.1, "W")
        yield between(CHAPTER, f"Box above ambient, {lubricant}", temperatures[-1] - AMBIENT, 10.0, 45.0, "K")


def _loss() -> Iterator[ReportRow]:
    steady = bearing()
    running = steady.running()
    temperatures = steady.steady(running)
    ring = steady.network.outer(0)
    course = [temperatures[ring]]
    for step in range(540):
        temperatures = steady.after(running, temperatures, 20.0, min(step * 20.0 / 5400.0, 1.0))
        course.append(temperatures[ring])
    yield between(CHAPTER, "Outer ring while the lubricant is lost, below its start", course[0] - min(course), 5.0, 15.0, "K")
    yield between(CHAPTER, "Outer ring an hour and a half after all lubricant is lost", course[-1], 150.0, 300.0, "deg C")
