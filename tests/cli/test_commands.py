"""Help pages show the texts of the commands, with every unit."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
import typer
from same_process import dcrb

from dcrb_ros.cli.app import app
from dcrb_ros.cli.commands import Commands
from dcrb_ros.runtime.exit_status import exit_status

IN_BRACKETS = re.compile(r"\[[^\[\]]+\]")


def commands(command: Any, *names: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield every command with its names."""
    yield names, command
    for name, below in getattr(command, "commands", {}).items():
        yield from commands(below, *names, name)


PAGES = dict(commands(typer.main.get_command(app)))


def words(text: str) -> str:
    """Return a text without frames and line breaks."""
    return " ".join(re.sub("[│╭╮╰╯─]", " ", text).split())


@pytest.mark.parametrize("names", PAGES, ids=lambda names: " ".join(names) or "dcrb")
def test_a_help_page_shows_everything_in_brackets(
    names: tuple[str, ...], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERMINAL_WIDTH", "200")
    assert dcrb(*names, "--help") == 0
    page = words(capsys.readouterr().out)
    command = PAGES[names]
    for text in (command.help or "", *(parameter.help or "" for parameter in command.params)):
        for found in IN_BRACKETS.findall(text):
            assert found in page


def test_units_occur_in_help_texts() -> None:
    texts = " ".join(parameter.help or "" for command in PAGES.values() for parameter in command.params)
    assert {"[s]", "[Hz]", "[rad/s]", "[-]"} <= set(IN_BRACKETS.findall(texts))


def made_up() -> typer.Typer:
    group = Commands(help="Speeds [rad/s].")
    below = Commands(help="Below [m].")

    @group.command()
    def turn(speed: float = typer.Option(1.0, help="Speed [rad/s], not [bold]bold[/bold].")) -> None:
        """Turn for some time [s]."""

    @below.command()
    def press(load: float = typer.Argument(help="Load [N].")) -> None:
        """Press [kN]."""

    group.add_typer(below, name="below")
    return group


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (["--help"], ["Speeds [rad/s].", "Turn for some time [s].", "Below [m]."]),
        (["turn", "--help"], ["Turn for some time [s].", "Speed [rad/s], not [bold]bold[/bold]."]),
        (["below", "press", "--help"], ["Press [kN].", "Load [N]."]),
    ],
)
def test_markup_is_printed_literally(arguments: list[str], shown: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_status("made up", lambda: made_up()(arguments, standalone_mode=False)) == 0
    page = words(capsys.readouterr().out)
    for text in shown:
        assert text in page


def test_completion_shows_units(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_DCRB_COMPLETE", "complete_zsh")
    monkeypatch.setenv("_TYPER_COMPLETE_ARGS", "dcrb simulate healthy --dur")
    assert dcrb() == 0
    assert '"--duration":"Simulated time [s], above 0' in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "named"),
    [
        (("simulate", "healthy", "--duration", "1,5"), "'1,5'"),
        (("simulate", "healthy", "--duration", "\N{MINUS SIGN}1"), "'\N{MINUS SIGN}1'"),
        (("sweep", "two_hundred", "-o", "new", "--workers", "0"), "0"),
        (("collect", "list.csv", "-o", "new", "--overlap", "1.5"), "1.5"),
    ],
)
def test_an_error_about_an_option_names_its_value(command: tuple[str, ...], named: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(*command) == 2
    option = command[-2]
    said = capsys.readouterr().err
    assert option in said
    assert named in said.partition(option)[2]


@pytest.mark.parametrize(
    "command",
    [
        ("score", "smoke", "--list", "--recordings", ""),
        ("simulate", "dry", "-o", ""),
        ("exam", "table", ".", "-o", ""),
        ("sweep", "two_hundred", "-o", ""),
        ("collect", "list.csv", "-o", ""),
        ("info", ""),
        ("score", "bags/healthy", ""),
        ("detect", "bags/healthy", ""),
        ("import", "", "--about", "about.yaml", "-o", "new"),
    ],
)
def test_an_empty_path_is_not_the_current_folder(command: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(*command) == 2
    assert " is empty: give a path" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        (("info", ""), "BAG is empty: give a path, such as . for this folder\n"),
        (("detect", ""), "BAG is empty: give a path, such as . for this folder\n"),
        (("view", "bags/healthy", "--save", ""), "--save is empty: give a path, such as . for this folder, or leave it out\n"),
    ],
)
def test_a_path_that_must_be_given_cannot_be_left_out(command: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(*command) == 2
    assert capsys.readouterr().err.endswith(sentence)


@pytest.mark.parametrize("group", [(), ("config",), ("exam",)])
def test_a_missing_command_is_named(group: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(*group) == 2
    output = capsys.readouterr()
    assert output.err == "dcrb: a command is missing (try --help)\n"
    assert "--help" in output.out
