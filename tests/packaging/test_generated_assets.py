"""Pictures and leaderboard of the documentation: each has a command, and each is as new as what it shows."""

from __future__ import annotations

import re
from pathlib import Path

import picture_stamps
import pictures
import pytest

from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.leaderboard import markdown, read_boards
from dcrb_ros.exam.leaderboard_entry import read_entry, write_entry

ROOT = Path(__file__).parents[2]
IMAGES, LEADERBOARD = ROOT / "docs/images", ROOT / "docs/leaderboard"


STAMPS = picture_stamps.stamps()


def test_every_picture_has_a_command_and_a_stamp_and_is_shown() -> None:
    files = {file.name for file in IMAGES.glob("*.png")}
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    shown = {name for page in pages for name in re.findall(r"images/([\w-]+\.png)", page.read_text(encoding="utf-8"))}
    assert files == set(STAMPS) == {f"{name}.png" for name in pictures.PICTURES} == shown


@pytest.mark.parametrize("file", sorted(STAMPS))
def test_no_picture_is_older_than_what_it_shows(file: str) -> None:
    stamp = STAMPS[file]
    assert set(stamp["shows"]) == set(pictures.PICTURES[file.removesuffix(".png")].shows)
    changes = picture_stamps.changed(stamp)
    message = f"docs/images/{file} is older than {', '.join(changes)}: {stamp['command']}"
    if stamp.get("outdated"):
        assert changes, f"docs/images/{file} is up to date: remove 'outdated' from its stamp"
        pytest.xfail(message)
    assert not changes, message


def test_a_picture_is_older_than_another_bench_or_drawing_but_not_than_another_docstring(tmp_path: Path) -> None:
    made = {"shows": picture_stamps.digests(["bench outer_ring_defect", "samples oiled_outer_ring_defect"])}
    assert picture_stamps.changed(made) == []
    made["shows"]["samples oiled_outer_ring_defect"] = "another"
    assert picture_stamps.changed(made) == ["samples oiled_outer_ring_defect"]
    assert picture_stamps.bench("outer_ring_defect") != picture_stamps.bench("outer_ring_defect operating.speed=40")
    source = tmp_path / "drawing.py"
    digests = []
    for name, docstring, colour in (("x", "Draw.", "red"), ("y", "Draw it.", "red"), ("x", "Draw.", "blue")):
        source.write_text(f'def draw({name}):\n    """{docstring}"""\n    return {name}, "{colour}"\n', encoding="utf-8")
        digests.append(picture_stamps.drawing(f"{source}:draw"))
    assert digests[0] == digests[1] != digests[2]


def test_a_picture_that_was_not_made_is_not_stamped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stamped = list[str]()
    monkeypatch.setattr(pictures, "IMAGES", tmp_path)
    monkeypatch.setattr(pictures, "write_stamp", stamped.append)
    commands = {"none": "true", "new": "touch {file}", "in_place": f"touch {tmp_path}/in_place.png"}
    monkeypatch.setattr(pictures, "PICTURES", {name: pictures.Picture(command, ()) for name, command in commands.items()})
    for _ in range(2):
        pictures.make("new")
        pictures.make("in_place")
        with pytest.raises(SystemExit, match="none was not made: its command wrote no picture"):
            pictures.make("none")
        (tmp_path / "none.png").touch()  # an old picture
    assert stamped == ["new", "in_place"] * 2


def test_entries_of_the_leaderboard_are_as_the_command_writes_them(tmp_path: Path) -> None:
    files = sorted(LEADERBOARD.rglob("*.json"))
    sources = [file.read_text(encoding="utf-8") for file in (ROOT / "examples/detectors").glob("*.py")]
    families = [source for source in sources if re.search(r"^VARIANTS =", source, re.MULTILINE)]
    assert len(files) == 2 * (len(families) + 1)  # and the shipped detector, each in the exam and on measured recordings
    for file in files:
        write_entry(read_entry(file), tmp_path / "entry.json")
        assert (tmp_path / "entry.json").read_bytes() == file.read_bytes()


def test_the_how_to_page_states_the_size_of_the_exam() -> None:
    exam = read_exam(str(ROOT / "examples/detectors/exam.yaml"))
    page = (ROOT / "docs/how-to/submit-to-the-leaderboard.md").read_text(encoding="utf-8")
    (stated,) = re.findall(r"The first evaluation simulates\s+(\d+)\s+recordings", page)
    assert int(stated) == len(exam.cases)


def test_the_leaderboard_follows_from_its_entries() -> None:
    boards = read_boards(LEADERBOARD, LEADERBOARD / "measured")
    assert markdown(boards, ["leaderboard-1.png"]) == (LEADERBOARD / "leaderboard.md").read_text(encoding="utf-8")
