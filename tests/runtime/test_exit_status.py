"""Exit status and error message of the programs."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dcrb_ros.runtime.exit_status import exit_status


def test_an_error_of_the_operating_system_names_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def command() -> None:
        raise OSError(28, os.strerror(28), str(tmp_path / "cache"))

    assert exit_status("dcrb", command) == 1
    error = capsys.readouterr().err
    assert f"dcrb: {tmp_path}/cache cannot be used: No space left on device; make room for it, or give another path" in error
    assert error.count("\n") == 1


def test_an_error_of_the_operating_system_without_a_file_has_no_number(capsys: pytest.CaptureFixture[str]) -> None:
    def command() -> None:
        raise OSError(28, os.strerror(28))

    assert exit_status("dcrb", command) == 1
    assert capsys.readouterr().err.startswith("dcrb: No space left on device")


def test_an_error_is_printed_without_control_characters(capsys: pytest.CaptureFixture[str]) -> None:
    def command() -> None:
        raise RuntimeError("the name \x1b[2J\udc80 failed; its output:\n    a\x07")

    assert exit_status("dcrb", command) == 1
    assert capsys.readouterr().err == "dcrb: the name \\x1b[2J\\udc80 failed; its output:\n    a\\x07\n"


def test_characters_that_the_output_does_not_have_are_escaped(monkeypatch: pytest.MonkeyPatch) -> None:
    output = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", output)
    assert exit_status("dcrb", lambda: print("m/s\u00b2 \ud800")) == 0
    output.flush()
    assert output.buffer.getvalue() == b"m/s\\xb2 \\ud800\n"  # type: ignore[attr-defined]


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("words", [["config", "list"], ["config", "docs", "bearing"], ["--help"]])
def test_a_full_disk_behind_the_output_is_named(words: list[str], unbuffered: str) -> None:
    command = [sys.executable, "-m", "dcrb_ros.cli.program", *words]
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": unbuffered}, timeout=600.0
        )
    assert done.returncode == 1
    assert done.stderr.startswith("dcrb: the standard output cannot be used: No space left on device")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(("words", "status"), [(["config", "show", "nonsense"], 2), (["nonsense"], 2), (["info", "nonsense"], 2)])
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device that is always full")
def test_the_status_is_the_same_if_the_sentence_cannot_be_printed(words: list[str], status: int, unbuffered: str) -> None:
    command = [sys.executable, "-m", "dcrb_ros.cli.program", *words]
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            command, stdout=full, stderr=full, text=True, env={**os.environ, "PYTHONUNBUFFERED": unbuffered}, timeout=600.0, check=False
        )
    assert done.returncode == status


def test_a_warning_that_cannot_be_printed_is_a_failure() -> None:
    command = [sys.executable, "-m", "dcrb_ros.cli.program", "config", "check", "healthy", "--set", "operating.load=-5.0"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=full, timeout=600.0, check=False)
    assert done.returncode == 1


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(("words", "status"), [("config list", 0), ("config show nothing", 2)])
def test_a_closed_stream_changes_no_status(words: str, status: int, closed: str) -> None:
    command = f"'{sys.executable}' -m dcrb_ros.cli.program {words} {closed}"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=600.0)
    assert done.returncode == status
    assert bool(done.stdout) == (status == 0 and closed in ("<&-", "2>&-"))
    assert done.stderr.count("\n") == (1 if status and "2>&-" not in closed else 0)


@pytest.mark.parametrize("words", ["config list", "--help", "config docs fault_detector", "score smoke --list"])
def test_a_reader_that_leaves_early_changes_no_status(words: str) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "wb") as pipe:
        command = [sys.executable, "-m", "dcrb_ros.cli.program", *words.split()]
        done = subprocess.run(command, stdout=pipe, stderr=subprocess.PIPE, text=True, timeout=600.0)
    assert (done.returncode, done.stderr) == (0, "")


PRINTING = """
import sys, typer
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.runtime.terminal import console
def command():
    for _ in range(2):
        console(stderr=sys.argv[1] == "stderr").print("report\\n" * 10000)
        print("report\\n" * 10000, file=getattr(sys, sys.argv[1]), flush=True)
    open(sys.argv[2], "w").close()
    raise typer.Exit(1)
sys.exit(exit_status("dcrb", command))
"""


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_command_whose_reader_leaves_early_does_the_rest_and_keeps_its_status(stream: str, tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "wb") as pipe:
        command = [sys.executable, "-c", PRINTING, stream, str(tmp_path / "report")]
        outputs = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, stream: pipe}
        done = subprocess.run(command, **outputs, timeout=600.0, check=False)  # type: ignore[call-overload]
    assert (done.returncode, done.stdout or b"", done.stderr or b"") == (1, b"", b"")
    assert (tmp_path / "report").exists()
