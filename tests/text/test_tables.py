"""CSV tables from outside."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.tables import LARGEST_TABLE, read_rows

NEEDED, OPTIONAL = ("file", "fault"), ("load",)


def rows(path: Path, text: str) -> list[dict[str, str]]:
    path.write_bytes(text.encode())
    return [row for _, row in read_rows(path, NEEDED, OPTIONAL)]


def test_values_are_by_column_without_spaces_and_empty_lines(tmp_path: Path) -> None:
    found = rows(tmp_path / "a.csv", '\ufefffile, load ,fault\r\n\r\n" a, b ",5,x\r\n')
    assert found == [{"file": "a, b", "load": "5", "fault": "x"}]


def test_rows_have_the_numbers_of_their_first_lines(tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    table.write_text('\nfile,fault\n\na,x\n\n"b\nc",y\nd,z\n')
    assert [number for number, _ in read_rows(table, NEEDED)] == [4, 6, 8]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "lacks the columns file, fault"),
        ("file;fault\n1,5;x\n", "separates its columns by semicolons: save it with commas, and with points in its numbers"),
        ("file\tfault\n", "separates its columns by tabs: save it with commas"),
        ("file,falt\n", "lacks the columns fault: it needs file, fault; unknown is 'falt'; did you mean 'fault'"),
        ("file,fault,lod\n", "has the unknown column 'lod'; did you mean 'load'"),
        ("file,fault,fault\n", "has the column fault twice"),
        ("file,fault\na,b\na,b,c\n", "line 3: 3 fields, but 2 columns"),
        ("file,fault\n\na,b\n\n\na,b,c\n", "line 6: 3 fields, but 2 columns"),
        ("file,fault\na\n", "line 2: 1 fields, but 2 columns"),
        ('file,fault\n"a,b\n', "cannot be read as CSV: line 2: "),
        ("x" * (LARGEST_TABLE + 1), f"at most {LARGEST_TABLE}"),
    ],
)
def test_a_table_with_another_shape_is_refused(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=sentence):
        rows(tmp_path / "a.csv", text)


def test_a_pipe_and_a_folder_are_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(Refusal, match="is a named pipe"):
        read_rows(tmp_path / "pipe", NEEDED)
    with pytest.raises(Refusal, match="is a folder"):
        read_rows(tmp_path, NEEDED)
