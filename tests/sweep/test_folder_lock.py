"""The lock of a data set's folder."""

from __future__ import annotations

import errno
import os
import platform
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.folder_lock import LOCK, locked
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.store import Store

HOLDER = """
import sys
from pathlib import Path
from dcrb_ros.sweep.folder_lock import locked
with locked(Path(sys.argv[1])):
    print("locked", flush=True)
    sys.stdin.read()
"""


@contextmanager
def holder(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Provide another process that holds the lock of a folder."""
    command = [sys.executable, "-c", HOLDER, str(folder)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "locked\n"
            yield process
        finally:
            process.kill()


def test_a_second_process_is_refused_and_told_the_first_one(tmp_path: Path) -> None:
    part = tmp_path / "runs" / ".part-unfinished"
    part.parent.mkdir()
    part.touch()
    store = Store(str(tmp_path))
    with (
        holder(tmp_path) as other,
        pytest.raises(Refusal, match=f"being written by the process {other.pid} on {platform.node()}: wait until it has ended"),
        open_data_set(Plan(sweep_of({"duration": 0.02}, "sweep.yaml")), store),
    ):
        pass
    assert part.exists()
    assert list(store.names("")) == ["runs"]


def test_the_lock_ends_with_a_killed_process(tmp_path: Path) -> None:
    with holder(tmp_path) as other:
        other.send_signal(signal.SIGKILL)
        other.wait(timeout=400.0)
        assert (tmp_path / LOCK).exists()
        with locked(tmp_path):
            assert (tmp_path / LOCK).read_text() == f"{os.getpid()} on {platform.node()}"
    assert not (tmp_path / LOCK).exists()


def test_a_full_disk_is_named_with_its_remedy_and_keeps_no_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("dcrb_ros.sweep.folder_lock.os.write", full)
    with (
        pytest.raises(Refusal, match=r"cannot be written: No space left on device; free some space, or give another folder"),
        locked(tmp_path),
    ):
        pass
    assert not (tmp_path / LOCK).exists()


def test_the_lock_is_not_taken_on_a_removed_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that opened the file before the holder removed it would lock a file that nobody else sees."""
    real, opened = os.open, []

    def opening(path: Path, *of: int) -> int:
        opened.append(real(path, *of))
        if len(opened) == 1:
            Path(path).unlink()
        return opened[-1]

    monkeypatch.setattr("dcrb_ros.sweep.folder_lock.os.open", opening)
    with locked(tmp_path):
        assert len(opened) == 2
        assert (tmp_path / LOCK).exists()


def test_a_file_that_is_removed_during_the_check_is_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, asked = os.stat, []

    def removed(path: Path, **of: object) -> os.stat_result:
        if Path(path).name == LOCK:
            asked.append(path)
            if len(asked) == 1:
                Path(path).unlink()
        return real(path, **of)  # type: ignore[arg-type]

    monkeypatch.setattr("dcrb_ros.sweep.folder_lock.os.stat", removed)
    monkeypatch.setattr("dcrb_ros.sweep.folder_lock.os.path.exists", lambda path: True)  # it was there a moment ago
    with locked(tmp_path):
        assert (tmp_path / LOCK).exists()


def test_an_error_releases_the_lock(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), locked(tmp_path / "new"):
        raise ZeroDivisionError
    with locked(tmp_path / "new"):
        pass
    assert list((tmp_path / "new").iterdir()) == []


def test_a_folder_with_two_colons_in_its_name_is_that_folder(tmp_path: Path) -> None:
    folder = tmp_path / "run::1" / "bearings"
    store = Store(str(folder))
    store.write("a.txt", b"a")
    assert (store.folder, [path.name for path in tmp_path.iterdir()]) == (folder, ["run::1"])
    assert (folder / "a.txt").read_bytes() == b"a"
