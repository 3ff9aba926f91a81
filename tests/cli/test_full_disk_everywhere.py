"""Every command that writes ends with a status and one sentence if the disk is full, and leaves no file or data set that looks whole."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from full_disk import files_of_at_most
from made_up_blocks import narrowed
from same_process import dcrb

from dcrb_ros import DataSet, Refusal

ROOT = Path(__file__).parents[2]
ORDERS = {"FTF": 0.39828, "BPFO": 3.5848, "BPFI": 5.4152, "BSF": 2.35695}
BEARING = ("-F", "59.5", "-E", "81.5", "-Z", "16", "--roller-diameter", "11", "--roller-length", "16", "--rpm", "1500")
SWEEP = {"base": "dry", "duration": 0.02, "vary": {"operating.speed": [100.0, 120.0]}, "windows": {"length": 256}}
DRAWN = {"set": {"operating.speed": {"low": 60.0, "high": 190.0}}, "fault": {"faults.outer_1.width": {"low": 0.0004, "high": 0.003}}}
SCENARIOS = [{"name": "outer", "verdict": "outer_ring", "count": 4, "draw": DRAWN}, {"name": "well", "verdict": "healthy"}]
TEMPLATE = {"exam": "autumn", "duration": 9.0, "onset": 4.0, "scenarios": SCENARIOS}
HEAD = "name,rig,truth,sampling_rate,unit,speed_rpm_documented,speed_rpm_from_lines,FTF,BPFO,BPFI,BSF,seconds,load,pitch_diameter_mm"
ROW = "a,bench12,outer_ring,12000,g,1800,1800,0.39828,3.5848,5.4152,2.35695,10,1500,39"
# The output of a command, captured in a file, is limited as well: no size is below that of a sentence.
COMMANDS = (
    (("config", "new", *BEARING, "-o", "new.yaml"), 500),
    (("exam", "replica", "recordings.csv", "--without", "background", "-o", "new.yaml"), 500),
    (("exam", "seal", "template.yaml", "--secret", "new.secret", "-o", "new.yaml"), 300),
    (("collect", "list.csv", "--about", "about.yaml", "-o", "new"), 1000),
    (("collect", "list.csv", "--about", "about.yaml", "-o", "new"), 20000),
    (("sweep", "sweep.yaml", "--workers", "1", "-o", "new"), 3000),
    (("simulate", "dry", "--duration", "0.1", "-o", "new"), 3000),
    (("import", "wave.npz", "--about", "about.yaml", "-o", "new"), 3000),
    (("detect", "bag", "--healthy", "bag", "--save-baseline", "new.yaml"), 300),
    (("exam", "open", "sealed.yaml", "secret", "-o", "new.yaml"), 500),
    (("score", "bag", "--reference", "--entry", "new.json"), 500),
    (("score", "bag", "--reference", "--junit", "new.xml"), 700),
    (("shards", "set", "-o", "new"), 1000),
    (("shards", "set", "--runs", "1", "-o", "new"), 25000),
    (("shards", "shards/index.json", "--remake", "train-000000.tar", "-o", "new.tar"), 5000),
    (("calibrate", "healthy", "--trust", "--quiet", "-o", "new.yaml"), 20000),
)
SLOW = ("sweep", "shards", "calibrate")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with an input for every command."""
    folder = tmp_path_factory.mktemp("inputs")
    narrowed(folder / "bag", 150, at=1000, limit=5000.0)
    np.savez(folder / "wave.npz", de=np.random.default_rng(1).normal(size=12000))
    about = {"channels": {"ax": "de"}, "unit": "g", "speed_rpm": 1797, "sampling_rate": 12000, "orders": ORDERS}
    for name, content in (("about", about), ("sweep", SWEEP), ("template", TEMPLATE)):
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    (folder / "list.csv").write_text("file,fault\nwave.npz,healthy\n", encoding="utf-8")
    (folder / "recordings.csv").write_text(f"{HEAD}\n{ROW}\n", encoding="utf-8")
    (folder / "healthy").symlink_to(ROOT / "bags" / "healthy")
    commands = (
        ("exam", "seal", "template.yaml", "--secret", "secret", "-o", "sealed.yaml"),
        ("sweep", "sweep.yaml", "--workers", "1", "-o", "set"),
        ("shards", "set", "-o", "shards"),
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for command in commands:
            assert dcrb(*command) == 0
    return folder


@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    ("command", "size"),
    [pytest.param(*case, marks=pytest.mark.slow if case[0][0] in SLOW else ()) for case in COMMANDS],
    ids=lambda value: " ".join(value[:2]) if isinstance(value, tuple) else str(value),
)
def test_nothing_that_looks_whole_is_left(
    command: tuple[str, ...], size: int, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in os.listdir(folder):
        (tmp_path / name).symlink_to(folder / name)
    monkeypatch.chdir(tmp_path)
    with files_of_at_most(size):
        status = dcrb(*command)
    said = capfd.readouterr().err
    assert status in (1, 2), said
    assert sum("File too large" in line or "could not" in line for line in said.splitlines()) == 1, said
    assert "Traceback" not in said
    left = [path for path in tmp_path.glob("new*") if path.is_file() or any(path.iterdir())]
    for path in left:
        assert command[0] == "sweep", f"{path} is left"  # which continues where it stopped
        with pytest.raises(Refusal):
            DataSet(path)
