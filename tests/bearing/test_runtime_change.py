"""Changes of faults and sensor while the simulation runs: their times, the ground truth, and what is refused."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any

import numpy as np
import pytest

from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.pending import PendingCommands
from dcrb_ros.stream.block import Block, Truth
from dcrb_ros.stream.events import ParameterChange

LEAD = 0.001
"""Upper limit of the time by which the model is ahead of the samples [s]."""


def bench(**groups: Any) -> Simulation:
    return Simulation(Configuration.model_validate({"sensor": {"noise_density": 0.0}, **groups}))


def truths(blocks: list[Block]) -> list[Truth]:
    return [truth for block in blocks for truth in block.truths]


def test_a_defect_appears_at_the_time_in_the_ground_truth() -> None:
    healthy, faulty = bench(), bench()
    before = [next(s.blocks(0.02)) for s in (healthy, faulty)]
    faulty.change({"faults.outer_1.width": 0.002})
    after = list(faulty.blocks(0.2))
    assert np.array_equal(before[0].acceleration, before[1].acceleration)
    change = next(truth for truth in truths(after) if truth.event)
    assert change.event == ParameterChange({"faults.outer_1.width": 0.002})
    assert 0.02 <= change.time_ns * 1e-9 <= 0.02 + LEAD
    assert change.faults["outer_1"]["width"] == 0.002
    assert change.faults["outer_1"]["onset"] == pytest.approx(change.time_ns * 1e-9, abs=1e-9)
    same = np.concatenate([block.acceleration for block in healthy.blocks(0.2)])
    other = np.concatenate([block.acceleration for block in after])
    first = int(np.argmax(np.any(same != other, axis=1)))
    assert first / 51200 <= 2.0 * np.pi / 16 / 53.0  # the next roller strikes it: a pitch at the cage speed
    assert other.std() > 1.2 * same.std()


def test_a_removed_defect_leaves_the_ground_truth() -> None:
    simulation = bench(faults={"outer_1": {"width": 0.002}})
    simulation.change({"faults.outer_1.width": 0.0})
    simulation.change({"faults.inner_1.width": 0.001, "faults.inner_1.row": 2})
    found = truths(list(simulation.blocks(0.05)))
    assert set(found[0].faults) == {"outer_1"}
    assert found[0].faults["outer_1"]["onset"] == 0.0
    assert set(found[-1].faults) == {"inner_1"}


def test_a_growing_defect_keeps_its_onset() -> None:
    simulation = bench()
    onsets = []
    for width in (0.001, 0.0015, 0.002):
        simulation.change({"faults.outer_1.width": width})
        onsets += [t.faults["outer_1"]["onset"] for t in truths(list(simulation.blocks(0.02))) if isinstance(t.event, ParameterChange)]
    assert len(onsets) == 3
    assert len(set(onsets)) == 1


@pytest.mark.parametrize("joint", ["pocket", "revolute"])
def test_bars_break_while_the_bearing_rotates(joint: str) -> None:
    simulation = bench(cage={"joint": joint}, publishing={"state_rate": 1000})
    before = [states for block in simulation.blocks(0.05) for states in block.states]
    simulation.change({"faults.broken_bars": "row1/bar15, row2/bar15"})
    blocks = list(simulation.blocks(0.35))
    after = [states for block in blocks for states in block.states]
    free = (14, 15)  # rollers 15 and 16 of row 1 are beside the bar
    kept = [np.angle(np.exp(1j * (after[0].azimuth[i] - before[-1].azimuth[i]))) for i in free]
    assert kept == pytest.approx([0.053, 0.053], abs=0.02)  # the cage rotates at 52 rad/s: no jump in a millisecond
    apart = np.array([np.angle(np.exp(1j * (s.azimuth[15] - s.azimuth[14]))) for s in after])
    assert np.abs(apart - 2.0 * np.pi / 16).max() > 0.01  # they leave the pitch of their pockets
    assert np.abs(apart).min() > 2.0 * np.arcsin(0.015 / 0.094) - 0.01  # but do not pass through each other
    assert abs(simulation.energy.residual) < 10.0
    faults = truths(blocks)[-1].faults
    assert set(faults) == {"broken_bars.row1/bar15", "broken_bars.row2/bar15"}
    assert 0.05 <= faults["broken_bars.row1/bar15"]["onset"] <= 0.05 + LEAD


def test_a_change_of_the_sensor_takes_effect_at_the_first_sample_after_its_time() -> None:
    simulation = bench(faults={"outer_1": {"width": 0.002}})
    first = list(simulation.blocks(0.1))
    simulation.change({"sensor.range": 50.0, "sensor.adc_bits": 8})
    after = list(simulation.blocks(0.1))
    at_ns = next(t.time_ns for t in truths(after) if t.event)
    sample = -(-at_ns * 51200 // 1_000_000_000) - after[0].index
    joined = np.concatenate([block.acceleration for block in after])
    clean = np.concatenate([block.clean for block in after])
    assert np.abs(np.concatenate([block.acceleration for block in first])).max() > 50.0
    assert 0 < sample < LEAD * 51200
    assert joined[:sample] == pytest.approx(clean[:sample], abs=0.01)
    assert np.abs(joined[sample:]).max() <= 50.0
    assert np.array_equal(joined[sample:], np.round(joined[sample:] / (50.0 / 128)) * np.float32(50.0 / 128))
    assert [block.range for block in (first[-1], after[0])] == [5000.0, 50.0]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"faults.outer_1.width": 0.5}, r"faults.outer_1.width = 0.5 m is outside 0 .. 0.05 m"),
        ({"faults.outer_1.width": float("nan")}, r"faults.outer_1.width = nan m is not a finite number"),
        ({"faults.outer_1.width": 1}, r"did you mean 0\.001"),
        ({"faults.outer_1.width": 0.002, "faults.outer_2.width": 0.002}, r"faults.outer_2 overlaps faults.outer_1"),
        ({"faults.outer_1.widht": 0.002}, r"unknown parameter 'faults.outer_1.widht'; did you mean 'faults.outer_1.width'\?"),
        ({"faults.broken_bars": "row3/bar1"}, r"row3/bar1 is outside row1/bar1 .. row2/bar16"),
        ({"faults.broken_bars": ""}, r"row1/bar15 is broken and does not heal"),
        ({"bearing.roller_radius": 0.01}, r"bearing.roller_radius is fixed while the bench runs"),
        ({"sensor.sampling_rate": 25600}, r"sensor.sampling_rate is fixed"),
    ],
)
def test_impossible_changes_are_refused_with_the_reason(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        BROKEN.change(changes)


BROKEN = bench(faults={"broken_bars": "row1/bar15"})


def test_changes_are_checked_together_with_pending_ones() -> None:
    simulation = bench()
    simulation.change({"faults.outer_1.width": 0.002})
    with pytest.raises(Refusal, match=r"faults.outer_2 overlaps faults.outer_1"):
        simulation.change({"faults.outer_2.width": 0.002})
    list(simulation.blocks(0.02))
    assert set(simulation.configuration.faults.described()) == {"outer_1"}


def test_a_change_is_checked_after_a_pending_one_of_the_same_parameter() -> None:
    simulation = bench()
    simulation.change({"faults.broken_bars": "row1/bar15"})
    with pytest.raises(Refusal, match=r"row1/bar15 is broken and does not heal"):
        simulation.change({"faults.broken_bars": ""})
    assert simulation.check_change({}).faults.broken_bars == "row1/bar15"


def test_a_change_is_checked_after_what_a_scenario_has_changed_since() -> None:
    pending, present = PendingCommands(), load_configuration("dry")

    def alter(changes: Mapping[str, Any], after: Configuration | None) -> Configuration:
        return altered(present if after is None else after, changes)

    pending.add_change({"operating.load": 50e3}, alter)
    present = altered(present, {"faults.broken_bars": "row1/bar3"})  # by the scenario
    with pending.lock:
        pending.rebase(alter)
    with pytest.raises(Refusal, match="bar3 is broken and does not heal"):
        pending.add_change({"faults.broken_bars": "row1/bar5"}, alter)
    assert pending.check_change({"faults.broken_bars": "row1/bar3,row1/bar5"}, alter).operating.load == 50e3


def test_a_change_is_pending_until_it_is_in_the_configuration(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = bench()
    simulation.change({"faults.outer_1.width": 0.002})
    assert simulation.has_pending
    with ThreadPoolExecutor(1) as other:
        looks: list[Future[tuple[bool, Configuration]]] = []

        def amid(*arguments: Any) -> Configuration:
            looks.append(other.submit(lambda: (simulation.has_pending, simulation.configuration)))
            wait(looks, timeout=0.1)
            return altered(*arguments)

        monkeypatch.setattr("dcrb_ros.simulation.loop.altered", amid)
        next(simulation.blocks(0.02))
        awaited, configuration = looks[0].result(timeout=400.0)
    assert (awaited, configuration.faults.outer_1.width) == (False, 0.002)
