"""The status of the simulator on /diagnostics."""

from __future__ import annotations

import time

from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status
from dcrb_ros.messages.topics import DETECTED
from dcrb_ros.nodes.engine import Engine, Progress
from dcrb_ros.nodes.recording_switch import RecordingSwitch
from dcrb_ros.nodes.refusals import Refusals

COMMANDS = ("command/speed", "command/load")
SERVICES = ("pause", "step", "reset", "record")
MAX_LAG = 0.1
"""Lag above which the status is a warning [s]."""


class BenchStatus:
    """Composes the status, with the real-time factor since the previous one."""

    def __init__(self, engine: Engine, progress: Progress, recording: RecordingSwitch, refusals: Refusals) -> None:
        self._engine, self._progress, self._recording, self._refusals = engine, progress, recording, refusals
        self._simulated, self._wall = 0.0, time.monotonic()

    def status(self, name: str) -> Status:
        """Return the present status of the node ``name``."""
        gate, progress, recording = self._engine.gate, self._progress, self._recording
        model = "failed" if self._engine.failure is not None else "paused" if gate.paused else "running"
        behind = gate.pacer.lag > MAX_LAG and not gate.paused
        level = ERROR if recording.failed else WARN if behind else OK
        count = self._refusals.count
        values = {
            "time_scale": f"{gate.pacer.scale:g}",
            "real_time_factor": f"{self._real_time_factor(progress.time_ns * 1e-9):.3f}",
            "simulated [s]": f"{progress.time_ns * 1e-9:.3f}",
            "lag [s]": f"{gate.pacer.lag:.4f}",
            "late_blocks": str(gate.pacer.late),
            "blocks": str(progress.bundles),
            "rejected_commands": str(count(*COMMANDS)),
            "rejected_messages": str(count(*(topic.name for topic in DETECTED))),
            "rejected_parameters": str(count("parameters")),
            "rejected_calls": str(count(*SERVICES)),
            "recorder": recording.state,
            "recording": str(recording.path or ""),
            "energy_residual [J]": f"{progress.energy_residual:.4g}",
            "model": model,
        }
        message = recording.state if level == ERROR else "behind real time" if behind else model
        return Status(name, level, message, values)

    def _real_time_factor(self, simulated: float) -> float:
        """Return simulated over wall time since the last call; 0 right after a reset."""
        now = time.monotonic()
        factor = max(0.0, simulated - self._simulated) / max(now - self._wall, 1e-3)
        self._simulated, self._wall = simulated, now
        return factor
