"""Text on a terminal is printed literally."""

from __future__ import annotations

import pytest
from rich.progress import TextColumn
from rich.table import Table

from dcrb_ros.runtime.terminal import UNLIMITED, console, progress, stages


def test_units_and_names_in_tables_and_sentences_are_printed_literally(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table("delay [s]", title="of [bold]bags[/bold]/:bug:")
    table.add_row("the width of the defect [mm]")
    console().print(table)
    console().print("load [N]")
    shown = capsys.readouterr().out
    for text in ("delay [s]", "of [bold]bags[/bold]/:bug:", "the width of the defect [mm]", "load [N]"):
        assert text in shown


def test_standard_error_takes_notes(capsys: pytest.CaptureFixture[str]) -> None:
    console(stderr=True).print("a note")
    assert capsys.readouterr() == ("", "a note\n")


def test_a_file_gets_wide_lines_and_a_user_s_width_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    assert console().width == UNLIMITED
    monkeypatch.setenv("COLUMNS", "60")
    assert console().width == 60


def test_the_description_of_a_progress_bar_is_printed_literally(capsys: pytest.CaptureFixture[str]) -> None:
    with progress(TextColumn("done")) as bar:
        bar.add_task("bag [s]", total=1.0, completed=1.0)
    assert "bag [s]" in capsys.readouterr().err


def test_a_quiet_progress_bar_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with progress(TextColumn("done"), quiet=True) as bar:
        bar.add_task("bag", total=1.0, completed=1.0)
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("terminal", [True, False])
def test_stages_are_shown_on_a_terminal_only(terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    if terminal:
        monkeypatch.setenv("FORCE_COLOR", "1")
    with stages() as show:
        show("reading [a]", 0, 0)
        show("writing", 1, 4)
    shown = capsys.readouterr()
    assert not shown.out
    assert [text in shown.err for text in ("reading [a]", "writing", "25%")] == [terminal] * 3
