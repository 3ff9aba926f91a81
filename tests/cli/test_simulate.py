"""`dcrb simulate`: what it prints, as text and as JSON, and the real-time factor."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from same_process import dcrb

from dcrb_ros.cli import simulate
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime import prefetch
from dcrb_ros.runtime.signals import STOPPED


class Clock:
    """A clock that only the simulation moves."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 1000.0
        monkeypatch.setattr(simulate.time, "perf_counter", lambda: self.now)
        monkeypatch.setattr(prefetch, "prefetch", lambda blocks, depth: blocks)

    def blocks(self, count: int) -> Iterator[Any]:
        """Yield blocks of 0.5 s; the first one takes a minute of compilation, each other one 0.25 s."""
        for number in range(count):
            self.now += 60.0 if number == 0 else 0.25
            yield SimpleNamespace(end_ns=(number + 1) * 500_000_000)


def run(blocks: Iterator[Any]) -> simulate.Progress:
    return simulate._run("made up", blocks, 2.0, lambda block: None, quiet=True)


def test_the_real_time_factor_leaves_out_the_compilation(monkeypatch: pytest.MonkeyPatch) -> None:
    progress = run(Clock(monkeypatch).blocks(4))
    assert progress == (2.0, pytest.approx(2.0))
    assert str(progress) == "2.00 s simulated, 2.00 x real time"


def test_a_run_of_a_single_block_has_no_real_time_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    progress = run(Clock(monkeypatch).blocks(1))
    assert progress == (0.5, None)
    assert str(progress) == "0.50 s simulated"


def interrupted_after(count: int) -> Iterator[Any]:
    """Yield blocks of 0.5 s until Ctrl-C."""
    yield from (SimpleNamespace(end_ns=(number + 1) * 500_000_000) for number in range(count))
    raise KeyboardInterrupt


def run_until_interrupted(count: int, *, partial: bool) -> simulate.Progress:
    return simulate._run("made up", interrupted_after(count), 2.0, lambda block: None, quiet=True, partial=partial)


def test_ctrl_c_ends_a_recording_early(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(prefetch, "prefetch", lambda blocks, depth: blocks)
    assert run_until_interrupted(2, partial=True).simulated == 1.0
    assert "stopped at 1.00 s; the recording ends there" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals that a process sends itself")
def test_ctrl_c_in_the_middle_of_a_block_ends_the_recording_after_it(tmp_path: Path) -> None:
    code = f"""
import os, signal
from dcrb_ros.cli.app import app
from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.recordings.manifest import Outcome
from dcrb_ros.runtime import signals

add = Outcome.add

def stopped(self, message):
    if self.samples == 4096 and message.topic == VIBRATION:
        os.kill(os.getpid(), signal.SIGINT)
    add(self, message)

signals.interrupt()
Outcome.add = stopped
app(["simulate", "dry", "-o", {str(tmp_path / "bag")!r}, "--duration", "30", "--quiet"])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=400.0, check=False)
    assert done.returncode == 0, done.stderr
    assert "stopped at 0.10 s; the recording ends there" in done.stderr
    recording = Recording(tmp_path / "bag")
    assert recording.digests().match is True
    assert sum(name.endswith("features") and count == 5 for name, count in recording.counts().items()) == 1


@pytest.mark.parametrize(("count", "partial"), [(0, True), (2, False)])
def test_ctrl_c_before_the_first_block_or_in_a_reproduction_ends_the_command(
    count: int, partial: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What has no samples, or only a part of those to compare, is no result.
    monkeypatch.setattr(prefetch, "prefetch", lambda blocks, depth: blocks)
    with pytest.raises(KeyboardInterrupt):
        run_until_interrupted(count, partial=partial)


def test_a_reproduction_that_is_stopped_says_nothing_about_the_samples(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bag, copy = tmp_path / "bag", tmp_path / "copy"
    assert dcrb("simulate", "healthy", "-o", str(bag), "--duration", "0.1", "--quiet") == 0

    def stopped(blocks: Iterator[Any], depth: int) -> Iterator[Any]:
        yield next(iter(blocks))
        raise KeyboardInterrupt

    monkeypatch.setattr(prefetch, "prefetch", stopped)
    assert dcrb("simulate", "--from", str(bag), "-o", str(copy), "--quiet") == STOPPED
    assert capsys.readouterr().err == "dcrb: stopped\n"
    assert Recording(copy).complete


def test_the_result_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "bag"
    # The end of the first block of 0.02 s, and that of the run of 0.1 s; the same for the run that is made again.
    monkeypatch.setattr(simulate, "time", SimpleNamespace(perf_counter=iter([10.0, 10.5, 20.0, 20.5]).__next__))
    assert dcrb("simulate", "healthy", "-o", str(bag), "--duration", "0.1", "--json", "--quiet") == 0
    out, err = capsys.readouterr()
    found, outcome = json.loads(out), Recording(bag).outcome
    assert err == ""
    assert outcome is not None
    assert found["recording"] == str(bag)
    assert found["simulated"] == pytest.approx(0.1)
    assert found["real_time_factor"] == pytest.approx(0.08 / 0.5)
    assert (found["samples"], found["sha256"]) == (5120, outcome["sha256"])
    assert dcrb("simulate", "--from", str(bag), "--json", "--quiet") == 0
    again = json.loads(capsys.readouterr().out)
    assert again["recording"] is None
    assert (again["samples"], again["sha256"]) == (5120, outcome["sha256"])


def test_a_quiet_run_prints_the_result_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "bag"
    assert dcrb("simulate", "healthy", "-o", str(bag), "--duration", "0.01", "--quiet") == 0
    assert capsys.readouterr() == (f"{bag}: 0.01 s simulated\n", "")


def test_the_recording_is_opened_with_the_view(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "my bag"
    assert dcrb("simulate", "healthy", "-o", str(bag), "--duration", "0.01") == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"open it with: dcrb view '{bag}'"


@pytest.mark.parametrize("what", [["healthy"], ["--vehicle", "bogie"]], ids=["bench", "vehicle"])
def test_a_run_without_a_sample_is_refused(what: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "bag"
    assert dcrb("simulate", *what, "-o", str(bag), "--duration", "1e-9") == 2
    assert "--duration 1e-09 s is shorter than a sample at 51200 Hz: give at least 2e-05 s" in capsys.readouterr().err
    assert not bag.exists()
