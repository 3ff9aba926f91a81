"""Temperatures in the arrays of a run, of its recording, and in their tables."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import dcrb_ros
from dcrb_ros.cli.app import app
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.nodes.bench_status import _temperatures
from dcrb_ros.nodes.engine import Progress
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dcrb_ros.SimulationResult, list[Block]]:
    """Return the recording of a warm bearing, the same run as arrays, and its blocks."""
    configuration, path = dcrb_ros.load_configuration("healthy", {"thermal.law": "network"}), tmp_path_factory.mktemp("warm") / "bag"
    simulation = Simulation(configuration)
    blocks = list(simulation.blocks(1.1))
    with Recorder(path, configuration, simulation.bodies) as recorder:
        for block in blocks:
            recorder.write(block)
    return path, dcrb_ros.simulate(configuration, 1.1), blocks


def test_a_run_has_the_readings_of_its_sensors(warm: tuple[Path, dcrb_ros.SimulationResult, list[Block]]) -> None:
    path, run, blocks = warm
    readings = [reading for block in blocks for reading in block.temperatures]
    for found in (run.temperatures, Recording(path).temperatures()):
        assert found.time.tolist() == [0.0, 1.0]
        assert found.outer_ring.tolist() == [reading.outer_ring for reading in readings]
        assert found.box.tolist() == [reading.box for reading in readings]
        assert found.ambient.tolist() == [reading.ambient for reading in readings]
    frame = run.temperatures.to_pandas()
    assert (frame.index.name, list(frame.columns)) == ("time", ["outer_ring", "box", "ambient"])
    assert len(run.temperatures.between(0.5, 2.0)) == 1
    assert "at the end outer_ring" in repr(run.temperatures)


def test_the_truth_has_all_temperatures_over_time(warm: tuple[Path, dcrb_ros.SimulationResult, list[Block]]) -> None:
    path, run, _ = warm
    for truth in (run.truth, Recording(path).truth()):
        box = truth.thermal("box [deg C]")
        assert box.shape == truth.time.shape
        assert box == pytest.approx(np.interp(truth.time, run.states.time, run.states.box_temperature), abs=0.02)
        frame = truth.to_pandas()
        assert frame["box [deg C]"].tolist() == box.tolist()
        assert {"row2/rollers [deg C]", "row1/rest [W]", "clearance_change [m]"} <= set(frame.columns)
        with pytest.raises(Refusal, match="the ground truth has no 'box'"):
            truth.thermal("box")


def test_the_table_of_states_has_the_temperatures_by_body(warm: tuple[Path, dcrb_ros.SimulationResult, list[Block]]) -> None:
    _, run, _ = warm
    found = run.states.to_pandas()["temperature"]
    assert [str(name) for name in found.columns] == [
        *(f"row{row}/{part}" for row in (1, 2) for part in ("inner_ring", "rollers", "outer_ring")),
        *("box", "ambient"),
    ]
    assert run.states.roller_temperature is not None
    assert found["row2/rollers"].tolist() == run.states.roller_temperature[:, 1].tolist()
    assert (found["box"] > found["ambient"]).all()


def test_a_cold_bench_has_no_temperatures() -> None:
    run = dcrb_ros.simulate("dry", 0.05)
    assert len(run.temperatures) == 0
    assert repr(run.temperatures) == "<TemperatureReadings: none>"
    assert "temperature" not in run.states.to_pandas()
    assert list(run.truth.to_pandas().columns) == ["speed", "load_x", "load_y", "FTF", "BPFO", "BPFI", "BSF", "faults", "event"]
    with pytest.raises(Refusal, match=r"it has no temperatures: simulate with thermal.law = network"):
        run.truth.thermal("box [deg C]")


def test_the_status_of_the_node_has_the_present_temperatures(warm: tuple[Path, dcrb_ros.SimulationResult, list[Block]]) -> None:
    progress, (_, _, blocks) = Progress(), warm
    for block in blocks:
        progress.write(Bundle(block.stamp_ns, block.end_ns, (), block))
    found, last = _temperatures(progress.thermal), blocks[-1].states[-1].thermal
    assert last is not None
    assert found["box [deg C]"] == f"{last.box_temperature:.1f}"
    assert found["heat [W]"] == f"{last.heat.sum():.1f}"
    assert set(found) == {
        *("inner_ring [deg C]", "outer_ring [deg C]", "box [deg C]", "ambient [deg C]", "heat [W]", "clamped_temperatures")
    }
    assert _temperatures(None) == {}


def test_the_example_draws_a_recording(
    warm: tuple[Path, dcrb_ros.SimulationResult, list[Block]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(sys, "argv", ["burn_off.py", str(warm[0]), "-o", str(tmp_path / "picture.png")])
    runpy.run_path(str(Path(__file__).parents[2] / "examples" / "burn_off.py"), run_name="__main__")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
    assert f"at most {warm[1].states.inner_ring_temperature[:, 0].max():.0f} °C" in capsys.readouterr().out  # type: ignore[index]


def test_info_and_plot_show_the_readings(warm: tuple[Path, dcrb_ros.SimulationResult, list[Block]], tmp_path: Path) -> None:
    path, run, _ = warm
    said = CliRunner().invoke(app, ["info", str(path)])
    assert "2 readings of temperature, at 0.000 s outer_ring" in said.output
    assert f"box {run.temperatures.box[-1]:.4g} deg C" in said.output
    assert "temperature [deg C]" in said.output
    drawn = CliRunner().invoke(app, ["plot", str(path), "-o", str(tmp_path / "warm.svg")])
    assert drawn.exit_code == 0, drawn.output
    assert "<!-- temperature [°C] -->" in (tmp_path / "warm.svg").read_text(encoding="utf-8")
