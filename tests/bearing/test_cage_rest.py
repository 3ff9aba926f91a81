"""Cages that lie on rollers or land when a run begins."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dcrb_ros.bearing.cage_rest import settled_cages
from dcrb_ros.bearing.equilibrium import Rest, static_equilibrium
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.payload import Payload
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import cage_speed
from dcrb_ros.simulation.loop import Simulation


def settled(**groups: Any) -> tuple[Payload, Rest, np.ndarray]:
    """Return the constants, the equilibrium, and the centres of the settled cages [m]."""
    made = Configuration.model_validate(groups)
    payload = build_payload(made)
    rest = static_equilibrium(payload, np.array([0.0, -made.operating.load]), cage_speed(made, made.operating.speed))
    return payload, rest, settled_cages(payload, rest)


def offsets(payload: Payload, rest: Rest, cages: np.ndarray) -> np.ndarray:
    """Return how far each roller is from the middle of its pocket [m]."""
    return np.asarray(((rest.rollers - cages[:, None]) * payload.pocket_tangent).sum(axis=-1))


@pytest.mark.parametrize("clearance", [3e-5, 7e-5, 1e-4])
def test_a_cage_lies_on_its_rollers_and_enters_none(clearance: float) -> None:
    payload, rest, cages = settled(cage={"pocket_clearance": clearance})
    deepest = np.abs(offsets(payload, rest, cages)).max(axis=1)
    assert deepest == pytest.approx(clearance, abs=1e-12)
    assert (cages[:, 1] < rest.cages[:, 1]).all()
    assert np.array_equal(cages[:, 0], rest.cages[:, 0])


def test_a_cage_with_wide_pockets_lies_on_the_land() -> None:
    payload, rest, cages = settled(cage={"pocket_clearance": 0.002, "land_clearance": 3e-4})
    assert np.linalg.norm(cages - rest.outer, axis=-1) == pytest.approx(3e-4, abs=1e-12)
    assert np.abs(offsets(payload, rest, cages)).max() < 0.002


def test_broken_bars_carry_nothing() -> None:
    """The rollers at 90 degrees carry a cage; without the bars there it sinks on to others."""
    bars = ", ".join(f"row1/bar{k}" for k in (4, 5, 12, 13))
    _, _, cages = settled(faults={"broken_bars": bars})
    assert cages[0, 1] < cages[1, 1]


def test_pinned_cages_stay_where_their_rollers_carry_them() -> None:
    _, rest, cages = settled(cage={"joint": "revolute"})
    assert np.array_equal(cages, rest.cages)


def test_a_settled_start_spares_the_first_blow() -> None:
    """From the middle of their play the cages fall by more than a tenth of a millimetre and strike."""

    def first_peak(start: str) -> float:
        blocks = Simulation(Configuration.model_validate({"operating": {"start": start}, "sensor": {"noise_density": 0.0}})).blocks(0.05)
        return float(max(np.abs(block.clean).max() for block in blocks))

    assert first_peak("settled") < 0.7 * first_peak("warm")
