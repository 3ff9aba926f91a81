"""A data set on disk: created or continued, its runs simulated, its table and data card written."""

from __future__ import annotations

import contextlib
import json
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import nest
from dcrb_ros.sweep.card import card
from dcrb_ros.sweep.execution import common_settings, error_label, write_label
from dcrb_ros.sweep.extension import extended_plan, without_extension
from dcrb_ros.sweep.folder_lock import locked
from dcrb_ros.sweep.label import ERROR
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.schema import CARD, DESCRIPTION, write_about
from dcrb_ros.sweep.store import Store, StoreFailed
from dcrb_ros.sweep.sums import SUMS, write_sums
from dcrb_ros.sweep.sweep_file import ABOUT, COPY, EXTENDED, KEPT_BASE
from dcrb_ros.sweep.table import LABELS as LABELS_TABLE
from dcrb_ros.sweep.table import Tally, write_table
from dcrb_ros.sweep.verification import ERRORS, LABELS, flaws, label_name
from dcrb_ros.sweep.workers import Workers
from dcrb_ros.text.json import parsed_json
from dcrb_ros.text.yaml import yaml_text

PARTS = ("sweep", "base", "scenarios")
"""Inputs of a data set, by their keys in `ABOUT`."""
TASK_SECONDS = 2.0
"""Simulated time up to which short runs are combined in one task [s]: submitting a task takes some milliseconds."""

Progress = Callable[[Counter[str]], None]


@contextlib.contextmanager
def open_data_set(plan: Plan, store: Store) -> Iterator[DataSetWriter]:
    """Create a data set, or open an existing one to continue it; its folder is locked until the end of the block.

    Raises:
        Refusal: the store contains other files, or a data set of another sweep, model or version, or it cannot be written, or another
            process is writing to it.
    """
    with locked(store.folder):
        try:
            data_set = DataSetWriter(plan, store)
        except StoreFailed as failure:
            raise Refusal(str(failure)) from None
        yield data_set


class DataSetWriter:
    """A data set in a store that is made or continued, see `open_data_set`."""

    def __init__(self, plan: Plan, store: Store) -> None:
        known = known_inputs(store)
        self.store, self.plan = store, extended_plan(plan, known)
        about = _about(self.plan)
        self.extended = False
        """Whether the data set had fewer points, lives or values before."""
        if known:
            check_same(known, self.plan, store, extended=self.plan is not plan)
            self.extended = known.get("name") != about["name"]
        elif any(True for _ in store.names("")):
            raise Refusal(f"{store.address} contains files that are not a data set: give an empty or a new folder")
        self._refuse_folders()
        # Written first, since the folder is recognised by this file.
        store.write(ABOUT, json.dumps(about, indent=1).encode())
        store.write(COPY, self.plan.sweep.text.encode())
        store.write(KEPT_BASE, yaml_text({"/**": {"ros__parameters": nest(self.plan.sweep.base)}}).encode())
        store.remove_unfinished()
        labelled = sorted(name.removesuffix(".json") for name in store.names(LABELS))
        self.flaws = flaws(store, labelled)
        """Labelled runs that do not count, each with the reason; they are simulated again."""
        for name in self.flaws:
            store.remove(label_name(name))
        self.done = set(labelled) - set(self.flaws)
        """Runs with a whole label and with their files."""

    def make(self, workers: Workers, progress: Progress) -> Tally:
        """Simulate the missing runs, then write the table and the card; ``progress`` is called with the outcomes of each task."""
        sweep = self.plan.sweep
        # Short enough that all workers stay busy to the end.
        fair: float = sweep.count * (sweep.file.duration + sweep.file.settle) / (8 * workers.count)
        common, tasks = common_settings(sweep, self.store), self.plan.tasks(self.done, min(TASK_SECONDS, fair))
        for task, outcome in workers.dispatched(common, tasks):
            if isinstance(outcome, Exception):
                for run in task:
                    if self.store.size(label_name(run.name)) is None:
                        write_label(self.store, error_label(sweep.base, run, str(outcome) or type(outcome).__name__))
                progress(Counter({ERROR: len(task)}))
            else:
                for name, status in outcome:
                    if status != ERROR:
                        self.store.remove(label_name(name, ERRORS))
                progress(Counter(status for _, status in outcome))
        return self.finish()

    def finish(self) -> Tally:
        """Write the table, the card and the description for loaders; remove what workers that were lost have left."""
        with contextlib.suppress(OSError):  # a worker that was taken for lost may still write
            self.store.remove_unfinished()
        tally = write_table(self.plan, self.store)
        tables = list(self.plan.tables())
        for name, data in tables:
            self.store.write(name, data)
        file = self.plan.sweep.file
        text, truth = card(self.plan, tally), self.plan.truth
        title = text.partition("\n")[0].removeprefix("# ")
        write_about(
            self.store, text, title, file.licence, tally.classes, measured=False, waveform=file.output, windows=file.windows, truth=truth
        )
        write_sums(self.store, [LABELS_TABLE, CARD, DESCRIPTION, ABOUT, COPY, KEPT_BASE, *(name for name, _ in tables)])
        return tally

    def _refuse_folders(self) -> None:
        """Refuse a folder in place of a file that is written after the last run."""
        for name in (LABELS_TABLE, CARD, DESCRIPTION, SUMS, *(name for name, _ in self.plan.tables())):
            if self.store.folder is not None and (self.store.folder / name).is_dir():
                raise Refusal(f"{self.store.path(name)} is a folder, and the data set has a file of this name: rename or remove the folder")


def known_inputs(store: Store) -> dict[str, Any]:
    """Return the inputs of the data set in a store; empty if there is no data set.

    Raises:
        Refusal: the file of the inputs is damaged.
        StoreFailed: the store cannot be read.
    """
    known = store.read(ABOUT)
    if known is None:
        return {}
    try:
        about = parsed_json(known, store.path(ABOUT))
    except Refusal:
        about = None
    if not isinstance(about, dict) or not all(isinstance(about.get(part, {}), dict) for part in PARTS):
        raise Refusal(f"{store.path(ABOUT)} is damaged, so the data set cannot be continued: give another folder")
    return about


def _about(plan: Plan) -> dict[str, Any]:
    """Return the inputs of a data set, from which it can be reproduced."""
    sweep = plan.sweep
    return {
        "name": plan.name,
        "sweep": sweep.inputs,
        "base": dict(sweep.base),
        "scenarios": dict(sweep.scenarios),
        "dcrb_ros": __version__,
        "model": model_fingerprint(),
    }


def check_same(known: dict[str, Any], plan: Plan, store: Store, *, extended: bool = False) -> None:
    """Refuse a data set with other inputs than those of a plan; an extended one may have more points, lives or values."""
    about = _about(plan)
    if known.get("name") == about["name"]:
        return
    if known.get("model") != about["model"] or known.get("dcrb_ros") != about["dcrb_ros"]:
        raise Refusal(
            f"{store.address} was made with dcrb_ros {known.get('dcrb_ros')} and model {known.get('model')}, but this is "
            f"{about['dcrb_ros']} with model {about['model']}: install that version, or give another folder"
        )
    before, after = ({part: inputs.get(part, {}) for part in PARTS} for inputs in (known, about))
    if extended:
        history = after["sweep"].get(EXTENDED)
        first = history[-1] if history else None
        before, after = ({**inputs, "sweep": without_extension(inputs["sweep"], first)} for inputs in (before, after))
        if before == after:
            return
    keys = [key for part in PARTS for key in sorted({*before[part], *after[part]}) if before[part].get(key) != after[part].get(key)]
    raise Refusal(
        f"{store.address} was made with another sweep ({', '.join(keys[:5])} differ{'s' if len(keys) == 1 else ''}): give another folder, "
        f"or continue this one with its own {COPY}; more points or lives, or more values at the end of an axis of a grid, add runs"
    )
