"""`dcrb cache`: what is kept outside of the user's folders can be found and removed."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from dcrb_ros.cli.app import app
from dcrb_ros.runtime.exit_status import exit_status


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
