"""The first compilation, shared between two processes."""

from __future__ import annotations

import errno
import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numba
import pytest

from dcrb_ros import core
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core import CACHE, compilation
from dcrb_ros.core.jit import loop
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.settings.configuration import Configuration

PATIENCE = 400.0


def test_the_other_process_ends_with_the_one_that_started_it(tmp_path: Path) -> None:
    configuration = Configuration()
    payload = build_payload(configuration)
    wanted = [numba.typeof(part) for part in (payload, initial_state(configuration, payload), workspace(payload))]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    with subprocess.Popen([sys.executable, "-m", compilation.MODULE], stdin=subprocess.PIPE, env=environment) as other:
        other.communicate(pickle.dumps(wanted), PATIENCE)  # and closes the pipe, as the end of a process does
    assert other.returncode == compilation.ORPHANED  # 1 if it had failed
    assert not list(tmp_path.rglob("*linearize_raceways-*.nbc"))  # it had ten seconds to go


def test_nothing_is_started_where_the_loop_lies_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    configuration = Configuration()
    payload = build_payload(configuration)

    def start(*arguments: object, **options: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr(compilation.subprocess, "Popen", start)
    arguments = payload, initial_state(configuration, payload), workspace(payload)
    monkeypatch.setattr(compilation, "CACHE", tmp_path)
    compilation._marker(tuple(numba.typeof(part) for part in arguments)).touch()
    compilation.compile_ahead(*arguments)


def test_without_a_second_process_the_kernels_are_compiled_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    configuration, found = Configuration(), []
    payload = build_payload(configuration)
    monkeypatch.setattr(compilation, "CACHE", tmp_path / "kernels")
    (tmp_path / "kernels").mkdir()
    monkeypatch.setattr(compilation, "MODULE", "dcrb_ros.no_such_module")
    monkeypatch.setattr(compilation, "compile_parts", lambda parts, arguments, progress: found.append(parts))
    compilation.compile_ahead(payload, initial_state(configuration, payload), workspace(payload))
    assert found == [compilation.HERE, compilation.LAST]


def test_on_one_core_all_parts_are_compiled_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    configuration, found = Configuration(), []
    payload = build_payload(configuration)
    monkeypatch.setattr(compilation, "CACHE", tmp_path)
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr(compilation, "compile_parts", lambda parts, arguments, progress: found.append(parts))
    compilation.compile_ahead(payload, initial_state(configuration, payload), workspace(payload))
    assert found == [(*compilation.HERE, *compilation.THERE), compilation.LAST]


def test_progress_names_the_part_and_the_time_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    clock = iter((0.0, 21.4, 31.6))
    monkeypatch.setattr(compilation, "time", SimpleNamespace(monotonic=lambda: next(clock)))  # other threads read the clock, too
    monkeypatch.setattr(compilation, "announce_progress", said.append)
    progress = compilation.Progress(4, alone=False)
    for part in compilation.HERE:
        progress.begin(part)
    assert said == [
        "compiling the kernels: cages, part 2 of 4, done in 28 s ...",  # 21.4 s for 43 % of the work
        "compiling the kernels: velocities, part 3 of 4, done in 19 s ...",  # 31.6 s for 63 %
    ]
    assert sum(part.share for part in (*compilation.HERE, *compilation.LAST)) == pytest.approx(1.0)


@pytest.mark.parametrize(("hours", "kept"), [(0.5, True), (2.0, False)])
def test_the_folder_of_an_earlier_version_is_removed_once_unused(tmp_path: Path, hours: float, kept: bool) -> None:
    package, chosen = copied_core(tmp_path / "package"), tmp_path / "cache"
    (before,) = set(cache_of(package, chosen))
    (other,) = set(cache_of(copied_core(tmp_path / "other"), chosen))
    for folder in (before, other):
        last = (folder / core.SOURCES).stat().st_mtime - 3600.0 * hours
        os.utime(folder / core.SOURCES, (last, last))
    law = package / "dcrb_ros" / "core" / "laws" / "johnson.py"
    law.write_text(law.read_text() + "\n# another version\n")
    (after,) = set(cache_of(package, chosen))
    assert before.exists() is kept
    assert other.exists()  # that of another checkout
    assert after.exists()


def cache_of(package: Path, chosen: Path) -> list[Path]:
    """Return the folders of the compile cache, ours and numba's, of a package run with NUMBA_CACHE_DIR ``chosen``."""
    code = "import numba\nfrom dcrb_ros.core import CACHE\nprint(CACHE, numba.config.CACHE_DIR)"
    environment = {**os.environ, "PYTHONPATH": str(package), "NUMBA_CACHE_DIR": str(chosen)}
    done = subprocess.run([sys.executable, "-c", code], cwd=package, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    return [Path(folder) for folder in done.stdout.split()]


def copied_core(package: Path) -> Path:
    """Return a package with nothing but a copy of the core."""
    shutil.copytree(Path(__file__).parents[2] / "dcrb_ros" / "core", package / "dcrb_ros" / "core")
    (package / "dcrb_ros" / "__init__.py").touch()
    return package


def test_another_checkout_has_a_cache_of_its_own(tmp_path: Path) -> None:
    # Numba's files are keyed by the path of the source: those of another checkout are no use, and hid that this one had to compile.
    one, other = (cache_of(copied_core(tmp_path / name), tmp_path / "cache") for name in ("one", "other"))
    assert not set(one) & set(other)


def test_an_upgrade_runs_no_old_kernels_from_a_folder_of_the_users(tmp_path: Path) -> None:
    package, chosen = tmp_path / "package", tmp_path / "cache"
    copied_core(package)
    before = cache_of(package, chosen)
    assert cache_of(package, chosen) == before
    assert {folder.parent for folder in before} == {chosen}
    law = package / "dcrb_ros" / "core" / "laws" / "johnson.py"
    law.write_text(law.read_text() + "\n# another version\n")
    after = cache_of(package, chosen)
    assert {folder.parent for folder in after} == {chosen}
    assert not set(after) & set(before)


@pytest.mark.skipif(os.name != "posix", reason="who may write is told by the mode")
@pytest.mark.parametrize("mode", [0o777, 0o720, 0o702])
def test_kernels_are_not_taken_from_a_folder_that_others_can_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: int) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    own = core._own_temporary_folder()
    assert core._own_temporary_folder() == own  # it is taken again
    own.chmod(mode)
    with pytest.raises(PermissionError):
        core._own_temporary_folder()


def test_kernels_are_not_taken_from_a_file_or_a_link_to_another_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    own = core._own_temporary_folder()
    own.rmdir()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    own.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(PermissionError):
        core._own_temporary_folder()


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_a_cache_on_a_full_disk_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    @loop
    def doubled(value: float) -> float:
        return 2.0 * value

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    with pytest.raises(OSError, match="No space left on device") as failed:
        doubled(1.0)
    assert str(failed.value.filename).startswith(str(CACHE))
