"""Files and recordings that a command is to write, checked before the work begins."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import checked_path, special_kind
from dcrb_ros.text.temporary import WRITING, abandoned, new_locked, remove, remove_abandoned

PICTURES = (".png", ".svg", ".pdf")
"""Suffixes of the pictures that matplotlib writes."""
ASIDE = ".replaced-"
"""Beginning of the names of folders with what is being replaced."""


def check_output(option: str, file: Path, suffixes: Sequence[str] = ()) -> None:
    """Refuse a file that could not be written, or whose name does not end in one of ``suffixes``.

    Raises:
        Refusal: an unknown suffix, a folder that does not exist, a folder instead of a file, or no permission.
    """
    if suffixes and file.suffix.lower() not in suffixes:
        raise Refusal(f"{option} {file} has an unknown file type: the name must end in one of {', '.join(suffixes)}")
    if not checked_path(file).parent.is_dir():
        raise Refusal(f"{option} {file} cannot be written: there is no folder {file.parent}; create it or give another file")
    if file.is_dir():
        raise Refusal(f"{option} {file} is a folder: give the name of a file in it")
    if not os.access(file if file.exists() else file.parent, os.W_OK):
        raise Refusal(f"{option} {file} cannot be written: no permission, or a read-only file system; give another file")


def check_outputs(*outputs: tuple[str, Path | None, Sequence[str]], force: bool) -> None:
    """Check the files that are given, each with its option and its suffixes; see `check_file` and `check_force`.

    Raises:
        Refusal: see there; or two options name one file, of which only the content written last would remain.
    """
    *first_names, last_name = (option for option, _, _ in outputs)
    check_force(f"{', '.join(first_names)} or {last_name}", *(file for _, file, _ in outputs), force=force)
    options = dict[Path, str]()
    for option, file, suffixes in outputs:
        if file is None:
            continue
        check_file(option, file, suffixes, force=force)
        first = options.setdefault(file.resolve(), option)
        if first != option:
            raise Refusal(f"{first} and {option} both name {file}: give each its own file")


def check_free(option: str, path: Path, *, force: bool) -> None:
    """Refuse an existing file or recording unless ``force`` is given."""
    if not force and os.path.lexists(checked_path(path)):
        raise Refusal(f"{option} {path} exists: give another name, or --force to replace it")


def check_file(option: str, file: Path, suffixes: Sequence[str] = (), *, force: bool) -> None:
    """Refuse a file that could not be written, or that exists unless ``force`` is given; `whole_file` then replaces it in one step.

    A device or a pipe, such as ``/dev/stdout``, is not replaced but written.
    """
    check_output(option, file, suffixes)
    if not special_kind(file):
        check_free(option, file, force=force)


def check_force(outputs: str, *given: object, force: bool) -> None:
    """Refuse ``force`` if none of the options for an output, which ``outputs`` names, is given."""
    if force and not any(given):
        raise Refusal(f"--force has no effect without {outputs}: leave it out, or name what is to be replaced")


@contextmanager
def replacing(option: str, path: Path, *, force: bool, source: Path | None = None) -> Iterator[None]:
    """Refuse an existing file or recording; with ``force`` replace it by the recording that is written in the context.

    For a file that a file replaces, see `check_file`. The old recording is put aside meanwhile, and comes back if the work fails or writes
    nothing. If this process is killed, the next call brings it back, or removes it once something else has replaced it.

    Raises:
        Refusal: ``path`` exists and ``force`` is not given, or it contains ``source``, which is read, or a folder that is not a recording.
        RuntimeError: the old one could not come back; the message says where it is.
    """
    folder, name = checked_path(path).absolute().parent, path.absolute().name
    remove_abandoned(folder)
    for aside in abandoned(folder, ASIDE):
        if not os.path.lexists(path):
            with suppress(OSError):
                (aside / name).rename(path)
        with suppress(OSError):
            aside.rmdir()  # if it is empty
    if not os.path.lexists(path):
        yield
        return
    if source is not None and path.resolve() in (source.resolve(), *source.resolve().parents):
        raise Refusal(f"{option} {path} contains the recording that is read: give another name")
    check_free(option, path, force=force)
    if path.is_dir():
        _check_recording(option, path)
    with ExitStack() as stack:
        try:
            aside = stack.enter_context(new_locked(folder, ASIDE))
            old = aside / name
            try:
                path.rename(old)
            except BaseException:
                if os.path.lexists(old):
                    _bring_back(old, path)
                else:
                    aside.rmdir()
                raise
        except OSError as error:
            raise Refusal(f"{option} {path} cannot be replaced: {error.strerror}; give another name") from None
        try:
            yield
        except BaseException:
            _bring_back(old, path)
            raise
        if not os.path.lexists(path):
            _bring_back(old, path)
        _discard(aside)
    for aside in abandoned(folder, ASIDE):
        if not set(os.listdir(aside)) - {name}:
            _discard(aside)


def _discard(aside: Path) -> None:
    """Remove a folder with what was replaced; if that is interrupted, no part of it comes back, and the next command removes the rest."""
    with suppress(OSError):
        remove(aside.rename(aside.with_name(aside.name.replace(ASIDE, WRITING))))


def _bring_back(old: Path, path: Path) -> None:
    """Move the old file or folder back to its place, and remove what a failed command has written there."""
    try:
        if os.path.lexists(path):
            path.rename(old.with_name(f"{old.name}.failed"))
        old.rename(path)
    except OSError as error:
        raise RuntimeError(f"the old {path} is kept as {old}: it cannot come back ({error.strerror}); move it yourself") from None
    shutil.rmtree(old.parent, ignore_errors=True)


def _check_recording(option: str, folder: Path) -> None:
    """Refuse a folder that contains anything but a recording, and what a killed process has left."""
    remove_abandoned(folder)
    other = next((entry for entry in sorted(folder.iterdir()) if entry.name != "metadata.yaml" and entry.suffix != ".mcap"), None)
    if other is not None:
        raise Refusal(f"{option} {folder} contains {other.name}, which is not part of a recording: remove it or give another name")
