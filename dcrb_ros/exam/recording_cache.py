"""The recordings of an exam, simulated once and kept for later evaluations.

Each is kept with the hash of its scenario and the hashes of its files, which are compared before every use.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

import platformdirs

from dcrb_ros.core.signed_file import DamagedFile, read_signed, signed
from dcrb_ros.exam.case import Case, canonical
from dcrb_ros.messages.topic import SimulatedTopic
from dcrb_ros.messages.topics import GROUND_TRUTH, TEMPERATURES, VIBRATION
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.runtime.exit_status import print_error
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import scheduled_changes
from dcrb_ros.text.files import open_regular, read_text
from dcrb_ros.text.json import parsed_json
from dcrb_ros.text.temporary import remove_abandoned, temporary
from dcrb_ros.text.writing import remedy_of, sync, write_whole

RECORDED: tuple[SimulatedTopic, ...] = (VIBRATION, GROUND_TRUTH)
"""Topics of every recording."""
CONTENT = "content.json"
"""File in the folder of a recording with the hash of its scenario and the hashes of its files."""
OTHER_FOLDER = "give another folder with --recordings"
"""Remedy where a file in the folder of the recordings cannot be written."""
LARGEST_CONTENT = 1_000_000
"""Longest text of that file that is read [characters]."""


def default_folder() -> Path:
    """Return the default folder of the recordings."""
    return Path(platformdirs.user_cache_dir("dcrb_ros")) / "exam"


@contextlib.contextmanager
def checked_folder(folder: Path) -> Iterator[Path]:
    """Create a folder if necessary, check that it is writable, and yield it.

    What killed processes have left there is removed, at the end also that of workers which were stopped.

    Raises:
        Refusal: it cannot be created or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise Refusal(f"{folder} cannot hold the exam's recordings: {error.strerror}; {OTHER_FOLDER}") from None
    remove_abandoned(folder)
    try:
        yield folder
    finally:
        remove_abandoned(folder)


def kept_content(path: Path, consequence: str) -> bytes | None:
    """Return what `keep` wrote to a file; None if there is none, or if it is damaged, which is reported with its ``consequence``."""
    try:
        return read_signed(path)
    except FileNotFoundError:
        return None
    except DamagedFile as error:
        print_error("dcrb", f"{error}; {consequence}")
        return None


def keep(path: Path, content: bytes) -> None:
    """Write a content to a file with its checksum.

    Raises:
        Refusal: the file cannot be written.
    """
    write_whole(path, signed(path, content), otherwise=OTHER_FOLDER)


def case_hash(case: Case) -> str:
    """Return the SHA-256 of everything on which the recording of a case depends: the run, the model and the software versions."""
    about = [case.simulation.described(), model_fingerprint(), software()]
    topics = _recorded(case.simulation.configuration)
    everything = canonical(about if topics == RECORDED else [*about, [topic.name for topic in topics]])
    return hashlib.sha256(everything.encode()).hexdigest()


def cache_path(case: Case, folder: Path) -> Path:
    """Return the path of a case's recording; its name contains the beginning of `case_hash`."""
    words = re.sub(r"[^a-z0-9.=_-]+", "-", case.expectation.name.lower())[:60].strip("-.")
    return folder / f"{words}-{case_hash(case)[:16]}"


def cached_recording(case: Case, folder: Path) -> Path:
    """Return the recording of a case; simulate it if it does not exist or is damaged, which is reported on the standard error output.

    The recording is written to a temporary folder and renamed once it is complete, so an interrupted run is never used.

    Raises:
        Refusal: the folder cannot be written.
    """
    path = cache_path(case, folder)
    if os.path.lexists(path):
        flaw = recording_flaw(case, path)
        if not flaw:
            return path
        print_error("dcrb", f"scenario '{case.expectation.name}': {path} {flaw}; it is simulated again")
    try:
        folder.mkdir(parents=True, exist_ok=True)  # dcrb cache --clear may have removed it since the start
        with temporary(folder) as making:
            try:
                _simulate(case, making / path.name)
            except (RecordingFailed, Refusal) as failure:
                sentence = str(failure).replace(str(making / path.name), str(path))
                raise Refusal(sentence.replace("give another folder", OTHER_FOLDER)) from None
            _write_content(case, making / path.name)
            if os.path.lexists(path) and recording_flaw(case, path):
                with contextlib.suppress(FileNotFoundError):  # another process may have moved it
                    os.rename(path, making / "damaged")
            try:
                os.rename(making / path.name, path)
                sync(folder)
            except OSError:
                if not path.is_dir():  # another process may have recorded the same case
                    raise
    except OSError as error:
        raise Refusal(f"{path} cannot be written: {error.strerror or error}; {remedy_of(error)} or {OTHER_FOLDER}") from None
    return path


def recording_flaw(case: Case, path: Path) -> str:
    """Return why a folder is not the recording of a case as it was written, as the end of a sentence; the empty string if it is."""
    try:
        content = parsed_json(read_text(path / CONTENT, LARGEST_CONTENT), CONTENT)
        files = _file_hashes(path)
    except (OSError, Refusal) as error:
        return f"cannot be checked ({error})"
    if not isinstance(content, dict) or content.get("case") != case_hash(case):
        return "is the recording of another scenario"
    stated = content.get("files")
    if not isinstance(stated, dict) or set(stated) != set(files):
        return "has other files than were recorded"
    return next((f"is damaged: {name} has been changed since it was recorded" for name in files if files[name] != stated[name]), "")


def _write_content(case: Case, path: Path) -> None:
    content = path / CONTENT
    content.write_text(json.dumps({"case": case_hash(case), "files": _file_hashes(path)}, indent=1) + "\n", encoding="utf-8")
    sync(content)


def _file_hashes(path: Path) -> dict[str, str]:
    """Return the SHA-256 of every file in a folder by its name, without that of `CONTENT`."""
    return {file.name: _file_hash(file) for file in sorted(path.iterdir()) if file.name != CONTENT}


def _file_hash(file: Path) -> str:
    digest = hashlib.sha256()
    with open_regular(file) as stream:
        while chunk := stream.read(1 << 20):
            digest.update(chunk)
    return digest.hexdigest()


def is_recorded(case: Case, folder: Path) -> bool:
    """Return whether the recording of a case exists and is sound."""
    path = cache_path(case, folder)
    return path.is_dir() and not recording_flaw(case, path)


def _recorded(configuration: Configuration) -> tuple[SimulatedTopic, ...]:
    """Return the topics that a detector reads, where the bench has them, and the truth; the others would take up space."""
    return RECORDED + tuple(topic for topic in TEMPERATURES if topic.enabled(configuration))


def _simulate(case: Case, path: Path) -> None:
    run, source = case.simulation, case.expectation.name
    simulation = Simulation(run.configuration, scheduled_changes(run.scenario, run.configuration, source) if run.scenario else ())
    names = ", ".join(topic.name for topic in _recorded(run.configuration))
    topics = run.configuration.recording.model_copy(update={"topics": names})
    configuration = run.configuration.model_copy(update={"recording": topics})
    with Recorder(path, configuration, simulation.bodies, scenario=run.scenario) as recorder:
        for block in simulation.blocks(run.duration):
            recorder.write(block)
