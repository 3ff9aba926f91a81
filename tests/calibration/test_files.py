"""The files of a calibration, and the commands that write and read them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import dcrb_ros
from dcrb_ros.calibration.files import intervals_of
from dcrb_ros.cli.app import app
from dcrb_ros.settings.files import load_configuration

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a machine in relative units with one axis at 25.6 kHz, imported."""
    folder = tmp_path_factory.mktemp("machine")
    settings = {
        "sensor.sampling_rate": 25600,
        "structure.gain_y": 0.02,
        "sensor.noise_density": 1e-4,
        "structure.path_y": "2000 0.04 2600 0.05",
    }
    run = dcrb_ros.simulate("healthy", 4.0, settings=settings)
    np.savez(folder / "run.npz", a=run.acceleration[:, 1])
    about = {"channels": {"ax": "a"}, "sampling_rate": 25600, "unit": "relative", "speed_rpm": 1200.0, "orders": run.orders.as_dict()}
    (folder / "about.yaml").write_text(json.dumps(about), encoding="utf-8")
    done = CliRunner().invoke(
        app, ["import", str(folder / "run.npz"), "--about", str(folder / "about.yaml"), "-o", str(folder / "recording")]
    )
    assert done.exit_code == 0, done.output
    done = CliRunner().invoke(app, ["calibrate", str(folder / "recording"), "-o", str(folder / "mine.yaml"), "--json"])
    assert done.exit_code == 0, done.output
    (folder / "printed.json").write_text(done.stdout, encoding="utf-8")
    return folder


def test_the_configuration_is_valid_and_has_the_rate_and_the_path_of_the_machine(machine: Path) -> None:
    checked = CliRunner().invoke(app, ["config", "check", str(machine / "mine.yaml")])
    assert checked.exit_code == 0, checked.output
    found = load_configuration(machine / "mine.yaml")
    assert found.sensor.sampling_rate == 25600
    assert found.structure.path_x == found.structure.path_y != ""
    assert found.structure.gain_y == pytest.approx(0.02, rel=0.2)
    assert found.sensor.noise_density == pytest.approx(1e-4, rel=0.2)


def test_the_intervals_are_axes_of_a_sweep_that_the_configuration_accepts(machine: Path) -> None:
    axes = intervals_of(machine / "mine.yaml")
    assert {"structure.gain_x", "structure.gain_y", "structure.seed"} <= axes.keys()
    for key, axis in axes.items():
        assert axis["low"] < axis["high"]
        for end in ("low", "high"):
            load_configuration(machine / "mine.yaml", {key: axis[end]})


def test_the_figure_and_the_printed_numbers_are_there(machine: Path) -> None:
    assert (machine / "mine.png").read_bytes().startswith(b"\x89PNG")
    printed = json.loads((machine / "printed.json").read_text(encoding="utf-8"))
    assert printed["comparison"]["axes"]["y"]["level_distance_db"] < 4.0
    assert any("relative" in sentence for sentence in printed["unidentified"])
    assert any("one axis" in sentence for sentence in printed["unidentified"])


def test_an_existing_configuration_is_not_replaced(machine: Path) -> None:
    done = CliRunner().invoke(app, ["calibrate", str(machine / "recording"), "-o", str(machine / "mine.yaml")])
    assert isinstance(done.exception, dcrb_ros.Refusal)
    assert "exists" in str(done.exception)


def test_a_file_without_intervals_is_refused(tmp_path: Path) -> None:
    (tmp_path / "other.intervals.yaml").write_text("vary: 3\n", encoding="utf-8")
    with pytest.raises(dcrb_ros.Refusal, match="has no ranges below 'vary'"):
        intervals_of(tmp_path / "other.yaml")


def test_compare_prints_distances_and_json(machine: Path, tmp_path: Path) -> None:
    both = [str(machine / "recording"), str(machine / "recording")]
    said = CliRunner().invoke(app, ["compare", *both, "-o", str(tmp_path / "same.svg")])
    assert said.exit_code == 0, said.output
    assert "y: third octaves 0.0 dB apart" in said.output
    assert (tmp_path / "same.svg").stat().st_size > 10_000
    printed = json.loads(CliRunner().invoke(app, ["compare", *both, "--json"]).stdout)
    assert printed["axes"]["y"]["envelope_distance"] == 0.0
    assert printed["features"]["y_rms"][0] == printed["features"]["y_rms"][1]
