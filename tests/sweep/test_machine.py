"""A sweep around a calibrated machine: base and intervals of the calibration, axes of the sweep on top."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from attacked_files import ATTACKS

from dcrb_ros.calibration.files import CONFIGURATION_DIGEST, DIGEST, intervals_beside
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration, to_yaml
from dcrb_ros.sweep.design import Span
from dcrb_ros.sweep.loader import read_sweep, sweep_of
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.text.json import digest_of

VARY = {
    "structure.gain_y": {"low": 0.3, "high": 0.5, "scale": "log"},
    "sensor.noise_density": {"low": 0.001, "high": 0.002},
    "structure.seed": {"low": 1, "high": 2**31 - 1},
}
TREE = {"design": "random", "points": 10, "duration": 0.1, "cases": {"healthy": {}, "outer": {"faults.outer_1.width": 0.0005}}}


def signed(machine: Path, tree: dict[str, Any]) -> None:
    """Write the intervals of a configuration as `dcrb calibrate` signs them."""
    tree = tree | {CONFIGURATION_DIGEST: hashlib.sha256(machine.read_bytes()).hexdigest()}
    intervals_beside(machine).write_text(yaml.safe_dump(tree | {DIGEST: digest_of(tree, DIGEST)}))


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """Return a configuration with its intervals beside it, as `dcrb calibrate` writes them."""
    file = tmp_path / "my_machine.yaml"
    file.write_text(to_yaml(load_configuration("ball_bearing_6205", {"structure.gain_y": 0.4})))
    signed(file, {"vary": VARY})
    return file


def test_a_sweep_draws_machines_within_the_intervals(machine: Path) -> None:
    sweep = sweep_of({**TREE, "machine": str(machine)}, "sweep.yaml")
    assert sweep.base["bearing.rollers_per_row"] == 9
    assert sweep.vary["structure.gain_y"] == Span(0.3, 0.5, log=True)
    gains = [float(run.changes["structure.gain_y"]) for run in Plan(sweep).runs()]
    assert all(0.3 <= gain <= 0.5 for gain in gains)
    assert len({run.truth["machine"] for run in Plan(sweep).runs()}) == 10


def test_an_axis_of_the_sweep_replaces_the_interval(machine: Path) -> None:
    sweep = sweep_of({**TREE, "machine": str(machine), "vary": {"structure": {"gain_y": {"low": 0.1, "high": 0.9}}}}, "sweep.yaml")
    assert sweep.vary["structure.gain_y"] == Span(0.1, 0.9)
    assert sweep.vary["sensor.noise_density"] == Span(0.001, 0.002)


def test_the_kept_text_makes_the_same_plan_beside_the_kept_base(machine: Path, tmp_path: Path) -> None:
    plan = Plan(sweep_of({**TREE, "machine": str(machine)}, "sweep.yaml"))
    kept = tmp_path / "set"
    kept.mkdir()
    (kept / "sweep.yaml").write_text(plan.sweep.text)
    (kept / "base.yaml").write_text(to_yaml(load_configuration(str(machine))))
    again = Plan(read_sweep(kept / "sweep.yaml"))
    assert again.name == plan.name
    assert [run.name for run in again.runs()] == [run.name for run in plan.runs()]


def test_the_shipped_sweep_of_twins_lets_nothing_leak(machine: Path) -> None:
    plan = Plan(read_sweep("twin", str(machine)))
    assert plan.sweep.base["structure.gain_y"] == 0.4
    runs = list(plan.runs())
    assert {run.case for run in runs} == {"healthy", "outer", "inner", "roller"}
    for name in ("bearing_id", "machine"):
        places: dict[Any, set[str]] = {}
        for run in runs:
            places.setdefault(run.truth[name], set()).add(run.split)
        assert len(places) == plan.sweep.file.points
        assert all(len(splits) == 1 for splits in places.values())
    assert {run.split for run in runs} == {"train", "validation", "test"}


def test_intervals_of_another_form_are_refused(machine: Path) -> None:
    (machine.parent / "my_machine.intervals.yaml").write_text("estimates: {}")
    with pytest.raises(Refusal, match="has no ranges below 'vary'"):
        sweep_of({**TREE, "machine": str(machine)}, "sweep.yaml")
    (machine.parent / "my_machine.intervals.yaml").unlink()
    with pytest.raises(Refusal, match=r"my_machine\.intervals\.yaml"):
        sweep_of({**TREE, "machine": str(machine)}, "sweep.yaml")


@pytest.mark.parametrize(
    ("tree", "words"),
    [
        ({"base": "healthy"}, "give one of them"),
        ({"machine": "nowhere.yaml"}, "dcrb calibrate HEALTHY -o nowhere.yaml"),
        ({"machine": 3}, "is not a file"),
    ],
)
def test_a_machine_that_is_none_is_refused(tree: dict[str, Any], words: str, machine: Path) -> None:
    with pytest.raises(Refusal, match=words):
        sweep_of({**TREE, "machine": str(machine), **tree}, "sweep.yaml")


def other_numbers(machine: Path) -> None:
    file = intervals_beside(machine)
    file.write_text(file.read_text().replace("0.5", "5.0"))


def no_digest(machine: Path) -> None:
    intervals_beside(machine).write_text(yaml.safe_dump({"vary": VARY}))


def other_configuration(machine: Path) -> None:
    machine.write_text(to_yaml(load_configuration("ball_bearing_6205", {"structure.gain_y": 4.0})))


def intervals_of_another_machine(machine: Path) -> None:
    other = machine.with_name("other.yaml")
    other.write_text(to_yaml(load_configuration("ball_bearing_6205")))
    signed(other, {"vary": VARY})
    intervals_beside(machine).write_bytes(intervals_beside(other).read_bytes())


@pytest.mark.parametrize(
    ("attack", "sentence"),
    [
        (other_numbers, r"my_machine\.intervals\.yaml was changed: its digest does not match; calibrate again"),
        (no_digest, r"my_machine\.intervals\.yaml was changed: its digest does not match; calibrate again"),
        (other_configuration, r"my_machine\.yaml was changed after its calibration, or .* is that of another machine: calibrate again"),
        (intervals_of_another_machine, r"my_machine\.yaml was changed after its calibration, or .* is that of another machine"),
    ],
)
def test_a_changed_calibration_is_refused(attack: Callable[[Path], None], sentence: str, machine: Path) -> None:
    attack(machine)
    with pytest.raises(Refusal, match=sentence):
        sweep_of({**TREE, "machine": str(machine)}, "sweep.yaml")


@pytest.mark.parametrize("attack", ["empty", "nearly empty", "folder", "pipe", "broken link", "link to a folder", "unreadable"])
@pytest.mark.timeout(60)  # a pipe would be waited for
def test_something_else_in_place_of_the_intervals_is_refused(attack: str, machine: Path) -> None:
    ATTACKS[attack](intervals_beside(machine))
    with pytest.raises(Refusal, match=r"intervals\.yaml"):
        sweep_of({**TREE, "machine": str(machine)}, "sweep.yaml")
