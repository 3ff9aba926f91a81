"""The status of the simulator on /diagnostics."""

from __future__ import annotations

import time
from collections.abc import Sequence

from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status
from dcrb_ros.nodes.pacing import MAX_LAG
from dcrb_ros.nodes.ros import installed
from dcrb_ros.nodes.served import ServedNode
from dcrb_ros.nodes.simulation_interfaces import PACKAGE
from dcrb_ros.stream.states import LubricationState, ThermalState

SERVICES = ("pause", "step", "reset", "record", "set_simulation_state", "step_simulation", "reset_simulation")
"""Services that may refuse a call."""
ACTIONS = ("simulate_steps",)
"""Actions that may refuse a goal."""


def _lubrication(state: LubricationState | None) -> dict[str, str]:
    """Return the values of a lubricated bearing; none for a dry one."""
    if state is None:
        return {}
    return {
        "film [um]": f"{1e6 * state.film.min():.3f}",
        "film_ratio": f"{state.film_ratio.min():.2f}",
        "friction_power [W]": f"{state.friction_power.sum():.1f}",
    }


def _temperatures(state: ThermalState | None) -> dict[str, str]:
    """Return the temperatures of the warmest row, of box and surroundings, and the heat of all rows; none without a thermal network."""
    if state is None:
        return {}
    return {
        "inner_ring [deg C]": f"{state.inner_ring_temperature.max():.1f}",
        "outer_ring [deg C]": f"{state.outer_ring_temperature.max():.1f}",
        "box [deg C]": f"{state.box_temperature:.1f}",
        "ambient [deg C]": f"{state.ambient_temperature:.1f}",
        "heat [W]": f"{state.heat.sum():.1f}",
        "clamped_temperatures": str(state.clamped),
    }


class BenchStatus:
    """Composes the status, with the real-time factor since the previous one."""

    def __init__(self, node: ServedNode) -> None:
        """Compose the status of a node."""
        self._node, self._engine = node, node.engine
        self._simulated, self._wall = 0.0, time.monotonic()

    def status(self, name: str, time_ns: int, others: Sequence[str] = ()) -> Status:
        """Return the status of the node ``name`` at a simulated time, with the names of the other nodes that publish on its topics."""
        node, gate, progress, recording, model = self._node, self._engine.gate, self._node.progress, self._node.recording, self._model()
        behind = gate.pacer.lag > MAX_LAG and not gate.paused
        warning, more = node.about() if self._engine.prepared else ("", {})
        if self._starting() or not self._engine.prepared:
            warning = warning or node.compiling
        factor = self._real_time_factor(time_ns * 1e-9)
        failure = self._failure()
        level = ERROR if failure else WARN if behind or others or warning else OK
        count = node.refusals.count
        residual = progress.energy_residual  # the engine may reset it at any time
        values = {
            "time_scale": f"{gate.pacer.scale:g}",
            "real_time_factor": f"{factor:.3f}" if self._engine.computed else "",
            "simulated [s]": f"{time_ns * 1e-9:.3f}",
            "lag [s]": f"{gate.pacer.lag:.4f}",
            "late_blocks": str(gate.pacer.late),
            "blocks": str(progress.bundles),
            "rejected_commands": str(count(*(topic.name for topic in node.commands))),
            "rejected_messages": str(count(*(topic.name for topic in node.detected))),
            "rejected_parameters": str(count("parameters")),
            "rejected_calls": str(count(*SERVICES, *ACTIONS)),
            "recorder": recording.state,
            "recording": str(recording.path or ""),
            "simulation_interfaces": "offered" if installed(PACKAGE) else "not installed",
            **({} if residual is None else {"energy_residual [J]": f"{residual:.4g}"}),
            "model": model,
            "other_publishers": ", ".join(others),
            **_lubrication(progress.lubrication),
            **_temperatures(progress.thermal),
            **more,
        }
        message = warning or (node.behind if behind else "others publish on the same topics" if others else model)
        return Status(name, level, failure or message, values)

    def _failure(self) -> str:
        """Return why the simulation or the last recording failed, or ""."""
        error = self._engine.failure
        if error is not None:
            return str(error) or type(error).__name__
        return self._node.recording.state if self._node.recording.failed else ""

    def _model(self) -> str:
        """Return what the model does.

        That is ``failed``, ``loading``, ``paused``, ``waiting`` for subscribers, ``starting`` until the first block is computed, or
        ``running``.
        """
        if self._engine.failure is not None:
            return "failed"
        if not self._engine.prepared:
            return "loading"
        if self._engine.gate.paused:
            return "paused"
        return "starting" if self._starting() else "running" if self._engine.started else "waiting"

    def _starting(self) -> bool:
        """Return whether the first block is being computed."""
        return self._engine.started and not self._engine.ended and not self._engine.computed

    def _real_time_factor(self, simulated: float) -> float:
        """Return simulated over wall time since the last call; 0 right after a reset."""
        now = time.monotonic()
        factor = max(0.0, simulated - self._simulated) / max(now - self._wall, 1e-3)
        self._simulated, self._wall = simulated, now
        return factor
