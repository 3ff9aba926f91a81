"""A command whose file cannot be written ends with one sentence and a status, and leaves nothing under the name."""

from __future__ import annotations

from pathlib import Path

import pytest
from full_disk import files_of_at_most
from made_up_blocks import recorded
from same_process import dcrb

SIZE = 1000
"""Largest file that can be written [bytes]."""


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bags") / "bag", 150)


@pytest.mark.parametrize(
    ("command", "output"),
    [
        (("view", "BAG", "--save"), "a.rrd"),
        (("plot", "BAG", "-o"), "a.png"),
        (("plot", "BAG", "-o"), "a.svg"),
        (("plot", "BAG", "-o"), "a.pdf"),
        (("export", "BAG", "-o"), "a.npz"),
        (("recover", "BAG", "-o"), "recovered"),
        (("compare", "BAG", "BAG", "-o"), "a.png"),
        (("detect", "BAG", "--report"), "a.html"),
        (("score", "BAG", "--reference", "--figure"), "a.png"),
    ],
    ids=lambda value: value if isinstance(value, str) else value[0],
)
@pytest.mark.timeout(60)
@pytest.mark.parametrize("old", [False, True], ids=["new", "replaced"])
def test_nothing_is_left_of_a_file_that_cannot_be_written(
    command: tuple[str, ...], output: str, old: bool, bag: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / output
    if old:
        if output == "recovered":
            recorded(target, 1)
        else:
            target.write_text("old")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    arguments = [str(bag) if word == "BAG" else word for word in command]
    with files_of_at_most(SIZE):
        status = dcrb(*arguments, str(target), *(["--force"] if old else []))
    assert status in (1, 2)
    sentences = capfd.readouterr().err.splitlines()
    assert sum("File too large" in line or "could not" in line for line in sentences) == 1, sentences
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    assert not (list(tmp_path.iterdir()) if not old else [])
