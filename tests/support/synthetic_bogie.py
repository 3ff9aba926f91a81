"""Synthetic signals of the four boxes of a bogie: bearings with cross-talk, wheels, a gear, joints and one rail under all wheels."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from synthetic_bearing import ORDERS, RATE, TURN, Signal, synthetic

from dcrb_ros.diagnosis.vehicle.detector import BoxBlock, VehicleDetector
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.vehicle_description import AxleDescription, BoxDescription, VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import VehicleDiagnosis

BOXES = ("axle_1/left", "axle_1/right", "axle_2/left", "axle_2/right")
RADIUS, HALF = 0.46, 1.28
"""Radius of the wheels and half the distance of the wheelsets [m]."""
FREQUENCY = 20.0
"""[Hz]"""
TEETH = 87
SECONDS = 3.0
LAG = 2.0 * HALF / (TURN * FREQUENCY * RADIUS)
"""Time from the leading to the trailing wheelset [s]."""
DESCRIPTION = VehicleDescription(
    RATE,
    (AxleDescription("axle_1", HALF, RADIUS, TEETH), AxleDescription("axle_2", -HALF, RADIUS)),
    tuple(
        BoxDescription(f"{axle}/{side}", axle, side, ORDERS.as_dict(), {})  # type: ignore[arg-type]
        for axle in ("axle_1", "axle_2")
        for side in ("left", "right")
    ),
)
Boxes = dict[str, Signal]


@functools.cache
def quiet(seed: int) -> Signal:
    """Return the signal of an undamaged bearing, which is shared: copy it before you change it."""
    return synthetic(seconds=SECONDS, seed=seed)


@functools.cache
def rail(side: int, delay: float) -> Floats:
    """Return the acceleration by the long waves of one rail, 20 to 150 Hz, after a delay [s]; the array is shared."""
    count = round(2.0 * SECONDS * RATE)
    frequency = np.fft.rfftfreq(count, 1.0 / RATE)
    random = np.random.default_rng(100 + side)
    spectrum = np.exp(2j * math.pi * random.uniform(size=len(frequency))) * ((frequency > 20.0) & (frequency < 150.0))
    wave = np.fft.irfft(spectrum * np.exp(-2j * math.pi * frequency * delay), count)
    return np.asarray(2.0 * wave / wave.std(), np.float64)[: round(SECONDS * RATE)]


def bogie(
    damage: Mapping[str, Mapping[str, float]] | None = None,
    *,
    across: float = 0.1**0.5,
    along: float = 0.03,
    gains: Mapping[str, float] | None = None,
    flats: Mapping[str, float] | None = None,
    joints: Sequence[float] = (),
    joint_sides: Sequence[int] = (0, 1),
    joint: float = 400.0,
    polygons: Mapping[str, tuple[int, float]] | None = None,
    mesh: Mapping[str, float] | None = None,
) -> Boxes:
    """Return the signals of all boxes.

    ``damage`` has the impacts of `synthetic` by box. The other box of the wheelset measures them with a gain ``across``, those of the other
    wheelset with ``along``. ``flats`` are impacts once in a turn by box, ``joints`` are times at the leading wheelset [s].
    ``polygons`` have an order and an amplitude by box, ``mesh`` has the amplitude of the mesh of 87 teeth by box [m/s^2].
    """
    time = np.arange(round(SECONDS * RATE)) / RATE
    turns = FREQUENCY * time
    sources = {name: synthetic(seconds=SECONDS, seed=9, **parts)[0] - quiet(9)[0] for name, parts in (damage or {}).items()}
    signals: Boxes = {}
    for number, name in enumerate(BOXES):
        trailing, side = divmod(number, 2)
        acceleration = quiet(number)[0].astype(np.float64)
        acceleration[:, 1] += rail(side, LAG * trailing)
        for source, motion in sources.items():
            acceleration += _transfer(source, name, across, along) * motion
        for source, level in (flats or {}).items():
            acceleration[:, 1] += _transfer(source, name, 0.4, 0.1) * flat(turns, level)
        for source, (order, amplitude) in (polygons or {}).items():
            acceleration[:, 1] += _transfer(source, name, 0.25, 0.1) * amplitude * np.cos(TURN * order * turns)
        acceleration[:, 1] += (mesh or {}).get(name, 0.0) * (1.0 + 0.2 * np.cos(TURN * turns)) * np.cos(TURN * TEETH * turns)
        for axle, heard in enumerate((1.0, 0.3) if not trailing else (0.3, 1.0)):
            for begin in joints if side in joint_sides else ():
                acceleration[:, 1] += heard * kink(time, begin + LAG * axle, joint)
        gain = (gains or {}).get(name, 1.0)
        signals[name] = (gain * acceleration).astype(np.float32), quiet(number)[1].copy()
    return signals


def _transfer(source: str, name: str, across: float, along: float) -> float:
    if source == name:
        return 1.0
    return across if source.partition("/")[0] == name.partition("/")[0] else along


def flat(turns: Floats, level: float) -> Floats:
    """Return impacts once in a turn that ring at 1.5 and 9 kHz."""
    ring = np.arange(RATE // 100) / RATE
    pulses = np.zeros(len(turns))
    pulses[np.flatnonzero(np.diff(np.floor(turns)) != 0.0)] = level
    ringing = np.exp(-ring / 1e-3) * (np.sin(TURN * 1500.0 * ring) + 0.3 * np.sin(TURN * 9000.0 * ring))
    return np.asarray(np.convolve(pulses, ringing)[: len(turns)], np.float64)


def kink(time: Floats, begin: float, level: float) -> Floats:
    """Return one impact that rings at 9 kHz."""
    since = time - begin
    return np.where(since >= 0.0, level * np.exp(-np.maximum(since, 0.0) / 5e-4) * np.sin(TURN * 9000.0 * since), 0.0)


def diagnosed(
    signals: Boxes,
    *,
    block: int = 1024,
    detector: VehicleDetector | None = None,
    first: Mapping[str, int] = MappingProxyType({}),
    lost: Callable[[str, int], bool] = lambda name, k: False,
    together: bool = True,
) -> list[VehicleDiagnosis]:
    """Return the diagnoses of signals that are passed on in blocks of all boxes, or of one box after the other.

    ``first`` are the indices of the first samples, and ``lost`` says whether the block of a box that begins at a sample does not arrive.
    """
    watching, found = detector or VehicleDetector(DESCRIPTION), []
    for k in range(0, max(len(angle) for _, angle in signals.values()), block):
        part = slice(k, k + block)
        arriving = {name: signal for name, signal in signals.items() if k < len(signal[1]) and not lost(name, k)}
        blocks = {name: BoxBlock(first.get(name, 0) + k, a[part], angle[part]) for name, (a, angle) in arriving.items()}
        found += [watching.add(each) for each in ([blocks] if together else [{name: one} for name, one in blocks.items()])]
    return [diagnosis for diagnosis in found if diagnosis is not None]


def last(signals: Boxes) -> VehicleDiagnosis:
    """Return the last diagnosis of signals."""
    return diagnosed(signals)[-1]


def verdicts(diagnosis: VehicleDiagnosis, kind: str = "") -> dict[str, str]:
    """Return the verdicts that are not healthy: on all parts by name, or on those of one kind by box."""
    ending = f"/{kind}" if kind else ""
    found = {name: status.verdict for name, status in diagnosis.statuses.items() if name.endswith(ending)}
    return {name.removesuffix(ending): verdict for name, verdict in found.items() if verdict != "healthy"}
