"""The rows on time integration hold, and a wrong integration makes them fall short."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from dcrb_ros.validation import shorter_steps, time_integration
from dcrb_ros.validation.runs import paper_spec, simulate


@pytest.mark.slow
def test_energy_is_kept_and_a_loss_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = [row.holds for row in time_integration.energy_rows()]
    assert kept == [True] * len(time_integration.BLOWS)
    damped: dict[str, Any] = {**time_integration.LOSSLESS, "housing": {"damping": 1e4}}
    monkeypatch.setattr(time_integration, "LOSSLESS", damped)
    assert [row.holds for row in time_integration.energy_rows()] == [False] * len(kept)


def test_the_scheme_is_of_second_order_and_another_order_falls_short(monkeypatch: pytest.MonkeyPatch) -> None:
    assert time_integration.order_row().holds
    rate = np.ones((1, 2, 2))
    monkeypatch.setattr(time_integration, "passage", lambda payload, _: payload.step * rate)
    assert not time_integration.order_row().holds


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["revolute", "pocket"])
def test_forces_and_waveforms_of_a_defect_are_those_of_short_steps(joint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert shorter_steps.waveform_row(joint).holds
    traced = shorter_steps.traced
    stronger = {"force": np.array([1.005, 1.0]), "acceleration": np.array([1.05, 1.0])}
    for name, factors in stronger.items():

        def wrong(configuration: Any, ratio: int, name: str = name, factors: Any = factors) -> shorter_steps.Trace:
            trace = traced(configuration, ratio)
            return trace._replace(**{name: getattr(trace, name) * factors[0 if ratio == 1 else 1]})

        monkeypatch.setattr(shorter_steps, "traced", wrong)
        assert not shorter_steps.waveform_row(joint).holds


def test_statistics_notice_levels_and_cage_speed() -> None:
    run = simulate(paper_spec("outer ring defect", "revolute", 0.5, ("faults.outer_1.width=0.002",)))
    assert shorter_steps.statistics_row(run, run).holds
    assert not shorter_steps.statistics_row(replace(run, acceleration=1.03 * run.acceleration), run).holds
    assert not shorter_steps.statistics_row(replace(run, cage_speed=1.001 * run.cage_speed), run).holds


def test_swinging_rings_notice_twice_the_step(monkeypatch: pytest.MonkeyPatch) -> None:
    assert [row.holds for row in shorter_steps.swing_rows()] == [True, True]
    monkeypatch.setattr(shorter_steps, "SWING_STEPS", tuple(2.0 * step for step in shorter_steps.SWING_STEPS))
    assert [row.holds for row in shorter_steps.swing_rows()] == [False, False]
