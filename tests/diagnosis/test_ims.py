"""Healthy double-row roller bearings, whose rollers differ: lines at multiples of FTF are no cage fault."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import dcrb_ros
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.measured import diagnose_as_a_whole
from dcrb_ros.schema.arrays import Floats

pytestmark = pytest.mark.slow

IMS = Path(__file__).parents[3] / "shared" / "measured" / "ims"
"""50 snapshots of one second of two bearings, two axes, minutes apart; their licence keeps them out of the repository."""
measured = pytest.mark.skipif(not (IMS / "ims_healthy_b4.npz").is_file(), reason=f"the healthy roller bearings are not in {IMS}")
ORDERS = Orders(ftf=0.443, bpfo=7.09, bpfi=8.91, bsf=4.20)
RATE, SPEED = 20000, 2000.0 / 60.0


def snapshots(bearing: str) -> Iterator[Floats]:
    """Yield the accelerations of the snapshots, shape (samples, 2), in a unit that does not matter."""
    with np.load(IMS / f"ims_healthy_{bearing}.npz") as arrays:
        yield from np.asarray(arrays["a"], np.float64).transpose(0, 2, 1)


def angle(samples: int, first: int = 0) -> Floats:
    return np.asarray(np.mod(2.0 * np.pi * SPEED / RATE * (first + np.arange(samples)), 2.0 * np.pi), np.float64)


@measured
@pytest.mark.parametrize("bearing", ["b1", "b4"])
@pytest.mark.parametrize("axis", [0, 1])
def test_no_snapshot_of_one_axis_is_faulty(bearing: str, axis: int) -> None:
    p = DetectorParameters()
    verdicts = [diagnose_as_a_whole(one[:, axis], RATE, SPEED, ORDERS, p).verdict for one in snapshots(bearing)]
    assert verdicts == ["healthy"] * 50


@measured
def test_unequal_rollers_are_what_the_cage_rule_would_see() -> None:
    """The lines are certain and deep enough: without the scatter of rollers, half of the snapshots would be called cage."""
    p = DetectorParameters(cage_scatter=0.0)
    verdicts = [diagnose_as_a_whole(one[:, 0], RATE, SPEED, ORDERS, p).verdict for one in snapshots("b4")]
    assert verdicts.count("cage") > 15


@measured
@pytest.mark.parametrize("bearing", ["b1", "b4"])
@pytest.mark.parametrize("axes", [(0, 1), (1, 1)], ids=["both", "second"])
def test_a_snapshot_is_healthy_in_one_call(bearing: str, axes: tuple[int, int]) -> None:
    """It has 1 s in a window of 4 s: evidence of up to 1.2 dB does not count, of which one snapshot has 0.7 dB for a roller."""
    for one in list(snapshots(bearing))[::3]:
        assert dcrb_ros.detect(one[:, list(axes)], RATE, bearing=ORDERS, shaft_angle=angle(len(one))).verdict == "healthy"


@measured
@pytest.mark.parametrize("bearing", ["b1", "b4"])
def test_snapshots_with_gaps_between_them_are_healthy(bearing: str) -> None:
    """Each gap starts a new window, which a judgement without confirmation names by one second of signal."""
    detector = FaultDetector(ORDERS, RATE, DetectorParameters(least_window=0.5, confirm=1, least_turns=4.0))
    verdicts = []
    for number, one in enumerate(snapshots(bearing)):
        first = number * 300 * RATE
        for begin in range(0, len(one), 4000):
            part = one[begin : begin + 4000]
            diagnosis = detector.update(first + begin, part, angle(len(part), first + begin))
            verdicts += [diagnosis.verdict] if diagnosis is not None else []
    assert len(verdicts) >= 50
    assert set(verdicts) == {"healthy"}
