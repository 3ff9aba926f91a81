"""Recordings read by the MCAP library of JavaScript, which Foxglove uses: the same messages, and the same numbers."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from made_up_blocks import recorded

from dcrb_ros.recordings.reader import Recording

HERE = Path(__file__).parent
BAGS = sorted(path.parent for path in (HERE.parents[1] / "bags").glob("*/metadata.yaml"))


UNREACHABLE = ("ENOTFOUND", "EAI_AGAIN", "ECONNREFUSED", "ECONNRESET", "ETIMEDOUT", "ENETUNREACH", "E403", "E404", "network")
"""What npm says where it has no registry."""


def program(name: str) -> str:
    """Return a program of this machine, or skip."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"needs {name} (Debian: apt-get install nodejs npm)")
    return found


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the library as pinned in `mcap_core/`; return the program that reads with it."""
    npm, folder = program("npm"), tmp_path_factory.mktemp("mcap_core")
    program("node")
    for file in (HERE / "mcap_core").iterdir():
        shutil.copy(file, folder)
    done = subprocess.run(
        [npm, "ci", "--ignore-scripts", "--loglevel=error"], cwd=folder, capture_output=True, text=True, timeout=400, check=False
    )
    said = (done.stderr or done.stdout).strip()[-400:]
    if done.returncode != 0 and any(word in said for word in UNREACHABLE):
        pytest.skip(f"npm cannot reach its registry: {said}")
    assert done.returncode == 0, said
    return folder / "read.mjs"


def read(script: Path, *bags: Path) -> dict[Path, dict[str, Any]]:
    """Return what the library finds in the files of recordings."""
    files = [file for bag in bags for file in sorted(bag.glob("*.mcap"))]
    done = subprocess.run([program("node"), str(script), *map(str, files)], capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr
    return {Path(path): about for path, about in json.loads(done.stdout).items()}


def test_shipped_recordings_are_read(script: Path) -> None:
    found = read(script, *BAGS)
    assert len(found) == len(BAGS) > 0
    for path, about in found.items():
        recording = Recording(path.parent)
        assert about["profile"] == "ros2"
        assert about["counts"] == recording.counts()
        assert set(about["metadata"]) == {"dcrb_ros", "dcrb_ros_outcome", "rosbag2"}
        assert about["waveform"]["fields"] == ["t", "ax", "ay", "shaft_angle"]
        assert about["waveform"]["ay"] == [float(value) for value in next(recording.vibrations()).acceleration[:4, 1]]


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_split_recordings_are_read_however_they_are_packed(script: Path, compression: str, tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 30, compression=compression, split_duration=0.25)
    found = read(script, bag)
    assert len(found) > 1
    topic = "/dcrb/outer_ring/vibration"
    assert sum(about["counts"][topic] for about in found.values()) == 30
    assert all(about["chunks"] > 0 for about in found.values())
