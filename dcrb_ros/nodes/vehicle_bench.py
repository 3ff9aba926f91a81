"""The bench of a vehicle in one command: simulator and comparing detector as processes, with a status line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.joints import decode_joints
from dcrb_ros.messages.statuses import OK, Status, decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, FEATURES, VIBRATION, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DIAGNOSIS
from dcrb_ros.messages.vehicle import box_path
from dcrb_ros.nodes.bench import Bench, Observer
from dcrb_ros.nodes.vehicle_detector_input import VehicleDetectorSettings
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.vehicle.description import Vehicle


class VehicleObserver(Observer):
    """Keeps the last messages of a vehicle for the status line and the result."""

    simulator, needs = "vehicle_simulator", "turning shafts"

    def __init__(self, vehicle: Vehicle) -> None:
        super().__init__()
        self._boxes = [box_path(box.name) for box in vehicle.boxes]
        self._latest: dict[str, Status] = {}
        self._rms: dict[str, float] = {}

    def topics(self) -> Mapping[Topic, Callable[[bytes], None]]:
        """Return what takes the messages of each topic."""
        features: dict[Topic, Callable[[bytes], None]] = {FEATURES.below(box): partial(self._on_box, box) for box in self._boxes}
        return {
            VEHICLE_DIAGNOSIS: self._on_diagnosis,
            BENCH_DIAGNOSTICS: self._on_bench,
            VEHICLE_DESCRIPTION: lambda data: None,
            **features,
            VIBRATION.below(self._boxes[0]): self._on_block,
        }

    def _on_box(self, box: str, data: bytes) -> None:
        joints = decode_joints(data)
        values = dict(zip(joints.names, joints.position, strict=False))
        if "rms" not in values:
            raise Refusal("a JointState without rms does not contain the features of a box")
        self._rms[box], self.features = float(values["rms"]), joints

    def _on_diagnosis(self, data: bytes) -> None:
        time_ns, statuses = decode_diagnostics(data)
        if not statuses:
            raise Refusal("a diagnosis without a status has no verdict")
        self._latest |= {status.name: status for status in statuses}
        self.verdict_ns = time_ns

    @property
    def statuses(self) -> list[Status]:
        """The latest verdict on each part."""
        return list(self._latest.values())

    @property
    def findings(self) -> list[Status]:
        """The verdicts that report something."""
        return [status for status in self.statuses if status.message not in ("healthy", "waiting")]

    def verdicts(self) -> list[str]:
        """Return the verdicts that report something in words, and the number of the others; none without a verdict."""
        if all(status.message == "waiting" for status in self.statuses):
            return []
        findings = [f"verdict: {status.name} {status.message} {self.evidence(status)}" for status in self.findings]
        return [*findings, *([f"parts without a finding: {self.others}"] if self.others else [])]

    @property
    def others(self) -> str:
        """The number of parts of each verdict that reports nothing, such as ``10 healthy, 4 waiting``."""
        quiet = Counter(status.message for status in self.statuses if status not in self.findings)
        return ", ".join(f"{count} {message}" for message, count in quiet.items())

    def line(self) -> str:
        """Return the status line."""
        if self.features is None:
            return "waiting for the first block ..."
        parts = [f"{self.features.stamp_ns * 1e-9:6.2f} s simulated", *self.pace()]
        if self.bench is not None and self.bench.level != OK:
            parts.append(self.bench.message)
        levels = (f"{self._rms[box]:.0f}" if box in self._rms else "-" for box in self._boxes)
        parts.append(f"rms {' '.join(levels)} m/s^2")
        if self.statuses:
            messages = {status.message for status in self.statuses}
            found = ", ".join(f"{status.name} {status.message}" for status in self.findings)
            alike = {"healthy": "all healthy", "waiting": "waiting"}[messages.pop()] if len(messages) == 1 and not found else ""
            parts.append("->  " + (found or alike or self.others))
        return "  |  ".join(parts)


def vehicle_bench(
    name: str, parameters: Mapping[str, Any], vehicle: Vehicle, box_parameters: DetectorParameters, *, shown: bool = False
) -> Bench:
    """Return the bench of a vehicle, given by its ``parameters`` by dotted keys at the start of the run; with ``shown`` Rerun shows it."""
    least = vehicle.boxes[0].configuration.publishing.listeners
    return Bench(
        f"'{name}': {len(vehicle.boxes)} axle boxes and the detector that compares them",
        lambda listeners: {**parameters, "publishing.listeners": max(least, listeners)},
        ("vehicle_detector", VehicleDetectorSettings(boxes=box_parameters)),
        ("viewer", ["--vehicle"]) if shown else None,
        VEHICLE_DESCRIPTION,
        VehicleObserver(vehicle),
    )
