"""A kept file that is not as it was written is not used, and what is in its place does not stop a program."""

from __future__ import annotations

from pathlib import Path

import pytest
from attacked_files import ATTACKS

from dcrb_ros.core.signed_file import DamagedFile, read_signed, signed


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.timeout(20)  # a pipe would be waited for
def test_a_file_that_is_not_as_it_was_written_is_refused_and_can_be_written_again(attack: str, tmp_path: Path) -> None:
    file = tmp_path / "kept" / "file"
    file.parent.mkdir()
    whole = signed(file, b"content of this file")
    file.write_bytes(whole)
    assert read_signed(file) == b"content of this file"
    ATTACKS[attack](file)
    with pytest.raises(DamagedFile):
        read_signed(file)
    new = tmp_path / "new"
    new.write_bytes(whole)
    new.replace(file)
    assert read_signed(file) == b"content of this file"


def test_a_link_to_a_sound_file_of_the_same_name_is_read(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "file").write_bytes(signed("file", b"content"))
    (tmp_path / "file").symlink_to(tmp_path / "store" / "file")
    assert read_signed(tmp_path / "file") == b"content"


def test_what_a_link_leads_to_stays(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "mine").write_text("mine")
    (tmp_path / "file").symlink_to(tmp_path / "folder")
    (tmp_path / "other").symlink_to(tmp_path / "folder" / "mine")
    for link in (tmp_path / "file", tmp_path / "other"):
        with pytest.raises(DamagedFile):
            read_signed(link)
        assert not link.is_symlink()
    assert (tmp_path / "folder" / "mine").read_text() == "mine"


def test_a_missing_file_is_not_damaged(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        read_signed(tmp_path / "file")


def test_the_name_belongs_to_the_content(tmp_path: Path) -> None:
    (tmp_path / "other").write_bytes(signed(tmp_path / "file", b"content"))
    with pytest.raises(DamagedFile, match="is damaged, or was written under another name"):
        read_signed(tmp_path / "other")
