"""The page on adding a fault, followed literally: one new file and one line make a fault known everywhere."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from typing import Any

import pytest
from how_to import ROOT, copied_package, effort, run

pytestmark = pytest.mark.slow

PAGE = ROOT / "docs" / "how-to" / "add-a-fault.md"
# The kernels come from the package itself, where they are compiled already.
PRELUDE = f"import dcrb_ros; dcrb_ros.__path__.append({str(ROOT / 'dcrb_ros')!r})\n"

SCRIPT = """
import json
import numpy as np
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.messages.statuses import decode_truth, encode_truth
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.sweep.label import fault_label
from dcrb_ros.viewer.row_faults import faults_of_row

def bench(**faults):
    return Simulation(Configuration.model_validate({"faults": faults}))

def samples(simulation, duration=0.02):
    return np.concatenate([block.acceleration for block in simulation.blocks(duration)])

simulation = bench()
before = samples(simulation)
simulation.change({"faults.fluting_1.width": 0.02, "faults.fluting_1.azimuth": 0.02})
blocks = list(simulation.blocks(0.02))
truths = [decode_truth(encode_truth(truth)) for block in blocks for truth in block.truths]
print(json.dumps({
    "changed": bool(np.any(samples(bench(fluting_1={"width": 0.02})) != before)),
    "at run time": bool(np.any(np.concatenate([block.acceleration for block in blocks]) != samples(bench(), 0.04)[len(before):])),
    "truth": truths[-1].faults,
    "class": class_of(truths[-1].faults),
    "label": fault_label(truths),
    "words": faults_of_row(truths[-1], 0).words,
    "drawn": [mark.ring for mark in faults_of_row(truths[-1], 0).raceways],
}))
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, str]:
    folder = tmp_path_factory.mktemp("copy")
    environment = copied_package(folder, PAGE)
    shutil.rmtree(folder / "dcrb_ros" / "core")
    return {key: value for key, value in environment.items() if key != "NUMBA_CACHE_DIR"}


@pytest.fixture(scope="module")
def found(environment: Mapping[str, str]) -> Any:
    return json.loads(run(environment, PRELUDE + SCRIPT))


def dcrb(environment: Mapping[str, str], *arguments: str) -> str:
    return run(environment, f"{PRELUDE}import sys; sys.argv = {['dcrb', *arguments]!r}\nfrom dcrb_ros.cli.app import main; main()")


def test_a_fault_is_one_file_and_one_line() -> None:
    assert effort(PAGE) == (1, 1)


def test_the_commands_know_its_parameters(environment: Mapping[str, str]) -> None:
    assert "faults.fluting_1.width" in dcrb(environment, "config", "docs")
    assert "fluting_1:" in dcrb(environment, "config", "show", "healthy")
    dcrb(environment, "config", "check", "healthy", "--set", "faults.fluting_1.width=0.02")


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (("faults.fluting_1.width=1.0",), "faults.fluting_1.width = 1.0 m is outside 0 .. 0.1 m"),
        (("faults.fluting_1.width=1e-3",), "faults.fluting_1.width = 0.001 m is outside 0.002 .. 0.343 m, from a period to half a turn"),
        (("faults.fluting_1.width=0.02", "faults.fluting_1.depth=5e-5"), "faults.fluting_1.depth = 5e-05 m is above 7.19e-06 m"),
        (("faults.fluting_1.size=1e-3",), "unknown parameter 'faults.fluting_1.size'"),
    ],
)
def test_impossible_values_are_refused_in_a_sentence(environment: Mapping[str, str], settings: tuple[str, ...], sentence: str) -> None:
    script = f"""
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
try:
    load_configuration("dry", {settings!r})
except Refusal as refusal:
    print(refusal)
"""
    assert sentence in run(environment, PRELUDE + script)


def test_it_overlaps_no_other_fault_on_its_raceway(environment: Mapping[str, str]) -> None:
    script = """
from dcrb_ros.settings.configuration import Configuration
try:
    Configuration.model_validate({"faults": {"fluting_1": {"width": 0.02}, "outer_1": {"width": 1e-3}}})
except ValueError as error:
    print(error)
"""
    assert "faults.fluting_1 overlaps faults.outer_1" in run(environment, PRELUDE + script)


def test_it_changes_the_samples_from_the_start_and_at_run_time(found: Any) -> None:
    assert found["changed"]
    assert found["at run time"]


def test_the_ground_truth_names_it(found: Any) -> None:
    fields = found["truth"]["fluting_1"]
    assert {key: fields[key] for key in ("width", "period", "depth", "azimuth")} == {
        "width": 0.02,
        "period": 0.002,
        "depth": 5e-6,
        "azimuth": 0.02,
    }
    assert fields["onset"] == pytest.approx(0.02, abs=1e-3)


def test_exams_and_sweeps_expect_its_verdict(found: Any) -> None:
    assert found["class"] == found["label"]["fault"] == "outer_ring"
    assert found["label"]["width"] == 0.02


def test_the_viewer_draws_and_names_it(found: Any) -> None:
    assert found["words"] == ["fluting_1: 20 mm fluted with a period of 2 mm"]
    assert found["drawn"] == ["outer_ring"]
