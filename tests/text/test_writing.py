"""A file is written whole or not at all."""

from __future__ import annotations

import itertools
import os
import stat
from pathlib import Path

import pytest
from full_disk import files_of_at_most

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.writing import whole_file, whole_files, whole_folder, write_whole


def test_a_file_is_replaced_and_nothing_else_is_left(tmp_path: Path) -> None:
    file = tmp_path / "about.json"
    file.write_text("old")
    write_whole(file, "new")
    assert file.read_text() == "new"
    assert list(tmp_path.iterdir()) == [file]


def test_a_write_that_fails_leaves_the_old_file_and_names_it(tmp_path: Path) -> None:
    file = tmp_path / "about.json"
    file.write_text("old")
    with files_of_at_most(100), pytest.raises(Refusal, match=r"about\.json cannot be written: File too large; free some space"):
        write_whole(file, b"x" * 1000)
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_a_place_that_cannot_be_written_is_not_called_full(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(Refusal, match=r"about\.json cannot be written: Not a directory; remove the file in its path or give another file"):
        write_whole(tmp_path / "file" / "about.json", "new")


def test_an_error_in_the_context_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> None:
        with whole_file(tmp_path / "picture.png") as temporary:
            assert temporary.suffix == ".png"
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert not list(tmp_path.iterdir())


@pytest.fixture
def interrupted_replace(monkeypatch: pytest.MonkeyPatch) -> None:
    """Raise an interrupt before the first file is replaced, and another one after it."""
    replace, calls = Path.replace, itertools.count()

    def interrupted(source: Path, target: Path) -> Path:
        call = next(calls)
        if call > 0:
            replace(source, target)
        if call < 2:
            raise KeyboardInterrupt
        return target

    monkeypatch.setattr(Path, "replace", interrupted)


@pytest.mark.usefixtures("interrupted_replace")
def test_files_that_belong_together_are_all_replaced_before_an_interrupt(tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("sealed.yaml", "secret", "third")]
    for file in files:
        file.write_text("old")

    def write() -> None:
        with whole_files(*files) as written:
            for part in written:
                part.write_text("new")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == dict.fromkeys(("sealed.yaml", "secret", "third"), "new")


@pytest.mark.usefixtures("interrupted_replace")
def test_a_folder_is_replaced_as_a_whole_before_an_interrupt(tmp_path: Path) -> None:
    (tmp_path / "report.md").write_text("old")

    def write() -> None:
        with whole_folder(tmp_path, "report.md") as written:
            for name in ("report.md", "a.png", "b.png"):
                (written / name).write_text("new")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == dict.fromkeys(("report.md", "a.png", "b.png"), "new")


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="No such file or directory; create its folder or give another file"):
        write_whole(tmp_path / "nowhere" / "file", "text")


def test_a_full_device_is_refused_and_stays_a_device() -> None:
    with pytest.raises(Refusal, match="/dev/full cannot be written: No space left on device"):
        write_whole(Path("/dev/full"), "text")
    assert stat.S_ISCHR(os.stat("/dev/full").st_mode)


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "new"


def test_permissions_follow_the_mask_of_the_user(tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        write_whole(tmp_path / "file", "text")
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o640


def test_a_replaced_file_keeps_its_permissions(tmp_path: Path) -> None:
    path = tmp_path / "private.json"
    write_whole(path, "a")
    path.chmod(0o600)
    write_whole(path, "b")
    assert (path.read_text(encoding="utf-8"), stat.S_IMODE(path.stat().st_mode)) == ("b", 0o600)
