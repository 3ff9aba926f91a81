"""Runs of random hostile inputs: each case is made from a seed and a number, and its answer is judged."""

from __future__ import annotations

import random
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from hostile_corpus import INPUT, NEW
from hostile_mutations import Change, Target
from hostile_targets import Material
from measured_commands import Commands, Measured

MOST_SECONDS = 30.0
"""Processor time after which a command is ended [s]."""
MOST_RESIDENT = 900.0
"""Memory of a command, libraries included [MB]."""
MOST_OUTPUT = 200_000
"""Longest answer [characters]."""
UNEXPECTED = "DCRB_DEBUG=1"
"""What the command line adds to an exception that no code has turned into a sentence."""
FORBIDDEN = {"\x1b", "\x07", "\x9b", "\0"}
"""Characters that no answer has."""
WARNINGS = re.compile(r"warning|left out|damaged|differ|changed|missing|imported|not the|ignored|lost|cannot", re.IGNORECASE)
"""Words of an answer that is not silent."""


@dataclass(frozen=True)
class Case:
    """A hostile input as it was made."""

    target: str
    number: int
    change: Change
    command: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.target} #{self.number}: {self.change.words}: dcrb {' '.join(self.command)}"


def made(name: str, target: Target, number: int, material: Material, folder: Path, *, sound: bool = False) -> Case:
    """Make a case in an empty folder; a ``sound`` one is the file without a change."""
    draw = random.Random(f"{name} {number}")
    change = Change(target.content, "no change") if sound else target.change(draw, target.content)
    command = target.commands[number % len(target.commands)]
    if ":" in name:
        whole, _, file = name.partition(":")
        path = folder / "input"
        material.copied(whole, path, file, change.content)
    elif "LIST" in command:  # the table names files beside it
        shutil.copytree(
            material.folder, folder / "input", ignore=shutil.ignore_patterns("set", "run", "shards", "good", "long", "simulated")
        )
        path = folder / "input" / "list.csv"
        path.write_bytes(change.content)
    else:
        path = folder / f"input{target.suffix}"
        path.write_bytes(change.content)
    words = {INPUT: str(path), NEW: str(folder / "new"), "LIST": str(path), **material.words}
    return Case(name, number, change, tuple(_replaced(word, words) for word in command))


def _replaced(word: str, words: Mapping[str, str]) -> str:
    for placeholder, value in words.items():
        if word == placeholder or word.startswith((f"{placeholder}.", f"{placeholder}/")):
            return value + word[len(placeholder) :]
    return word


def flaw(answer: Measured, must_fail: bool, command: Sequence[str]) -> str:
    """Return what is wrong with an answer; the empty string if nothing is."""
    if "Traceback" in answer.output:
        return "a traceback"
    if UNEXPECTED in answer.output:
        return "an unexpected exception"
    if answer.status not in (0, 1, 2):
        return f"status {answer.status}"
    if set(answer.output) & FORBIDDEN:
        return "control characters"
    if answer.resident > MOST_RESIDENT:
        return f"{answer.resident:.0f} MB"
    if len(answer.output) > MOST_OUTPUT:
        return f"{len(answer.output)} characters"
    sentences = answer.output.count("dcrb: ")
    if answer.status == 2 and sentences != 1 and tuple(command[:2]) != ("config", "check"):
        return f"{sentences} sentences with status 2"
    if answer.status == 1 and not answer.output.strip():
        return "status 1 without a word"
    if answer.status == 0 and must_fail and not WARNINGS.search(answer.stderr):
        return "accepted in silence"
    return ""


def flaws(cases: Sequence[Case], dcrb: Commands) -> list[str]:
    """Run cases; return what is wrong with their answers, and the answers."""
    found = []
    for case, answer in zip(cases, dcrb.run_many([case.command for case in cases], seconds=MOST_SECONDS), strict=True):
        if wrong := flaw(answer, case.change.must_fail, case.command):
            found.append(f"{wrong}: {case}: status {answer.status}, {answer.seconds:.1f} s\n{answer.output[:2000]}")
    return found
