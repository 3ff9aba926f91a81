"""Signals at instants at which programs failed before; `make signals` draws random ones."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

import signals as random_signals
from node_arguments import parameters
from ros_bench import PATIENCE, domain, environment, node
from waiting import wait_for

pytestmark = [pytest.mark.node, pytest.mark.slow]


@pytest.mark.parametrize(
    ("program", "kind", "instant", "second"),
    [
        ("bench", signal.SIGINT, 0.4, None),
        ("bench", signal.SIGKILL, 2.5, None),
        ("simulator", signal.SIGTERM, 2.5, 0.5),
        ("fault_detector", signal.SIGINT, 1.0, 0.3),
        ("replayer", signal.SIGTERM, 0.3, None),
    ],
)
def test_a_signal_leaves_no_traceback_no_process_and_no_file(
    program: str, kind: signal.Signals, instant: float, second: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(random_signals, "PATIENCE", PATIENCE / 4.0)
    outcome = random_signals.fire(random_signals.Shot(program, kind, instant, second), tmp_path, domain())
    assert outcome.flaws == (), outcome.output


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_vehicle_while_its_kernels_are_compiled(kind: signal.Signals, tmp_path: Path) -> None:
    env = environment(domain(), NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    arguments = ["--vehicle", "bogie", *parameters(recording__path=str(tmp_path / "bag"))]
    with node("vehicle_simulator", arguments, env, tmp_path / "log") as simulator:
        wait_for(lambda: "compiling the kernels" in simulator.output, PATIENCE)
        assert simulator.end_promptly(kind) == 0
        assert "Traceback" not in simulator.output
    assert not (tmp_path / "bag").exists()
