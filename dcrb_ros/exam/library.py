"""The recordings of an exam: made once, kept for the next detector."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
import time
from pathlib import Path

import platformdirs

from dcrb_ros.exam.case import Case, canonical
from dcrb_ros.messages.topics import GROUND_TRUTH, VIBRATION
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import scheduled_changes

ABANDONED = 86400.0
"""Age from which a half-made recording is one of a run that was broken off [s]."""


def default_folder() -> Path:
    """Return where recordings are kept unless the user says otherwise."""
    return Path(platformdirs.user_cache_dir("dcrb_ros")) / "exam"


def checked_folder(folder: Path) -> Path:
    """Return a folder that exists and can be written.

    Raises:
        Refusal: it cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        for left in folder.glob(".making-*"):
            if time.time() - left.stat().st_mtime > ABANDONED:
                shutil.rmtree(left, ignore_errors=True)
        return folder
    except OSError as error:
        raise Refusal(f"{folder} cannot hold the exam's recordings: {error.strerror}; give another folder with --recordings") from None


def place(case: Case, folder: Path) -> Path:
    """Return where the recording of a case lies: its name says what was simulated, and with which sources."""
    everything = canonical([case.run.described(), model_fingerprint(), software()])
    words = re.sub(r"[^a-z0-9.=_-]+", "-", case.question.name.lower())[:60].strip("-.")
    return folder / f"{words}-{hashlib.sha256(everything.encode()).hexdigest()[:16]}"


def recorded(case: Case, folder: Path) -> Path:
    """Return the recording of a case, simulated now where there is none yet.

    It appears under its name once it is whole, so that no run that was broken off is taken for one.
    """
    there = place(case, folder)
    if there.is_dir():
        return there
    making = Path(tempfile.mkdtemp(prefix=".making-", dir=folder))
    try:
        _simulate(case, making / there.name)
        try:
            os.rename(making / there.name, there)
        except OSError:
            if not there.is_dir():  # another process may have made the same
                raise
    finally:
        shutil.rmtree(making, ignore_errors=True)
    return there


def _simulate(case: Case, path: Path) -> None:
    run, source = case.run, case.question.name
    simulation = Simulation(run.configuration, scheduled_changes(run.story, run.configuration, source) if run.story else ())
    # A detector gets the waveform; what else the bench publishes would only take room.
    wanted = run.configuration.recording.model_copy(update={"topics": f"{VIBRATION.name}, {GROUND_TRUTH.name}"})
    with Recorder(path, run.configuration.model_copy(update={"recording": wanted}), simulation.bodies, scenario=run.story) as recorder:
        for block in simulation.blocks(run.duration):
            recorder.write(block)
