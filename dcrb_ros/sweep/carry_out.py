"""Carrying out a task of a plan: the runs of a bearing, their waveforms and labels written as they end."""

from __future__ import annotations

import hashlib
import io
import json
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.messages.points import packed
from dcrb_ros.recordings.recorder import Recorder, RecordingFailed
from dcrb_ros.runtime.arrays import Samples
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.runtime.simulated_time import nanoseconds
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, overlaid, validated
from dcrb_ros.simulation.block import Block, Truth
from dcrb_ros.simulation.events import commands_in
from dcrb_ros.simulation.loop import ModelFailure, Simulation
from dcrb_ros.simulation.scenario import ScheduledChange, scheduled_changes, starting_configuration
from dcrb_ros.sweep.design import Value
from dcrb_ros.sweep.label import DONE, ERROR, FAILED, REFUSED, base_label, fault_label
from dcrb_ros.sweep.plan import Run, Task
from dcrb_ros.sweep.store import PART, Store, StoreFailed
from dcrb_ros.sweep.sweep_file import Sweep, Windows
from dcrb_ros.sweep.windows import cut, labelled, packed_windows, starts

QUIET = {"block_size": 8192, "state_rate": 1}
"""`publishing` for a waveform alone: the samples do not depend on it."""


@dataclass(frozen=True)
class Recipe:
    """What every run of a sweep has in common, as a worker needs it."""

    store: Store
    base: Mapping[str, Value]
    stories: Mapping[str, Any]
    duration: float
    """Recorded time [s]."""
    settle: float
    branch_at: float
    output: str
    windows: Windows | None


def recipe(sweep: Sweep, store: Store) -> Recipe:
    """Return the recipe of a sweep."""
    file = sweep.file
    return Recipe(store, sweep.base, sweep.stories, file.duration, file.settle, file.branch_at, file.output, file.windows)


@dataclass(frozen=True)
class Taken:
    """What was recorded of a run."""

    acceleration: Samples
    """Shape (samples, 2) [m/s^2]; empty where only a bag is wanted."""
    shaft_angle: Samples
    truths: list[Truth]
    first_index: int
    samples: int
    clipped: int
    sha256: str


def carry_out(recipe: Recipe, task: Task) -> list[tuple[str, str]]:
    """Make the runs of a task that have no label yet; return name and outcome of each.

    Raises:
        StoreFailed: the place of the data set cannot be written.
    """
    found, settled = [], _Settled(recipe)
    for run in task:
        name = f"labels/{run.name}.json"
        known = recipe.store.read(name)  # from a worker that was lost before it could tell
        label = json.loads(known) if known else _label(recipe, run, settled)
        if not known:
            write_label(recipe.store, label)
        found.append((run.name, str(label["status"])))
    return found


def write_label(store: Store, label: Mapping[str, Any]) -> None:
    """Write a label; that of an error lies beside those that count."""
    data = json.dumps(label, indent=1).encode()
    if label["status"] == ERROR:
        store.write(f"errors/{label['run']}.json", data)
    else:
        store.write(f"labels/{label['run']}.json", data)


def error_label(base: Mapping[str, Value], run: Run, reason: str) -> dict[str, Any]:
    """Return the label of a run that an error ended."""
    return {**base_label(run, base), "status": ERROR, "reason": reason}


def _label(recipe: Recipe, run: Run, settled: _Settled) -> dict[str, Any]:
    label = base_label(run, recipe.base)
    try:
        return {**label, **_made(recipe, run, settled), "status": DONE, "reason": ""}
    except (Refusal, ModelFailure) as failure:
        return {**label, "status": REFUSED if isinstance(failure, Refusal) else FAILED, "reason": str(failure)}
    except RecordingFailed as failure:
        raise StoreFailed(f"{failure}; make room and call the command again, it goes on from there") from None
    except (StoreFailed, MemoryError):
        raise
    except Exception as error:
        return error_label(recipe.base, run, f"{type(error).__name__}: {error}")


@dataclass(frozen=True)
class _Turning:
    """A bearing on its way, and how it came there."""

    simulation: Simulation
    start: Configuration
    """Configuration at time zero."""
    truths: tuple[Truth, ...]
    """What was true since, of what has not been recorded."""

    def skip(self, duration: float) -> _Turning:
        """Return it after a time that is not recorded [s]."""
        rate = self.start.sensor.sampling_rate
        blocks = self.simulation.blocks(duration) if round(duration * rate) else iter(())
        return _Turning(self.simulation, self.start, (*self.truths, *(truth for block in blocks for truth in block.truths)))


class _Settled:
    """Healthy bearings at the time at which they branch; the last one is kept."""

    def __init__(self, recipe: Recipe) -> None:
        self._recipe = recipe
        self._known: tuple[str, _Turning] | None = None

    def branch(self, run: Run) -> _Turning:
        """Return the bearing of a run that has turned healthy until now and goes on with what is wrong."""
        if self._known is None or self._known[0] != run.twin:
            start = _configured(self._recipe, run.healthy)
            self._known = run.twin, _begun(self._recipe, start).skip(self._recipe.branch_at)
        settled = self._known[1]
        simulation = settled.simulation.fork()
        before, after = (flatten(c.model_dump()) for c in (simulation.configuration, _configured(self._recipe, run.changes)))
        changes = {key: value for key, value in after.items() if value != before[key] and not key.startswith("publishing.")}
        if changes:
            simulation.change(changes)
        return _Turning(simulation, settled.start, settled.truths)


def _configured(recipe: Recipe, changes: Mapping[str, Value]) -> Configuration:
    configuration = validated(overlaid(recipe.base, changes), Configuration, "run")
    if recipe.output == "bag":
        return configuration
    return configuration.model_copy(update={"publishing": configuration.publishing.model_copy(update=QUIET)})


def _made(recipe: Recipe, run: Run, settled: _Settled) -> dict[str, Any]:
    """Make a run and write its waveform; return what its label says of it."""
    turning = (settled.branch(run) if recipe.branch_at else _started(recipe, run)).skip(recipe.settle)
    rate = turning.start.sensor.sampling_rate
    if recipe.output == "bag":
        taken = _recorded(recipe, run, turning)
        file = f"runs/{run.name}"
    else:
        taken = _taken(turning.simulation.blocks(recipe.duration), turning.truths, keep=True)
        file = f"runs/{run.name}.{recipe.output}"
        recipe.store.write(file, _waveform(taken, rate, recipe.output))
    about = {"file": file, "sampling_rate": rate, "first_index": taken.first_index, "samples": taken.samples}
    found = fault_label(taken.truths)
    if recipe.windows is not None:
        _write_windows(recipe, run, taken, rate)
        about["windows"] = len(starts(taken.samples, recipe.windows))
    return {**found, **about, "clipped": taken.clipped, "sha256": taken.sha256}


def _started(recipe: Recipe, run: Run) -> _Turning:
    configuration = _configured(recipe, run.changes)
    if not run.scenario:
        return _begun(recipe, configuration)
    story, source = recipe.stories[run.scenario], f"scenario {run.scenario}"
    configuration = starting_configuration(story, configuration, source)
    return _begun(recipe, configuration, scheduled_changes(story, configuration, source))


def _begun(recipe: Recipe, configuration: Configuration, events: Iterable[ScheduledChange] = ()) -> _Turning:
    return _Turning(Simulation(configuration, events, waveform_only=recipe.output != "bag"), configuration, ())


def _taken(blocks: Iterable[Block], before: Iterable[Truth], *, keep: bool) -> Taken:
    """Run to the end; ``keep`` the waveform or its hash alone."""
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
    return Taken(np.concatenate(accelerations), np.concatenate(angles), truths, first, samples, clipped, digest.hexdigest())


def _recorded(recipe: Recipe, run: Run, turning: _Turning) -> Taken:
    """Run to the end and record a bag, which repeats as `dcrb simulate --from` does."""
    folder, simulation = recipe.store.folder, turning.simulation
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    commands = commands_in(turning.truths)
    rate = turning.start.sensor.sampling_rate
    start_ns = nanoseconds(round(recipe.branch_at * rate) + round(recipe.settle * rate), rate)
    with tempfile.TemporaryDirectory(prefix=PART, dir=folder) as scratch:
        path = Path(scratch) / run.name
        about: dict[str, Any] = {"scenario": recipe.stories.get(run.scenario), "commands": commands, "start_ns": start_ns}

        def written() -> Iterator[Block]:
            with Recorder(path, turning.start, simulation.bodies, **about) as recorder:
                for block in simulation.blocks(recipe.duration):
                    recorder.write(block)
                    yield block

        taken = _taken(written(), turning.truths, keep=recipe.windows is not None)
        recipe.store.put(path, f"runs/{run.name}")
    return taken


def _waveform(taken: Taken, rate: int, kind: str) -> bytes:
    """Return a waveform as a file: the same samples make the same bytes."""
    stream = io.BytesIO()
    columns: dict[str, Any] = {"ax": taken.acceleration[:, 0], "ay": taken.acceleration[:, 1], "shaft_angle": taken.shaft_angle}
    if kind == "npz":
        np.savez(stream, **columns, sampling_rate=np.array(rate), first_index=np.array(taken.first_index))
    else:
        import pyarrow
        from pyarrow import parquet

        table = pyarrow.table({name: np.ascontiguousarray(values) for name, values in columns.items()})
        table = table.replace_schema_metadata({"sampling_rate": str(rate), "first_index": str(taken.first_index)})
        parquet.write_table(table, stream, compression="zstd", use_dictionary=False)
    return stream.getvalue()


def _write_windows(recipe: Recipe, run: Run, taken: Taken, rate: int) -> None:
    windows = recipe.windows
    assert windows is not None
    labels = labelled(starts(taken.samples, windows), taken.first_index, rate, windows, taken.truths)
    about = {"run": run.name, "case": run.case, "split": run.split}
    data = packed_windows(cut(taken.acceleration, windows), labels, about, windows.kind)
    recipe.store.write(f"windows/{run.split}/{run.name}.{windows.kind}", data)
