"""The simulated bench as the source: what the outer ring does before any path, noise or background."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.calibration.healthy_recording import SAME_ORDERS, HealthyRecording
from dcrb_ros.diagnosis.order_tracking import unwrapped_turns
from dcrb_ros.faults import Faults
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.parameter_field import flaw_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import fields_by_key, flatten, load_configuration, settings_by_key
from dcrb_ros.settings.measured_rate import rates
from dcrb_ros.settings.parameters import STEEL_DENSITY, Publishing, Recording
from dcrb_ros.settings.sensor import Background, SensorParameters, Structure
from dcrb_ros.simulation.loop import Simulation

SMALLEST_COSINE = math.cos(1.0)
"""Cosine of the largest contact angle [-]."""
SETTLING = 0.5
"""Time before the first sample that is used [s]: idle rollers come to rest in it."""
INDIVIDUALS = 4
"""Individuals of the bench's bearing that are compared, the source among them [-]."""
INDIVIDUAL_SECONDS = 2.0
"""Simulated time of each of the others [s]."""
SPEED_KEYS = ("operating.speed_kmh", "operating.speed_fluctuation", "operating.speed_ripple")
"""Parameters outside of path, background and sensor that a calibration determines, too."""


@dataclass(frozen=True, eq=False)
class RingAcceleration:
    """Acceleration of the outer ring of the bench."""

    acceleration: Floats
    """In X and Y, without its mean, shape (2, samples) [m/s^2]."""
    turns: Floats
    """Turns of the shaft since the first sample, shape (samples,) [-]."""


def bench_of(
    measured: HealthyRecording, base: Configuration | str | Path | None, settings: Mapping[str, Any] | Sequence[str]
) -> Configuration:
    """Return the bench without path, background and errors of the sensor, at the speed and the sampling rate of a recording.

    By default it is the one that made the recording, or ``healthy`` with the number and the size of rollers that give its orders.

    Raises:
        Refusal: the base has a bearing with other orders, or it cannot run at this speed or rate, or a setting would be replaced.
    """
    if flaw := flaw_of(fields_by_key()["sensor.sampling_rate"], measured.rate):
        raise Refusal(f"the bench cannot run like {measured.name}: {flaw}; resample the recording")
    given = base if base is not None else measured.configuration
    bench = load_configuration(given if given is not None else "healthy", settings)
    empty = {"faults": Faults(), "structure": Structure(), "background": Background(), "publishing": Publishing()}
    empty |= {"recording": Recording(), "sensor": SensorParameters()}
    changes = flatten({group: parameters.model_dump() for group, parameters in empty.items()})
    changes |= rates(measured.rate, bench.simulation.step) | {"operating.speed": measured.speed}
    mismatch = _mismatch(characteristic_orders(bench.bearing), measured.orders)
    if mismatch and given is not None:
        raise Refusal(f"{measured.name} has another bearing than its bench: {mismatch}; give a base with the machine's bearing")
    if mismatch:
        changes |= flatten({"bearing": rollers_of(measured.orders, bench, measured.name)})
    # A shorter step is kept: see `measured_rate.rates`.
    unused = [key for key in settings_by_key(settings) if key in SPEED_KEYS or (key in changes and key != "simulation.step")]
    if unused:
        raise Refusal(
            f"the setting {unused[0]} cannot be kept: a calibration determines it from the recording, or leaves it at its default; omit it "
            "and change it in the calibrated file"
        )
    try:
        return load_configuration(bench, changes)
    except Refusal as refusal:
        raise Refusal(f"the bench cannot run like {measured.name}: {str(refusal).removeprefix('settings: ')}") from None


def rollers_of(orders: Orders, bench: Configuration, name: str) -> dict[str, Any]:
    """Return number and size of rollers that give characteristic orders on the pitch circle of a bench, with their raceways and masses.

    BPFO + BPFI = n, BPFI - BPFO = n g and BSF = cos(a) (1 - g^2)/(2 g), with g = r/R cos(a), for n rollers of radius r on a pitch circle of
    radius R and a contact angle a (Randall and Antoni 2011, eqs. 1 to 4); a is 0 where BSF is not that of an angle below 1 rad. The scale
    of the bearing cannot be seen in orders.

    Raises:
        Refusal: there are no such rollers.
    """
    b, number = bench.bearing, round(orders.bpfo + orders.bpfi)
    radius = b.pitch_radius * (orders.bpfi - orders.bpfo) / (orders.bpfi + orders.bpfo)
    if not (6 <= number <= 60 and radius > 0.0):
        raise Refusal(f"{name}: {number} rollers, as BPFO + BPFI requires, are outside 6 .. 60: give a base with the machine's bearing")
    inner = b.inner_raceway_radius + b.roller_radius - b.pitch_radius
    outer = b.outer_raceway_radius - b.roller_radius - b.pitch_radius
    share = 2.0 * radius / b.pitch_radius * orders.bsf / (1.0 - (radius / b.pitch_radius) ** 2)
    angle = math.acos(share) if SMALLEST_COSINE <= share < 1.0 - SAME_ORDERS else 0.0
    own = radius / math.cos(angle)
    mass = STEEL_DENSITY * math.pi * own**2 * b.roller_length
    return {
        "rollers_per_row": number,
        "roller_radius": radius,
        "contact_angle": angle,
        "inner_raceway_radius": b.pitch_radius - radius + inner,
        "outer_raceway_radius": b.pitch_radius + radius + outer,
        "roller_mass": mass,
        "roller_inertia": 0.5 * mass * own**2,
    }


def _mismatch(bench: Orders, machine: Orders) -> str:
    for name in ("bpfo", "bpfi"):
        simulated, measured = getattr(bench, name), getattr(machine, name)
        if abs(simulated / measured - 1.0) > SAME_ORDERS:
            return f"its {name.upper()} is {simulated:.4g} orders, that of the machine {measured:.4g}"
    return ""


def ring_acceleration(bench: Configuration, seconds: float) -> RingAcceleration:
    """Return the acceleration of the outer ring after the anti-alias filter, from `SETTLING` on."""
    blocks = list(Simulation(bench, waveform_only=True).blocks(SETTLING + seconds))
    first = round(SETTLING * bench.sensor.sampling_rate)
    clean = np.concatenate([block.clean for block in blocks])[first:].T.astype(np.float64)
    angle = np.concatenate([block.shaft_angle for block in blocks])[first:]
    return RingAcceleration(clean - clean.mean(axis=1, keepdims=True), unwrapped_turns(angle))


def individuals_of(machines: Sequence[HealthyRecording], benches: Sequence[Configuration], seconds: float) -> list[list[RingAcceleration]]:
    """Return individuals of the bearing at the speed of each recording: the source, simulated over a time [s], and others.

    The surfaces of the machine's bearing are unknown. Recordings whose speeds differ by less than 1 % share the individuals.
    """
    simulated: list[tuple[float, list[RingAcceleration]]] = []
    individuals = []
    for machine, bench in zip(machines, benches, strict=True):
        bearings = next((bearings for speed, bearings in simulated if abs(machine.speed / speed - 1.0) < 0.01), None)
        if bearings is None:
            seeds = [(bench.surfaces.seed + 7919 * k) % (2**31 - 1) for k in range(1, INDIVIDUALS)]
            others = [load_configuration(bench, {"surfaces.seed": seed}) for seed in seeds]
            bearings = [ring_acceleration(bench, seconds), *(ring_acceleration(other, INDIVIDUAL_SECONDS) for other in others)]
            simulated.append((machine.speed, bearings))
        individuals.append(bearings)
    return individuals
