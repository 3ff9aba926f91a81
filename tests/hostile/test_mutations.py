"""Random changes of sound files and random command lines: each is answered by work or by one sentence, and none is accepted in silence.

Only `make hostile` runs them, since they take long. It prints each flaw when it is found, and the number of inputs so far.
``DCRB_HOSTILE_FIRST`` chooses other ones, and ``DCRB_HOSTILE_CASES`` is the number of each kind.
"""

from __future__ import annotations

import math
import os
import random
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import click
import pytest
import typer
from hostile_mutations import Target, catalogue_line, command_line
from hostile_runs import Case, Change, flaws, made
from hostile_targets import Material, targets
from measured_commands import Commands, commands

from dcrb_ros.cli.app import app
from dcrb_ros.settings.files import flatten, load_configuration

ALL = os.environ.get("DCRB_HOSTILE") == "all"
pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="limits of processes"),
    pytest.mark.skipif(not ALL, reason="make hostile runs it"),
    pytest.mark.slow,
    pytest.mark.timeout(3600),
]
FIRST = int(os.environ.get("DCRB_HOSTILE_FIRST", "0"))
"""Number of the first case of each kind."""
CASES = int(os.environ.get("DCRB_HOSTILE_CASES", "200"))
"""Cases of each kind."""
LINES = 15 * CASES
"""Command lines."""
BEARINGS = 20 * CASES
"""Calls of `dcrb config new`."""
BATCH = 20
"""Commands in one process."""
ENDLESS = ("bench", "replay", "validate", "calibrate", "exam predictivity", "cache")
"""Commands that are not called with random options: they run for long, or delete the caches."""


@pytest.fixture(scope="module")
def dcrb() -> Iterator[Commands]:
    with commands() as parent:
        yield parent


@pytest.fixture(scope="module")
def material(dcrb: Commands, tmp_path_factory: pytest.TempPathFactory) -> Material:
    return Material(tmp_path_factory.mktemp("sound"), dcrb.run)


@pytest.fixture(scope="module")
def kinds(material: Material) -> dict[str, Target]:
    return targets(material)


def made_all(kinds: dict[str, Target], material: Material, folder: Path, numbers: range, *, sound: bool = False) -> list[list[Case]]:
    """Make cases of all kinds, kind by kind."""
    cases = []
    for place, (name, target) in enumerate(kinds.items()):
        folders = [folder / f"{place}-{number}" for number in numbers]
        for one in folders:
            one.mkdir()
        cases.append([made(name, target, number, material, one, sound=sound) for number, one in zip(numbers, folders, strict=True)])
    return cases


def test_files_without_a_change_are_read(kinds: dict[str, Target], material: Material, dcrb: Commands, tmp_path: Path) -> None:
    """Otherwise every change of a kind could be refused for the same reason."""
    cases = [case for group in made_all(kinds, material, tmp_path, range(2), sound=True) for case in group]
    answers = dcrb.run_many([case.command for case in cases])
    refused = [(str(case), answer.output) for case, answer in zip(cases, answers, strict=True) if answer.status == 2]
    assert not refused


Judge = Callable[[Sequence[Case]], list[str]]


@pytest.fixture
def judge(dcrb: Commands, tally: Counter[str], say: Callable[[str], None]) -> Judge:
    """Return a function that runs cases of one kind and prints and returns their flaws."""

    def judged(cases: Sequence[Case]) -> list[str]:
        found = flaws(cases, dcrb)
        tally[cases[0].target] += len(cases)
        for flaw in found:
            say(f"flaw: {flaw}")
        say(f"{tally.total()} inputs; {len(found)} flaws in {len(cases)} of: {cases[0].target}")
        return found

    return judged


def test_changed_files_are_refused_in_a_sentence_or_used(
    kinds: dict[str, Target], material: Material, tmp_path: Path, judge: Judge
) -> None:
    found = []
    for first in range(FIRST, FIRST + CASES, BATCH):
        folder = tmp_path / str(first)
        folder.mkdir()
        for cases in made_all(kinds, material, folder, range(first, min(first + BATCH, FIRST + CASES))):
            found += judge(cases)
        shutil.rmtree(folder)
    assert not found, "\n".join(found)


def options_of_commands() -> dict[str, list[str]]:
    """Return the options of every command."""
    found = {}
    todo: list[tuple[str, click.Command]] = [("", typer.main.get_command(app))]
    while todo:
        name, command = todo.pop()
        if isinstance(command, click.Group):
            todo += [(f"{name} {child}".strip(), one) for child, one in command.commands.items()]
        elif name not in ENDLESS:
            found[name] = [option for parameter in command.params for option in parameter.opts if option.startswith("-")]
    return dict(sorted(found.items()))


def test_random_command_lines_are_refused_in_a_sentence(
    material: Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, judge: Judge
) -> None:
    monkeypatch.chdir(tmp_path)
    options, files = options_of_commands(), [material.words["GOOD"], material.words["ABOUT"], str(tmp_path), str(tmp_path / "new")]
    found: list[str] = []
    for first in range(FIRST, FIRST + LINES, BATCH):
        lines = [command_line(random.Random(number), options, files) for number in range(first, first + BATCH)]
        found += judge([Case("a command line", number, Change(b"", ""), tuple(line)) for number, line in enumerate(lines, first)])
    assert not found, "\n".join(found)


def test_catalogue_numbers_give_what_was_asked_or_are_refused(tmp_path: Path, say: Callable[[str], None], judge: Judge) -> None:
    found: list[str] = []
    for first in range(FIRST, FIRST + BEARINGS, BATCH):
        lines = [catalogue_line(random.Random(f"catalogue {number}")) for number in range(first, first + BATCH)]
        files = [tmp_path / f"{number}.yaml" for number in range(first, first + BATCH)]
        commands = [(*line.words, "-o", str(file)) for line, file in zip(lines, files, strict=True)]
        found += judge([Case("catalogue", number, Change(b"", ""), command) for number, command in enumerate(commands, first)])
        for command, line, file in zip(commands, lines, files, strict=True):
            if file.exists() and (wrong := differing(file, line.asked)):
                found.append(f"{wrong}: dcrb {' '.join(command)}")
                say(f"flaw: {found[-1]}")
    assert not found, "\n".join(found)


def differing(file: Path, asked: dict[str, float]) -> dict[str, tuple[float, float]]:
    """Return the parameters of a configuration that are not as asked."""
    used = flatten(load_configuration(str(file)).model_dump())
    return {key: (used[key], value) for key, value in asked.items() if not math.isclose(used[key], value, rel_tol=1e-6)}
