"""The page on adding a sensor stage, followed literally."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from how_to import ROOT, copied_package, effort, run

PAGE = ROOT / "docs/how-to/add-a-sensor-stage.md"

MEASURE = """
import json
import numpy as np
from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.settings.configuration import Configuration

def samples(splits, **sensor):
    quiet = {"noise_density": 0.0, "adc_bits": 0}
    setup = Configuration.model_validate({"sensor": {**quiet, **sensor}}).measurement
    chain, count = Sensor(setup), setup.step_rate // splits
    parts = [chain.measure(np.full((count, 2), 10.0), np.zeros(count)).measured for _ in range(splits)]
    return np.concatenate(parts)

warm = {"warm_up_error": -0.1, "warm_up_time": 0.5}
print(json.dumps({
    "without": samples(1)[-1].tolist(),
    "with": samples(1, **warm)[-1].tolist(),
    "count": len(samples(1)),
    "split": bool(np.array_equal(samples(1, **warm), samples(8, **warm))),
}))
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return copied_package(tmp_path_factory.mktemp("package"), PAGE)


def test_a_stage_is_one_file_and_one_line() -> None:
    assert effort(PAGE) == (1, 1)


@pytest.mark.slow
def test_the_new_stage_changes_the_samples_as_described(environment: dict[str, str]) -> None:
    found = json.loads(run(environment, MEASURE))
    assert found["without"] == pytest.approx([10.0, 10.0])
    gain = 1.0 - 0.1 * (1.0 - 2.718281828459045 ** (-(found["count"] - 1) / 51200.0 / 0.5))
    assert found["with"] == pytest.approx([10.0 * gain, 10.0 * gain])
    assert found["split"]


def test_its_parameters_are_in_the_parameter_table(environment: dict[str, str]) -> None:
    table = run(
        environment, "import sys; sys.argv = ['dcrb', 'config', 'docs']; from dcrb_ros.cli.app import app; app(standalone_mode=False)"
    )
    (row,) = (line for line in table.splitlines() if "`sensor.warm_up_error`" in line)
    assert "-0.5 to 0.5" in row


def test_a_field_declared_twice_is_refused(tmp_path: Path) -> None:
    environment = copied_package(tmp_path, PAGE)
    stage = tmp_path / "dcrb_ros/measurement/stages/warm_up.py"
    stage.write_text(stage.read_text(encoding="utf-8").replace("warm_up_time", "bandwidth"), encoding="utf-8")
    code = "try:\n    import dcrb_ros.settings.sensor\nexcept TypeError as error:\n    print(error)"
    assert "SensorParameters has two fields with the name bandwidth" in run(environment, code)
