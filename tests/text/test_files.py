"""Files from outside: pipes, devices and folders are refused at once."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.scenario import read_scenario_file
from dcrb_ros.sweep.loader import read_sweep
from dcrb_ros.text.files import check_regular, checked_path, open_regular, read_text, special_kind


@pytest.mark.parametrize(("path", "kind"), [("/dev/zero", "a device"), ("/dev/null", "a device"), ("/", "a folder")])
def test_what_is_not_a_regular_file_is_refused(path: str, kind: str) -> None:
    with pytest.raises(Refusal, match=f"{path} is {kind}: give a regular file"):
        read_text(Path(path))
    assert special_kind(Path(path)) == kind


def test_a_regular_file_and_nothing_are_not_special(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert [special_kind(tmp_path / name) for name in ("file", "none", "x" * 300)] == ["", "", ""]


def test_a_pipe_without_a_writer_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(Refusal, match="pipe is a named pipe: give a regular file"):
        open_regular(tmp_path / "pipe")


def test_a_socket_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # the path of a socket must be short
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind("socket")
        with pytest.raises(Refusal, match="socket cannot be read: "):
            check_regular(Path("socket"))


def test_the_limit_holds_for_the_bytes_that_are_read(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_text("12345")
    assert read_text(path, 5) == "12345"
    with pytest.raises(Refusal, match="text has 5 bytes; at most 4 are read"):
        read_text(path, 4)
    # A file of the kernel says that it is empty.
    with pytest.raises(Refusal, match="/proc/self/environ has 2 bytes; at most 1 are read"):
        read_text(Path("/proc/self/environ"), 1)


def test_a_text_is_utf_8_with_or_without_a_mark(tmp_path: Path) -> None:
    path = tmp_path / "text"
    for content in ("é", "\ufeffé"):
        path.write_text(content, encoding="utf-8")
        assert read_text(path) == "é"
    path.write_text("ab é", encoding="latin-1")
    with pytest.raises(Refusal, match="text is not a text file: byte 3 is not UTF-8; save it as UTF-8"):
        read_text(path)


@pytest.mark.parametrize(
    ("name", "words"), [("a\0b", r"a\\x00b is not a path \(embedded null"), ("x" * 256, "cannot be used: File name too long")]
)
def test_names_that_no_file_can_have_are_refused(name: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=words):
        checked_path(tmp_path / name)
    with pytest.raises(Refusal, match=words.replace("used", "(read|used)")):
        open_regular(tmp_path / name)
    assert checked_path(tmp_path / "new" / "folder") == tmp_path / "new" / "folder"


def test_a_path_in_a_folder_that_may_not_be_entered_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def lstat(path: Path) -> None:
        raise PermissionError(13, "Permission denied", path)

    monkeypatch.setattr("os.lstat", lstat)
    with pytest.raises(Refusal, match=r"a cannot be used: Permission denied; make its folder accessible, or give another path$"):
        checked_path(tmp_path / "a")


def test_a_pipe_in_place_of_a_named_file_is_refused_as_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    readers: tuple[Callable[[Any], Any], ...] = (load_configuration, read_exam, read_sweep, read_scenario_file)
    for read in readers:
        with pytest.raises(Refusal, match=r"pipe.yaml is a named pipe: give a regular file$"):
            read(pipe)
