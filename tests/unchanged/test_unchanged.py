"""The rebuild of the code base changes no sample, message, verdict or mark: everything is compared with the code before it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cases
import numpy as np
import pytest
from typer.testing import CliRunner

from dcrb_ros.cli.app import app
from dcrb_ros.recordings.manifest import software
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.reproduction import Reproduction
from dcrb_ros.simulation.loop import Simulation

KNOWN: dict[str, Any] = json.loads(cases.FILE.read_text())
BAGS = sorted(path.parent for path in (cases.ROOT / "bags").glob("*/metadata.yaml"))
LIBRARIES = ("numpy", "numba", "scipy", "machine")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        any(software()[name] != KNOWN["software"][name] for name in LIBRARIES),
        reason=f"the fingerprints were taken with {KNOWN['software']}; other versions may differ in the last bit",
    ),
]


def spoken(*arguments: str) -> Any:
    """Return the JSON that a command prints."""
    result = CliRunner().invoke(app, arguments)
    return json.loads(result.stdout)


@pytest.mark.parametrize("name", [*cases.CASES, *cases.OILED_CASES])
def test_samples_and_messages_are_unchanged(name: str) -> None:
    if name in cases.BY_NUMPY and software()["numpy_functions"] != KNOWN["software"]["numpy_functions"]:
        pytest.skip("numpy has other functions on this processor than where the fingerprints were taken")
    assert cases.run(name) == KNOWN["cases"][name]


def test_a_run_with_a_scenario_and_commands_is_unchanged(tmp_path: Path) -> None:
    assert cases.run_scenario(tmp_path) == KNOWN["cases"]["scenario"]


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_shipped_recordings_are_reproduced_bit_for_bit(bag: Path) -> None:
    reproduction = Reproduction(Recording(bag))
    made = [block.acceleration for block in reproduction.blocks(Simulation(reproduction.configuration))]
    kept = [block.acceleration for block in Recording(bag).vibrations()]
    assert np.array_equal(np.concatenate(made), np.concatenate(kept))


@pytest.mark.parametrize("bag", BAGS, ids=lambda bag: bag.name)
def test_verdicts_on_the_shipped_recordings_are_unchanged(bag: Path) -> None:
    assert cases.verdicts(spoken("detect", str(bag), "--json")) == cases.verdicts(KNOWN["verdicts"][bag.name])


def test_marks_of_the_smoke_exam_of_the_dry_bench_are_unchanged() -> None:
    assert cases.marks(spoken("score", str(cases.FILE.with_name("dry_smoke.yaml")), "--json")) == cases.marks(KNOWN["marks"])
