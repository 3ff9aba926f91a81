"""Hostile inputs are answered in bounded time and memory, and in sentences; the corpus is in `hostile_corpus`.

A part of it is run by default, with a limit of time relative to a fixed task on the same machine; all of it with ``DCRB_HOSTILE=all``
(``make hostile``), with a limit in seconds.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from hostile_corpus import CASES, INPUT, MEGABYTE, NEW, Case
from made_up_blocks import recorded
from measured_commands import Commands, commands
from scipy.io import wavfile

from dcrb_ros.cli.config import MOST_ERRORS

pytestmark = [pytest.mark.skipif(os.name != "posix", reason="limits of processes"), pytest.mark.slow]
SECONDS_PER_MB = 2.0
"""Processor time for each megabyte of input, and for any smaller input, on a machine that does nothing else [s]."""
REFERENCES_PER_MB = 50.0
"""The same in times of the fixed task, which takes 0.04 s where the seconds were measured."""
ATTEMPTS = 3
"""Measurements of a command that takes too long: a busy machine slows down single ones."""
MOST_RESIDENT = 500.0
"""Memory of a command, libraries included [MB]."""
ALL = os.environ.get("DCRB_HOSTILE") == "all"
CHOSEN = [name for name, case in CASES.items() if case.quick or ALL]


@pytest.fixture(scope="module")
def dcrb() -> Iterator[Commands]:
    with commands() as parent:
        yield parent


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return inputs that are not hostile, by their placeholders."""
    folder = tmp_path_factory.mktemp("sound")
    wavfile.write(folder / "wave.wav", 51200, np.ones((1000, 2), np.int16))
    orders = {"FTF": 0.4, "BPFO": 3.6, "BPFI": 5.4, "BSF": 2.4}
    about = {"channels": {"ax": "de"}, "unit": "g", "speed_rpm": 1797, "sampling_rate": 12000, "orders": orders}
    (folder / "about.yaml").write_text(yaml.safe_dump(about))
    return {"WAVE": str(folder / "wave.wav"), "ABOUT": str(folder / "about.yaml"), "GOOD": str(recorded(folder / "good", 3))}


def size(path: Path) -> int:
    """Return the size of a file, or of the files in a folder [bytes]; 0 of anything else."""
    files = [path] if path.is_file() else path.rglob("*")
    return sum(file.stat().st_size for file in files if file.is_file())


def test_a_command_without_hostile_input_is_measured(dcrb: Commands, sound: dict[str, str]) -> None:
    found = dcrb.run("info", sound["GOOD"])
    assert found.status == 0, found.output
    assert "/dcrb/outer_ring/vibration" in found.output
    assert 50.0 < found.resident < MOST_RESIDENT


def allowed_per_megabyte(dcrb: Commands) -> float:
    """Return the processor time for each megabyte of input on the machine as it is now [s]."""
    return SECONDS_PER_MB if ALL else REFERENCES_PER_MB * dcrb.reference()


@pytest.fixture(scope="module")
def seconds_per_megabyte(dcrb: Commands) -> float:
    return allowed_per_megabyte(dcrb)


@pytest.mark.parametrize("name", CHOSEN)
def test_hostile_input_is_answered_in_bounded_time_and_memory(
    name: str, dcrb: Commands, seconds_per_megabyte: float, sound: dict[str, str], tmp_path: Path
) -> None:
    case: Case = CASES[name]
    path = tmp_path / f"input{case.suffix}"
    case.make(path)
    megabytes = max(1.0, size(path) / MEGABYTE)
    answers = []
    for number, command in enumerate(case.commands):
        for attempt in range(ATTEMPTS):
            words = {INPUT: str(path), NEW: str(tmp_path / f"new{number}-{attempt}"), **sound}
            arguments = [_replaced(argument, words) for argument in command]
            allowed = megabytes * (allowed_per_megabyte(dcrb) if attempt else seconds_per_megabyte)
            found = dcrb.run(*arguments, seconds=3.0 * allowed)
            shown = f"{' '.join(arguments)}: {found.seconds:.2f} s of {allowed:.2f} s, {found.resident:.0f} MB\n{found.output[:2000]}"
            assert found.status in case.statuses, f"status {found.status}: {shown}"
            if found.seconds <= allowed:
                break
        assert "Traceback" not in found.output, shown
        assert not set(found.output) & {"\x1b", "\x07", "\x9b", "\0"}, shown
        assert len(found.output) < case.most_output, shown
        assert found.seconds <= allowed, shown
        assert found.resident <= MOST_RESIDENT, shown
        if found.status == 2:
            most = MOST_ERRORS + 1 if command[:2] == ("config", "check") else 1  # which lists what is wrong
            assert 1 <= found.output.count("dcrb: ") <= most, shown
        answers.append(found.output)
    assert any(case.words in answer.replace("\n", "") for answer in answers), answers


def _replaced(argument: str, words: dict[str, str]) -> str:
    for placeholder, value in words.items():
        if argument == placeholder or argument.startswith(f"{placeholder}."):
            return value + argument[len(placeholder) :]
    return argument
