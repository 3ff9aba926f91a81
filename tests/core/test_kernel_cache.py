"""Compiled kernels whose files are damaged are not executed, but compiled again."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from attacked_files import ATTACKS

pytestmark = pytest.mark.slow

PROGRAM = """
from dcrb_ros.core.announcement import announce_compilation
from dcrb_ros.core.jit import loop
announce_compilation(print)

@loop
def add(x, y):
    return x + y

print(add(1, 2), add(1.5, 2.0), sum(add.stats.cache_hits.values()))
"""


def swap(file: Path) -> None:
    other = next(one for one in file.parent.glob(f"*{file.suffix}") if one != file)
    content = other.read_bytes()
    other.write_bytes(file.read_bytes())
    file.write_bytes(content)


def ran(folder: Path) -> list[str]:
    program = folder / "program.py"
    if not program.exists():  # numba compiles a touched source again
        program.write_text(PROGRAM)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache")}
    done = subprocess.run([sys.executable, str(program)], env=environment, capture_output=True, text=True, timeout=600.0, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.parametrize("attack", ["swapped", "flipped", "truncated", "folder", "pipe", "link to other bytes"])
def test_a_damaged_kernel_is_named_and_compiled_again(attack: str, tmp_path: Path) -> None:
    ran(tmp_path)
    assert ran(tmp_path) == ["3 3.5 2"]
    damaged = min((tmp_path / "cache").rglob("program.add-*.nbc"))
    (ATTACKS | {"swapped": swap})[attack](damaged)
    answer = ran(tmp_path)
    assert f"{damaged} is damaged: its kernel is compiled again" in answer
    assert answer[-1] == ("3 3.5 0" if attack == "swapped" else "3 3.5 1")
    assert ran(tmp_path) == ["3 3.5 2"]


@pytest.mark.parametrize("attack", ["flipped", "empty", "folder", "pipe", "broken link", "unreadable"])
def test_a_damaged_index_is_named_and_made_again(attack: str, tmp_path: Path) -> None:
    ran(tmp_path)
    (damaged,) = (tmp_path / "cache").rglob("program.add-*.nbi")
    ATTACKS[attack](damaged)
    answer = ran(tmp_path)
    assert f"{damaged} is damaged: its kernel is compiled again" in answer
    assert answer[-1].startswith("3 3.5 ")
    assert ran(tmp_path) == ["3 3.5 2"]
