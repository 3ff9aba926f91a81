"""The recording of a vehicle: a folder with an ordinary recording of each box, the vehicle's parameters and what happened to it."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import shutil
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

from dcrb_ros.messages.points import packed
from dcrb_ros.messages.topics import NAMESPACE
from dcrb_ros.recordings.manifest import Outcome
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.reproduction import recorded_samples
from dcrb_ros.recordings.vehicle_folder import TRUTH_FILE, VEHICLE_FILE
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import read_text
from dcrb_ros.text.json import LARGEST, parsed_json
from dcrb_ros.text.writing import whole_file, write_whole
from dcrb_ros.vehicle.simulation import VehicleBlock, VehicleSimulation

FORMAT = 1


class VehicleRecorder:
    """Writes the recording of a vehicle, block by block.

    Raises:
        Refusal: the folder exists or cannot be created.
        RecordingFailed: a write failed later.
    """

    def __init__(self, path: Path, parameters: Mapping[str, Any], simulation: VehicleSimulation) -> None:
        """Begin a recording in a new folder; ``parameters`` are those of the vehicle by dotted keys."""
        self.path, self._parameters, self._simulation = path, dict(parameters), simulation
        self.outcomes: dict[str, Outcome] = {}
        """What was recorded of each box."""
        self._end_ns = 0
        self._recorders: dict[str, Recorder] = {}
        self._stack = ExitStack()

    def __enter__(self) -> VehicleRecorder:
        try:
            self.path.mkdir(parents=True)
        except OSError as error:
            raise Refusal(f"{self.path} cannot be created: {error.strerror}; give another folder") from None
        try:
            temporary = self._stack.enter_context(whole_file(self.path / TRUTH_FILE))
            self._truth = self._stack.enter_context(temporary.open("w", encoding="utf-8"))
            for box in self._simulation.vehicle.boxes:
                namespace = f"{NAMESPACE}/{box.name.replace('.', '/')}"
                bodies = self._simulation.simulations[box.name].bodies
                recorder = Recorder(self.path / box.name, box.configuration, bodies, namespace=namespace)
                self._recorders[box.name] = self._stack.enter_context(recorder)
                self.outcomes[box.name] = recorder.outcome
        except BaseException:
            self._stack.close()
            shutil.rmtree(self.path, ignore_errors=True)
            raise
        return self

    def write(self, block: VehicleBlock) -> None:
        """Record a block of every box."""
        for name, box in block.boxes.items():
            self._recorders[name].write(box)
        self._truth.write(json.dumps(dataclasses.asdict(block.truth)) + "\n")
        self._end_ns = block.end_ns

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        """Finish the recordings and write the vehicle's file; one that ends before its first block is removed."""
        self._stack.__exit__(kind, value, trace)
        if not self._end_ns:
            shutil.rmtree(self.path, ignore_errors=True)
            return
        boxes = {name: {"samples": outcome.samples, "sha256": outcome.sha256} for name, outcome in self.outcomes.items()}
        about = {
            "format": FORMAT,
            "dcrb_ros": __version__,
            "duration": self._end_ns * 1e-9,
            "boxes": boxes,
            "vehicle": self._parameters,
        }
        about["sha256"] = _digest(about)
        write_whole(self.path / VEHICLE_FILE, json.dumps(about, indent=1) + "\n")


class VehicleFile:
    """What the file of a vehicle's recording says, for a comparison with a new simulation."""

    def __init__(self, path: Path, about: Mapping[str, Any]) -> None:
        self._path = path
        self.parameters: Mapping[str, Any] = about["vehicle"]
        """Parameters of the vehicle by dotted keys."""
        self.duration = float(about["duration"])
        """[s]"""
        self.boxes: Mapping[str, Mapping[str, Any]] = about["boxes"]
        """Samples and their SHA-256 of each box."""
        self._digests = {name: hashlib.sha256() for name in self.boxes}

    def compare(self, block: VehicleBlock) -> None:
        """Add the samples of a block."""
        for name, box in block.boxes.items():
            if not box.lost:
                self._digests[name].update(packed(box.acceleration, box.shaft_angle))

    def check(self) -> None:
        """Compare the samples that were added with the recorded ones.

        Raises:
            Refusal: the recording of a box does not match its own digest, or is that of another run.
            RuntimeError: the samples of a box differ.
        """
        for name, about in self.boxes.items():
            if recorded_samples(Recording(self._path / name)).sha256 != about["sha256"]:
                raise Refusal(f"{self._path / name} is not the recording that {VEHICLE_FILE} names: simulate the vehicle again")
        different = [name for name, digest in self._digests.items() if digest.hexdigest() != self.boxes[name]["sha256"]]
        if different:
            raise RuntimeError(f"{self._path}: the samples of {', '.join(different)} differ from the recorded ones")


def read_vehicle_file(path: Path) -> VehicleFile:
    """Return what the file in the folder of a vehicle's recording says.

    Raises:
        Refusal: it cannot be read, or was changed.
    """
    about = parsed_json(read_text(path / VEHICLE_FILE, LARGEST), str(path / VEHICLE_FILE))
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise Refusal(f"{path / VEHICLE_FILE} is not the file of a vehicle's recording: give a folder made by dcrb simulate --vehicle")
    if about.pop("sha256", None) != _digest(about):
        raise Refusal(f"{path / VEHICLE_FILE} was changed or is damaged: its digest does not match; simulate the vehicle again")
    return VehicleFile(path, about)


def _digest(about: Mapping[str, Any]) -> str:
    """Return the digest of the other entries."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()
