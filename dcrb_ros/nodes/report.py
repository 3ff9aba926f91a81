"""What the simulator says of itself on /diagnostics."""

from __future__ import annotations

import time
from dataclasses import dataclass

from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status
from dcrb_ros.messages.topics import DETECTED
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.recording_switch import Tape
from dcrb_ros.nodes.refusals import Refusals

COMMANDS = ("command/speed", "command/load")
CALLS = ("pause", "step", "reset", "record")
BEHIND = 0.1
"""Lag from which on the bench warns [s]."""


@dataclass
class Progress:
    """How far the model has come."""

    simulated_ns: int = 0
    """End of the last block that went out [ns]."""
    blocks: int = 0
    residual: float = 0.0
    """What the energy account lacks [J]."""


class Report:
    """The simulator's status, with the real-time factor since the last one."""

    def __init__(self, pacer: Pacer, gate: Gate, tape: Tape, refusals: Refusals) -> None:
        self._pacer, self._gate, self._tape, self._refusals = pacer, gate, tape, refusals
        self._reached, self._at = 0.0, time.monotonic()

    def status(self, name: str, progress: Progress, *, failed: bool) -> Status:
        """Return the status of the node ``name`` now."""
        factor = self._factor(progress.simulated_ns * 1e-9)
        model = "failed" if failed else "paused" if self._gate.paused else "running"
        behind = self._pacer.lag > BEHIND and not self._gate.paused
        level = ERROR if self._tape.failed else WARN if behind else OK
        count = self._refusals.count
        values = {
            "time_scale": f"{self._pacer.scale:g}",
            "real_time_factor": f"{factor:.3f}",
            "simulated [s]": f"{progress.simulated_ns * 1e-9:.3f}",
            "lag [s]": f"{self._pacer.lag:.4f}",
            "late_blocks": str(self._pacer.late),
            "blocks": str(progress.blocks),
            "rejected_commands": str(count(*COMMANDS)),
            "rejected_messages": str(count(*(topic.name for topic in DETECTED))),
            "rejected_parameters": str(count("parameters")),
            "rejected_calls": str(count(*CALLS)),
            "recorder": self._tape.state,
            "recording": str(self._tape.path or ""),
            "energy_residual [J]": f"{progress.residual:.4g}",
            "model": model,
        }
        words = self._tape.state if level == ERROR else "behind real time" if behind else model
        return Status(name, level, words, values)

    def _factor(self, simulated: float) -> float:
        """Return simulated over wall time since the last call; 0 right after a reset."""
        now = time.monotonic()
        factor = max(0.0, simulated - self._reached) / max(now - self._at, 1e-3)
        self._reached, self._at = simulated, now
        return factor
