"""Execution of a task: its runs are simulated in sequence, and the waveform and the label of each are written when it ends."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.bearing.reached_depth import of_widest
from dcrb_ros.messages.points import packed
from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.arrays import Samples
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, overlaid, validated
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.ground_truth import commands_in
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import ScheduledChange, scheduled_changes, starting_configuration
from dcrb_ros.stream.block import Block, Truth
from dcrb_ros.sweep.design import Value
from dcrb_ros.sweep.label import DONE, ERROR, FAILED, REFUSED, base_label, fault_label
from dcrb_ros.sweep.plan import PlannedRun, Task
from dcrb_ros.sweep.store import PART, FileRecord, Store, StoreFailed, record_of
from dcrb_ros.sweep.sweep_file import Sweep, SweepFile
from dcrb_ros.sweep.vehicles.plan import DAMAGED, TOGETHER
from dcrb_ros.sweep.vehicles.ride import Ride, ride
from dcrb_ros.sweep.vehicles.sweep import BOX, VehicleSweep
from dcrb_ros.sweep.verification import DIGEST, ERRORS, LABELS, flaw, label_name, read_label
from dcrb_ros.sweep.windows import cut_windows, waveform_file, window_labels, window_starts, windows_file
from dcrb_ros.text.json import digest_of

WAVEFORM_PUBLISHING = {"block_size": 8192, "state_rate": 1, "truth_rate": 100}
"""Parameters of `publishing` if only the waveform is written, with the ground truth for the labels; the samples do not depend on them."""


@dataclass(frozen=True)
class CommonSettings:
    """The settings common to all runs of a sweep, as sent to the workers."""

    store: Store
    base: Mapping[str, Value]
    scenarios: Mapping[str, Any]
    file: SweepFile
    vehicle: bool
    """Whether the base is a vehicle, whose boxes are runs."""
    software: tuple[str, str]
    """`software_versions` of the command."""


def common_settings(sweep: Sweep, store: Store) -> CommonSettings:
    """Return the common settings of a sweep."""
    return CommonSettings(store, sweep.base, sweep.scenarios, sweep.file, isinstance(sweep, VehicleSweep), software_versions())


def software_versions() -> tuple[str, str]:
    """Return the package version and the model fingerprint of this process."""
    return __version__, model_fingerprint()


@dataclass(frozen=True)
class RunWaveform:
    """The recorded waveform of a run and its ground truth."""

    acceleration: Samples
    """Shape (samples, 2) [m/s^2]; empty if only a bag is written."""
    shaft_angle: Samples
    """Shape (samples,) [rad]; empty if only a bag is written."""
    truths: list[Truth]
    first_index: int
    """Index of the first sample since the start of the simulation [-]."""
    samples: int
    clipped: int
    """Samples beyond the sensor's range [-]."""
    sha256: str
    """Hash of the samples, see `table.COLUMNS`."""


def run_task(common: CommonSettings, task: Task) -> list[tuple[str, str]]:
    """Simulate the runs of a task that have no label yet; return the name and the status of each run.

    Raises:
        StoreFailed: the data set cannot be written, or this process has another version or model than the command.
    """
    if common.software != software_versions():
        (version, model), (own, own_model) = common.software, software_versions()
        raise StoreFailed(
            f"a worker runs dcrb_ros {own} with model {own_model}, but the sweep runs {version} with model {model}: install the same "
            "version on all machines and run the same command again to continue"
        )
    statuses, simulated = [], _Vehicles(common) if common.vehicle else _Bearings(common)
    for run in task:
        # A lost worker may have written a valid label before it reported its task.
        label = None if flaw(common.store, run.name) else read_label(common.store, run.name)
        if label is None:
            label = _labelled(common, run, simulated)
            if label["status"] == DONE and common.file.output == "bag" and flaw(common.store, run.name):
                label = _labelled(common, run, simulated)  # a worker that was taken for lost has put its bag, which has other dates
        statuses.append((run.name, str(label["status"])))
    return statuses


def _labelled(common: CommonSettings, run: PlannedRun, simulated: _Vehicles | _Bearings) -> dict[str, Any]:
    """Simulate a run and write its files and its label; return the label."""
    label = _label(common, run, simulated)
    write_label(common.store, label)
    return label


def write_label(store: Store, label: Mapping[str, Any]) -> None:
    """Write a label with its digest; labels of errors are kept in a folder of their own, since these runs are tried again."""
    data = json.dumps({**label, DIGEST: digest_of(label, DIGEST)}, indent=1).encode()
    store.write(label_name(str(label["run"]), ERRORS if label["status"] == ERROR else LABELS), data)


def error_label(base: Mapping[str, Value], run: PlannedRun, reason: str) -> dict[str, Any]:
    """Return the label of a run that ended with an unexpected error."""
    return {**base_label(run, base), "status": ERROR, "reason": reason}


def _label(common: CommonSettings, run: PlannedRun, simulated: _Vehicles | _Bearings) -> dict[str, Any]:
    label = base_label(run, common.base)
    try:
        return {**label, **simulated.written(run), "status": DONE, "reason": ""}
    except (Refusal, ModelFailure) as failure:
        return {**label, "status": REFUSED if isinstance(failure, Refusal) else FAILED, "reason": str(failure)}
    except RecordingFailed as failure:
        raise StoreFailed(f"{failure.event}; {failure.remedy} and run the same command again to continue") from None
    except (StoreFailed, MemoryError):
        raise
    except Exception as error:
        return error_label(common.base, run, f"{type(error).__name__}: {error}")


@dataclass(frozen=True)
class _RunningSimulation:
    """A simulation that has been advanced without recording."""

    simulation: Simulation
    start: Configuration
    """Configuration at time zero."""
    truths: tuple[Truth, ...]
    """Ground truth of the time that was not recorded."""

    def skip(self, duration: float) -> _RunningSimulation:
        """Return the simulation advanced by a time that is not recorded [s]."""
        rate = self.start.sensor.sampling_rate
        blocks = self.simulation.blocks(duration) if round(duration * rate) else iter(())
        return _RunningSimulation(self.simulation, self.start, (*self.truths, *(truth for block in blocks for truth in block.truths)))


def _configured(common: CommonSettings, changes: Mapping[str, Value]) -> Configuration:
    configuration = validated(overlaid(common.base, changes), Configuration, "run")
    if common.file.output == "bag":
        return configuration
    return configuration.model_copy(update={"publishing": configuration.publishing.model_copy(update=WAVEFORM_PUBLISHING)})


class _Bearings:
    """Runs of single bearings; the healthy simulation from which the cases of a condition branch is kept for the other cases."""

    def __init__(self, common: CommonSettings) -> None:
        self._common = common
        self._healthy: tuple[str, _RunningSimulation] | None = None

    def written(self, run: PlannedRun) -> dict[str, Any]:
        """Simulate a run and write its waveform; return the part of its label that follows from the simulation."""
        common, bag = self._common, None
        running = (self._branch(run) if common.file.branch_at else _start(common, run)).skip(common.file.settle)
        if common.file.output == "bag":
            waveform, bag = _record_bag(common, run, running)
        else:
            waveform = _run_blocks(running.simulation.blocks(common.file.duration), running.truths, keep=True)
        return _outcome(common, run, waveform, running.simulation.configuration, bag)

    def _branch(self, run: PlannedRun) -> _RunningSimulation:
        """Return a simulation of a run that was healthy until the branch point, with the run's faults scheduled now."""
        if self._healthy is None or self._healthy[0] != run.twin:
            start = _configured(self._common, run.healthy)
            self._healthy = run.twin, _running(self._common, start).skip(self._common.file.branch_at)
        healthy = self._healthy[1]
        simulation = healthy.simulation.fork()
        before, after = (flatten(c.model_dump()) for c in (simulation.configuration, _configured(self._common, run.changes)))
        changes = {key: value for key, value in after.items() if value != before[key] and not key.startswith("publishing.")}
        if changes:
            simulation.change(changes)
        return _RunningSimulation(simulation, healthy.start, healthy.truths)


class _Vehicles:
    """Runs of boxes; the last vehicle is kept for its other boxes."""

    def __init__(self, common: CommonSettings) -> None:
        self._common = common
        self._last: tuple[str, Ride | Exception] | None = None

    def written(self, run: PlannedRun) -> dict[str, Any]:
        """Simulate the vehicle of a run and write the waveform of its box; return the part of the label that follows from it."""
        together, box = str(run.truth[TOGETHER]), str(run.truth[BOX])
        if self._last is None or self._last[0] != together:
            self._last = together, self._ridden(run)
        ridden = self._last[1]
        if isinstance(ridden, Exception):
            raise ridden
        waveform = _run_blocks(ridden.blocks[box], ridden.before[box], keep=True)
        return {**_outcome(self._common, run, waveform, ridden.configurations[box]), DAMAGED: ridden.damaged}

    def _ridden(self, run: PlannedRun) -> Ride | Exception:
        parameters = {**self._common.base, **{f"publishing.{key}": value for key, value in WAVEFORM_PUBLISHING.items()}, **run.changes}
        try:
            return ride(parameters, self._common.file.settle, self._common.file.duration)
        except (Refusal, ModelFailure) as failure:
            return failure


def _outcome(
    common: CommonSettings,
    run: PlannedRun,
    waveform: RunWaveform,
    configuration: Configuration,
    bag: dict[str, FileRecord] | None = None,
) -> dict[str, Any]:
    """Write windows and waveform of a run, if no ``bag`` has it; return the part of its label that follows from the simulation."""
    rate, first, file, files = configuration.sensor.sampling_rate, waveform.first_index, f"runs/{run.name}", bag
    if files is None:
        file += f".{common.file.output}"
        data = waveform_file(waveform.acceleration, waveform.shaft_angle, rate, first, common.file.output)
        files = {file: common.store.write(file, data)}
    about: dict[str, Any] = {"file": file, "sampling_rate": rate, "first_index": first, "samples": waveform.samples}
    if (windows := common.file.windows) is not None:
        starts, name = window_starts(waveform.samples, windows), f"windows/{run.split}/{run.name}.{windows.kind}"
        labels = window_labels(starts, first, rate, windows, waveform.truths)
        common_values = {"run": run.name, "case": run.case, "split": run.split}
        data = windows_file(cut_windows(waveform.acceleration, windows), labels, common_values, windows.kind)
        files[name], about["windows"] = common.store.write(name, data), len(starts)
        about["window_faults"] = sorted(set(labels["fault"].tolist()))
    size = of_widest(configuration)
    return {**fault_label(waveform.truths), **size, **about, "clipped": waveform.clipped, "sha256": waveform.sha256, "files": files}


def _start(common: CommonSettings, run: PlannedRun) -> _RunningSimulation:
    configuration = _configured(common, run.changes)
    if not run.scenario:
        return _running(common, configuration)
    scenario, source = common.scenarios[run.scenario], f"scenario {run.scenario}"
    configuration = starting_configuration(scenario, configuration, source)
    return _running(common, configuration, scheduled_changes(scenario, configuration, source))


def _running(common: CommonSettings, configuration: Configuration, events: Iterable[ScheduledChange] = ()) -> _RunningSimulation:
    return _RunningSimulation(Simulation(configuration, events, waveform_only=common.file.output != "bag"), configuration, ())


def _run_blocks(blocks: Iterable[Block], before: Iterable[Truth], *, keep: bool) -> RunWaveform:
    """Run a simulation to its end; return its waveform, or only its hash unless ``keep``."""
    digest, first, samples, clipped = hashlib.sha256(), 0, 0, 0
    accelerations, angles, truths = [np.zeros((0, 2), np.float32)], [np.zeros(0, np.float32)], list(before)[-1:]
    for block in blocks:
        truths += block.truths
        if block.lost:
            continue
        first = block.index if samples == 0 else first
        samples, clipped = samples + len(block.shaft_angle), clipped + block.clipped
        digest.update(packed(block.acceleration, block.shaft_angle))
        if keep:
            accelerations.append(block.acceleration)
            angles.append(block.shaft_angle)
    return RunWaveform(np.concatenate(accelerations), np.concatenate(angles), truths, first, samples, clipped, digest.hexdigest())


def _record_bag(common: CommonSettings, run: PlannedRun, running: _RunningSimulation) -> tuple[RunWaveform, dict[str, FileRecord]]:
    """Run a simulation to its end and record a bag, which can be reproduced with `dcrb simulate --from`; return its files, too."""
    folder, simulation = common.store.folder, running.simulation
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    commands = commands_in(running.truths)
    rate = running.start.sensor.sampling_rate
    start_ns = nanoseconds(round(common.file.branch_at * rate) + round(common.file.settle * rate), rate)
    with tempfile.TemporaryDirectory(prefix=PART, dir=folder) as scratch:
        path = Path(scratch) / run.name
        about: dict[str, Any] = {"scenario": common.scenarios.get(run.scenario), "commands": commands, "start_ns": start_ns}

        def recorded_blocks() -> Iterator[Block]:
            with Recorder(path, running.start, simulation.bodies, **about) as recorder:
                for block in simulation.blocks(common.file.duration):
                    recorder.write(block)
                    yield block

        waveform = _run_blocks(recorded_blocks(), running.truths, keep=common.file.windows is not None)
        files = {f"runs/{run.name}/{part.name}": record_of(part) for part in sorted(path.iterdir())}
        common.store.put(path, f"runs/{run.name}")
    return waveform, files
