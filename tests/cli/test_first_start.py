"""The note that kernels are compiled."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from numba.core import event
from rich.console import Console
from same_process import dcrb

from dcrb_ros.cli import first_start
from dcrb_ros.core.announcement import OF_LAWS, SENTENCE, WORKERS, announce_laws, no_announcement
from dcrb_ros.exam import replica
from dcrb_ros.schema.refusal import Refusal

FILM = OF_LAWS.format(laws="film")


@pytest.fixture(autouse=True)
def nothing_announced_later() -> Iterator[None]:
    yield
    no_announcement()


def compile_kernel() -> None:
    """Do what numba does at the beginning and at the end of a compilation."""
    with event.trigger_event("numba:compile"):
        pass


def test_the_note_gives_the_time_to_expect_and_names_another_set(capsys: pytest.CaptureFixture[str]) -> None:
    first_start.announce_compilation()
    compile_kernel()
    compile_kernel()
    announce_laws("film")
    compile_kernel()
    with first_start.compilation_shown():
        compile_kernel()
    assert capsys.readouterr() == ("", f"{SENTENCE}\n{FILM}\n{SENTENCE}\n")
    assert "once, 15 s to over a minute" in SENTENCE
    assert WORKERS in os.environ


def test_a_quiet_command_prints_no_note(capsys: pytest.CaptureFixture[str]) -> None:
    first_start.announce_compilation()
    first_start.announce_compilation(quiet=True)
    with first_start.compilation_shown(quiet=True):
        compile_kernel()
    assert capsys.readouterr() == ("", "")
    assert WORKERS not in os.environ


def test_compiled_kernels_need_no_note(capsys: pytest.CaptureFixture[str]) -> None:
    first_start.announce_compilation()
    announce_laws("film")
    with first_start.compilation_shown():
        pass
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    "options",
    [("replica", "a.csv", "-o", "new.yaml"), ("predictivity", "a.csv", "--entries", ".", "--measured", ".")],
    ids=lambda options: options[0],
)
def test_the_machines_of_a_replica_are_simulated_with_a_note(
    options: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def simulated(*_: object) -> None:
        compile_kernel()
        raise Refusal("simulated")

    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").touch()
    monkeypatch.setattr(replica, "replica_tree", simulated)
    assert dcrb("exam", *options) == 2
    assert capsys.readouterr().err == f"{SENTENCE}\ndcrb: simulated\n"


def test_a_terminal_shows_a_spinner_that_disappears(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = io.StringIO()
    monkeypatch.setattr(first_start, "console", lambda *, stderr: Console(file=screen, force_terminal=True, width=120, markup=False))
    with first_start.compilation_shown():
        assert not screen.getvalue()
        announce_laws("film")
        compile_kernel()
    assert FILM in screen.getvalue()
    assert screen.getvalue().endswith("\x1b[2K")  # the line is erased
