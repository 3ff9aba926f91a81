"""Existing files and recordings are refused, or replaced with --force; a failure brings them back."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from made_up_blocks import recorded
from same_process import dcrb

from dcrb_ros.cli.output_file import check_file, replacing
from dcrb_ros.schema.refusal import Refusal


def entries(folder: Path) -> set[str]:
    return {entry.name for entry in folder.iterdir()}


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    return recorded(tmp_path / "bag", 3)


def test_a_new_path_is_written(tmp_path: Path) -> None:
    for force in (False, True):
        with replacing("-o", tmp_path / f"{force}.txt", force=force):
            (tmp_path / f"{force}.txt").write_text("new")
    assert entries(tmp_path) == {"True.txt", "False.txt"}


def test_an_existing_file_is_refused_with_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    with (
        pytest.raises(Refusal, match=r"-o .*/a exists: give another name, or --force to replace it"),
        replacing("-o", tmp_path / "a", force=False),
    ):
        pytest.fail("the work began")


def test_an_existing_file_is_checked_but_not_moved(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "b").mkdir()
    check_file("-o", tmp_path / "a", force=True)
    with pytest.raises(Refusal, match=r"-o .*/a exists: give another name, or --force to replace it"):
        check_file("-o", tmp_path / "a", force=False)
    with pytest.raises(Refusal, match=r"-o .*/b is a folder: give the name of a file in it"):
        check_file("-o", tmp_path / "b", force=True)
    assert (tmp_path / "a").read_text() == "old"


def test_a_device_or_a_pipe_is_written_without_force(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/null")):
        check_file("--junit", path, force=False)


def test_an_existing_file_or_recording_is_replaced(bag: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("old")
    for path in (tmp_path / "file", bag):
        with replacing("-o", path, force=True):
            assert not path.exists()
            path.write_text("new")
        assert path.read_text() == "new"
    assert entries(tmp_path) == {"file", "bag"}


def half_done(path: Path, failure: type[BaseException]) -> None:
    """Replace a recording, and fail after half of the work."""
    with replacing("-o", path, force=True):
        path.mkdir()
        (path / "half").touch()
        raise failure


@pytest.mark.parametrize("failure", [KeyboardInterrupt, RuntimeError])
def test_a_failure_brings_back_the_old_one(failure: type[BaseException], bag: Path, tmp_path: Path) -> None:
    before = entries(bag)
    with pytest.raises(failure):
        half_done(bag, failure)
    assert entries(bag) == before
    assert entries(tmp_path) == {"bag"}


def test_a_folder_that_is_not_a_recording_is_never_replaced(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    (home / "letters").mkdir()
    with pytest.raises(Refusal, match="contains letters, which is not part of a recording"), replacing("-o", home, force=True):
        pytest.fail("the work began")
    assert entries(home) == {"letters"}


def test_the_recording_that_is_read_is_never_replaced(bag: Path, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(bag)
    for path, source in ((bag, bag), (tmp_path / "link", bag), (bag, bag / "bag_0.mcap"), (tmp_path, bag)):
        with pytest.raises(Refusal, match="contains the recording that is read"), replacing("-o", path, force=True, source=source):
            pytest.fail("the work began")


def test_a_folder_that_cannot_be_moved_is_refused(bag: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(bag)
    with pytest.raises(Refusal, match=r"-o \. cannot be replaced: .*; give another name"), replacing("-o", Path(), force=True):
        pytest.fail("the work began")
    assert bag.is_dir()


def outputs(tmp_path: Path, bag: Path) -> dict[str, list[str]]:
    """Return a command for each output."""
    return {
        "picture.png": ["plot", str(bag), "-o", str(tmp_path / "picture.png")],
        "wave.npz": ["export", str(bag), "-o", str(tmp_path / "wave.npz")],
        "wave.npz.yaml": ["export", str(bag), "-o", str(tmp_path / "wave.npz")],
        "view.rrd": ["view", str(bag), "--save", str(tmp_path / "view.rrd")],
        "shot.png": ["view", str(bag), "--screenshot", str(tmp_path / "shot.png")],
        "copy": ["recover", str(bag), "-o", str(tmp_path / "copy")],
        "again": ["simulate", "healthy", "--duration", "0.01", "-o", str(tmp_path / "again")],
        "bench": ["bench", "healthy", "--record", str(tmp_path / "bench")],
        "report.xml": ["score", str(bag), "--reference", "--junit", str(tmp_path / "report.xml")],
        "report.png": ["score", str(bag), "--reference", "--figure", str(tmp_path / "report.png")],
        "entry.json": ["score", str(bag), "--reference", "--entry", str(tmp_path / "entry.json")],
        "tables.md": ["exam", "predictivity", "recordings.csv", "-o", str(tmp_path / "tables.md")],
        "marks.png": ["exam", "predictivity", "recordings.csv", "--figure", str(tmp_path / "marks.png")],
    }


WRITTEN = ("picture.png", "wave.npz", "wave.npz.yaml", "view.rrd", "shot.png", "copy", "again", "bench")
REPORTS = ("report.xml", "report.png", "entry.json")


@pytest.mark.parametrize("name", [*WRITTEN, *REPORTS, "tables.md", "marks.png"])
def test_every_command_refuses_what_exists(name: str, bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / name).write_text("old")
    assert dcrb(*outputs(tmp_path, bag)[name]) == 2
    assert f"{tmp_path / name} exists: give another name, or --force to replace it" in capsys.readouterr().err
    assert (tmp_path / name).read_text() == "old"


@pytest.mark.parametrize("name", ["picture.png", "wave.npz", "wave.npz.yaml", "view.rrd", "copy"])
def test_every_command_replaces_with_force(name: str, bag: Path, tmp_path: Path) -> None:
    (tmp_path / name).write_text("old")
    assert dcrb(*outputs(tmp_path, bag)[name], "--force") == 0
    assert (tmp_path / name).is_dir() or (tmp_path / name).read_bytes() != b"old"


@pytest.mark.parametrize("name", REPORTS)
def test_a_report_is_replaced_with_force(name: str, bag: Path, tmp_path: Path) -> None:
    (tmp_path / name).write_text("old")
    assert dcrb(*outputs(tmp_path, bag)[name], "--force", "--workers", "1") == 1  # the recording is too short for a verdict
    assert (tmp_path / name).read_bytes() != b"old"


def test_work_that_writes_nothing_brings_back_the_old_one(bag: Path, tmp_path: Path) -> None:
    before = entries(bag)
    with replacing("-o", bag, force=True):
        pass  # such as a bench that is stopped before its simulator starts
    assert entries(bag) == before
    assert entries(tmp_path) == {"bag"}


def test_the_old_one_is_never_deleted_unless_it_is_replaced(bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = entries(bag)
    rename = Path.rename

    def interrupted(source: Path, target: Path) -> Path:
        if target == bag:
            raise KeyboardInterrupt
        return rename(source, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt):
        half_done(bag, RuntimeError)
    (kept,) = tmp_path.glob(".replaced-*/bag")
    assert entries(kept) == before


@pytest.mark.parametrize("done", [False, True])
def test_an_interrupt_while_the_old_one_is_moved_leaves_it(done: bool, bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before, rename = entries(bag), Path.rename

    def interrupted(source: Path, target: Path) -> Path:
        monkeypatch.setattr(Path, "rename", rename)
        if done:
            rename(source, target)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt), replacing("-o", bag, force=True):
        pytest.fail("the work began")
    assert entries(bag) == before
    assert entries(tmp_path) == {"bag"}


def test_no_part_of_an_old_one_comes_back_once_it_is_being_removed(bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(folder: Path) -> None:
        next(folder.rglob("*.mcap")).unlink()
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("shutil.rmtree", interrupted)
        with pytest.raises(KeyboardInterrupt), replacing("-o", bag, force=True):
            recorded(bag, 1)
    bag.rename(tmp_path / "moved")
    with replacing("-o", bag, force=False):
        assert entries(tmp_path) == {"moved"}


def test_an_old_one_that_cannot_come_back_is_named(bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rename = Path.rename

    def refused(source: Path, target: Path) -> Path:
        if target == bag:
            raise PermissionError(13, "Permission denied")
        return rename(source, target)

    monkeypatch.setattr(Path, "rename", refused)
    with pytest.raises(RuntimeError, match=r"the old .*/bag is kept as .*/\.replaced-.*/bag: .*Permission denied") as failure:
        half_done(bag, RuntimeError)
    assert Path(str(failure.value).split(" is kept as ")[1].split(":")[0]).is_dir()


def test_the_old_one_of_a_killed_process_comes_back(bag: Path, tmp_path: Path) -> None:
    before = entries(bag)
    (tmp_path / ".replaced-0123456789abcdef").mkdir()
    bag.rename(tmp_path / ".replaced-0123456789abcdef" / "bag")
    with pytest.raises(Refusal, match="bag exists: give another name, or --force"), replacing("-o", bag, force=False):
        pytest.fail("the work began")
    assert entries(bag) == before
    assert entries(tmp_path) == {"bag"}


def test_the_old_one_of_a_killed_process_is_removed_once_it_is_replaced(bag: Path, tmp_path: Path) -> None:
    recorded(tmp_path / ".replaced-0123456789abcdef" / "bag", 1)
    recorded(tmp_path / ".replaced-fedcba9876543210" / "other", 1)
    with replacing("-o", bag, force=True):
        recorded(bag, 1)
    assert entries(tmp_path) == {"bag", ".replaced-fedcba9876543210"}
