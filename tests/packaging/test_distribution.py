"""What is distributed and installed."""

from __future__ import annotations

import configparser
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NODES = {"simulator", "vehicle_simulator", "replayer", "fault_detector", "vehicle_detector", "hot_box_detector", "viewer"}
OF_GIT = {".gitattributes", ".gitignore", ".dockerignore"}
"""Files that only the repository needs."""


@pytest.fixture(scope="module")
def described(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder in which setuptools describes the distribution."""
    folder = tmp_path_factory.mktemp("description")
    command = [sys.executable, "-W", "ignore", "setup.py", "--quiet", "egg_info", "--egg-base", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, timeout=400, capture_output=True)
    return folder / "dcrb_ros.egg-info"


def test_the_source_distribution_contains_every_file_of_the_repository(described: Path) -> None:
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("not a git repository")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, timeout=400, capture_output=True, text=True).stdout
    tracked = {name for name in listed.split("\0") if name and (ROOT / name).exists()}
    distributed = set((described / "SOURCES.txt").read_text(encoding="utf-8").splitlines())
    assert tracked - distributed - OF_GIT == set()


def test_console_scripts_have_a_name_of_their_own(described: Path) -> None:
    points = configparser.ConfigParser()
    points.read(described / "entry_points.txt")
    assert set(points["console_scripts"]) == {"dcrb", *(f"dcrb_{node}" for node in NODES)}


@pytest.mark.parametrize(("executable", "script"), [("dcrb", "dcrb"), *((node, f"dcrb_{node}") for node in sorted(NODES))])
def test_an_executable_of_ros2_run_starts_the_console_script_of_its_installation(executable: str, script: str, tmp_path: Path) -> None:
    installed, console_script = tmp_path / "a prefix/lib/dcrb_ros" / executable, tmp_path / "a prefix/bin" / script
    installed.parent.mkdir(parents=True)
    installed.symlink_to(ROOT / "executables" / executable)  # as colcon build --symlink-install does
    console_script.parent.mkdir()
    console_script.write_text('#!/bin/sh\nprintf "%s|" "$0" "$@"\nexit 7\n')
    console_script.chmod(0o755)
    done = subprocess.run([str(installed), "--ros-args", "-r", "a b"], capture_output=True, text=True, timeout=400, check=False)
    assert (done.returncode, done.stderr) == (7, "")
    started, *arguments = done.stdout.split("|")[:-1]
    assert Path(started).resolve() == console_script
    assert arguments == ["--ros-args", "-r", "a b"]


def test_the_container_does_not_run_as_root() -> None:
    steps = [line.split() for line in (ROOT / "Dockerfile").read_text(encoding="utf-8").splitlines() if line and line[0].isupper()]
    users = [words[1] for words in steps if words[0] == "USER"]
    assert users
    assert users[-1] not in ("root", "0")
    assert [words[0] for words in steps][-1] == "CMD"


def test_make_clean_removes_the_caches() -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not installed")
    commands = subprocess.run(["make", "--dry-run", "clean"], cwd=ROOT, check=True, timeout=400, capture_output=True, text=True).stdout
    assert "dcrb cache --clear" in commands
    assert commands.index("cache --clear") < commands.index("rm -rf .venv")
