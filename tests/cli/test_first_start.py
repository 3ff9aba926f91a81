"""The note that the first start compiles the kernels."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from dcrb_ros import core
from dcrb_ros.cli import first_start
from dcrb_ros.core.announcement import SENTENCE as COMPILING


@pytest.fixture
def not_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core, "compiled", lambda: False)


@pytest.mark.usefixtures("not_compiled")
def test_the_note_gives_the_time_to_expect(capsys: pytest.CaptureFixture[str]) -> None:
    first_start.announce_compilation()
    with first_start.compilation_shown():
        pass
    assert capsys.readouterr() == ("", f"{COMPILING}\n{COMPILING}\n")
    assert "once, 15 s to over a minute" in COMPILING


@pytest.mark.usefixtures("not_compiled")
def test_a_quiet_command_prints_no_note(capsys: pytest.CaptureFixture[str]) -> None:
    first_start.announce_compilation(quiet=True)
    with first_start.compilation_shown(quiet=True):
        pass
    assert capsys.readouterr() == ("", "")


def test_compiled_kernels_need_no_note(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core, "compiled", lambda: True)
    first_start.announce_compilation()
    with first_start.compilation_shown():
        pass
    assert capsys.readouterr() == ("", "")


@pytest.mark.usefixtures("not_compiled")
def test_a_terminal_shows_a_spinner_that_disappears(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = io.StringIO()
    monkeypatch.setattr(first_start, "console", lambda *, stderr: Console(file=screen, force_terminal=True, width=120, markup=False))
    with first_start.compilation_shown():
        pass
    assert COMPILING in screen.getvalue()
    assert screen.getvalue().endswith("\x1b[2K")  # the line is erased
