"""A folder with a file of another recording is refused; its samples would be taken as those of the bench in the manifest."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from made_up_blocks import recorded
from mcap.writer import Writer
from same_process import dcrb

from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bags") / "bag", 150, split_duration=1.0)


def with_file(bag: Path, folder: Path, name: str, *, manifest: bool = True) -> Path:
    """Return a copy of a recording with a file of another one, which has a manifest or none."""
    shutil.copytree(bag, folder)
    if manifest:
        (file,) = recorded(folder.parent / "other", 3, compression="zstd").glob("*.mcap")
        shutil.copy(file, folder / name)
    else:
        writer = Writer(str(folder / name))
        writer.start()
        writer.finish()
    return folder


@pytest.mark.parametrize("name", ["a.mcap", "zz.mcap"])
@pytest.mark.parametrize("manifest", [True, False])
def test_a_file_of_another_recording_is_refused(bag: Path, name: str, manifest: bool, tmp_path: Path) -> None:
    assert len(Recording(bag).files) > 2
    mixed = with_file(bag, tmp_path / "mixed", name, manifest=manifest)
    with pytest.raises(Refusal, match=r"files of more than one recording.*move the files of the other recording out of the folder"):
        Recording(mixed)


@pytest.mark.parametrize(
    "command",
    [
        ("info", "BAG"),
        ("detect", "BAG"),
        ("view", "BAG", "--save", "NEW.rrd"),
        ("plot", "BAG", "-o", "NEW.png"),
        ("export", "BAG", "-o", "NEW.npz"),
        ("recover", "BAG", "-o", "NEW"),
        ("compare", "BAG", "BAG"),
        ("score", "BAG"),
        ("score", "BAG", "--reference"),
        ("replay", "BAG"),
        ("simulate", "--from", "BAG"),
        ("calibrate", "BAG", "-o", "NEW.yaml"),
    ],
    ids=lambda command: "-".join(word.strip("-") for word in command[:3] if word not in ("BAG", "-o")),
)
def test_every_command_refuses_such_a_folder(
    command: tuple[str, ...], bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mixed = with_file(bag, tmp_path / "mixed", "zz.mcap")
    words = {"BAG": str(mixed), "NEW": str(tmp_path / "new")}
    arguments = [words.get(word.split(".")[0], "") + word[3:] if word.split(".")[0] in words else word for word in command]
    assert dcrb(*arguments) == 2
    assert capsys.readouterr().err.count("files of more than one recording") == 1
    assert not list(tmp_path.glob("new*"))


def test_a_file_that_is_cut_off_before_its_manifest_counts_as_damaged(bag: Path, tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    shutil.copytree(bag, folder)
    last = sorted(folder.glob("*.mcap"))[-1]
    last.write_bytes(last.read_bytes()[:30])
    recording = Recording(folder)
    assert [sentence for sentence in recording.damage if last.name in sentence]
