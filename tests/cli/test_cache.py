"""`dcrb cache`: what is kept outside of the user's folders can be found and removed."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import pytest

from dcrb_ros.cli.app import app
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.text.temporary import temporary


@pytest.mark.skipif(sys.platform != "linux", reason="XDG_CACHE_HOME is of Linux")
def test_caches_are_listed_and_cleared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def cache(*options: str) -> str:
        assert exit_status("dcrb", lambda: app(["cache", *options], standalone_mode=False)) == 0
        return capsys.readouterr().out

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("dcrb_ros.core.CACHE", tmp_path / "dcrb_ros" / "kernels-now")
    (tmp_path / "dcrb_ros" / "kernels-now" / "step").mkdir(parents=True)
    own = tmp_path / "dcrb_ros"
    kernels, recordings, other = own / "kernels-0123" / "step" / "a.nbc", own / "exam" / "healthy" / "0.mcap", own / "notes.txt"
    for file, size in ((kernels, 2_000_000), (recordings, 1_500), (other, 10)):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"x" * size)
    assert cache().splitlines() == [f"{own / 'kernels-0123'}: 2 MB", f"{own / 'exam'}: 0.0015 MB"]
    assert json.loads(cache("--json"))["folders"][0] == {"path": str(own / "kernels-0123"), "bytes": 2_000_000}
    assert kernels.exists()
    assert cache("--clear").splitlines() == [f"{own / 'kernels-0123'}: 2 MB deleted", f"{own / 'exam'}: 0.0015 MB deleted"]
    assert (kernels.exists(), recordings.exists(), other.exists()) == (False, False, True)
    assert cache() == "the caches are empty\n"


@pytest.mark.skipif(sys.platform != "linux", reason="XDG_CACHE_HOME is of Linux")
def test_a_cache_that_is_a_link_to_another_disk_is_cleared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("dcrb_ros.core.CACHE", tmp_path / "dcrb_ros" / "kernels-now")
    disk, own = tmp_path / "disk", tmp_path / "dcrb_ros"
    (disk / "healthy").mkdir(parents=True)
    (disk / "healthy" / "0.mcap").write_bytes(b"x")
    (disk / "index").write_bytes(b"x")
    own.mkdir()
    (own / "exam").symlink_to(disk)
    assert exit_status("dcrb", lambda: app(["cache", "--clear"], standalone_mode=False)) == 0
    assert ((own / "exam").is_dir(), list(disk.iterdir())) == (True, [])


@pytest.mark.skipif(sys.platform != "linux", reason="XDG_CACHE_HOME is of Linux")
@pytest.mark.parametrize(("writes", "status"), [(3, 0), (10**9, 2)], ids=["ends", "goes on"])
def test_a_cache_to_which_another_command_writes_is_cleared_or_named(
    writes: int, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("dcrb_ros.core.CACHE", tmp_path / "dcrb_ros" / "kernels-now")
    recordings = tmp_path / "dcrb_ros" / "exam"
    recordings.mkdir(parents=True)
    (recordings / "0.mcap").write_bytes(b"x")
    left, rmdir = iter(range(writes)), os.rmdir

    def rmdir_during_a_write(path: Any, **options: Any) -> None:
        if next(left, None) is not None:
            (recordings / "1.mcap").write_bytes(b"x")
        rmdir(path, **options)

    monkeypatch.setattr(os, "rmdir", rmdir_during_a_write)
    assert exit_status("dcrb", lambda: app(["cache", "--clear"], standalone_mode=False)) == status
    assert recordings.exists() == bool(status)
    expected = f"dcrb: {recordings} cannot be deleted, because another command writes to it: wait until it has ended, and repeat\n"
    assert capsys.readouterr().err == (expected if status else "")


@pytest.mark.skipif(sys.platform != "linux", reason="XDG_CACHE_HOME is of Linux")
def test_a_recording_that_is_being_written_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("dcrb_ros.core.CACHE", tmp_path / "dcrb_ros" / "kernels-now")
    recordings = tmp_path / "dcrb_ros" / "exam"
    (recordings / "outer").mkdir(parents=True)
    with temporary(recordings) as making:
        assert exit_status("dcrb", lambda: app(["cache", "--clear"], standalone_mode=False)) == 2
        assert (making.is_dir(), (recordings / "outer").is_dir()) == (True, True)
        assert "another command writes to it: wait until it has ended" in capsys.readouterr().err
    assert exit_status("dcrb", lambda: app(["cache", "--clear"], standalone_mode=False)) == 0
    assert not recordings.exists()
