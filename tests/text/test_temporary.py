"""Temporary files and folders of processes that have ended are removed, and no others."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path

import pytest

from dcrb_ros.text import temporary as module
from dcrb_ros.text.temporary import ABANDONED, remove_abandoned, temporary


@pytest.mark.parametrize("suffix", [None, ".json"], ids=["folder", "file"])
def test_what_is_in_use_stays(suffix: str | None, tmp_path: Path) -> None:
    others = {tmp_path / name for name in ("finished", ".writing-notes", ".writing-0123.json")}
    for other in others:
        other.touch()
    with temporary(tmp_path, suffix) as path:
        assert path.is_dir() == (suffix is None)
        (tmp_path / ".writing-0123456789abcdef").touch()
        with temporary(tmp_path, ".json") as second:
            assert set(tmp_path.iterdir()) == {*others, path, second}
    assert set(tmp_path.iterdir()) == others


@pytest.mark.parametrize(("age", "kept"), [(0.0, True), (ABANDONED - 600.0, True), (ABANDONED + 600.0, False)])
@pytest.mark.parametrize("locks", ["none", "unsupported"])
def test_without_locks_what_is_older_than_a_day_is_removed(
    age: float, kept: bool, locks: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def flock(descriptor: int, operation: int) -> None:
        raise OSError(errno.EBADF, "Bad file descriptor")  # a folder on NFS

    if locks == "none":
        monkeypatch.setattr(module, "fcntl", None)
    else:
        monkeypatch.setattr(module.fcntl, "flock", flock)
    left = tmp_path / ".writing-0123456789abcdef"
    left.mkdir()
    os.utime(left, (time.time() - age,) * 2)
    remove_abandoned(tmp_path)
    assert left.exists() == kept
    with temporary(tmp_path) as path:
        assert path.is_dir()


def test_a_file_that_another_process_takes_for_abandoned_is_made_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lock, made = module.lock, []

    def removed_first(path: Path) -> int | None:
        made.append(path)
        if len(made) == 1:
            path.unlink()
        return lock(path)

    monkeypatch.setattr(module, "lock", removed_first)
    with temporary(tmp_path, ".json") as path:
        assert list(tmp_path.iterdir()) == [path]
    assert len(made) == 2
