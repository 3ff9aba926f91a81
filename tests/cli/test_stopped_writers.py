"""A command that is stopped while it writes leaves nothing half-written, and the next one repeats it and removes what was left."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest
import yaml
from folder_contents import contents
from made_up_blocks import recorded
from same_process import dcrb
from separate_process import stopped_dcrb

pytestmark = pytest.mark.slow

ABOUT = {"channels": {"ax": "de"}, "unit": "g", "speed_rpm": 1797, "sampling_rate": 12000}
ORDERS = {"FTF": 0.39828, "BPFO": 3.5848, "BPFI": 5.4152, "BSF": 2.35695}
BEARING = ("-F", "59.5", "-E", "81.5", "-Z", "16", "--roller-diameter", "11", "--roller-length", "16", "--rpm", "1500")
# The command, the wait for the disk during which it is stopped, and what it writes.
COMMANDS = (
    (("plot", "bag", "-o", "a.png"), 1, ["a.png"]),
    (("plot", "bag", "-o", "old.png", "--force"), 1, ["old.png"]),
    (("export", "bag", "-o", "a.csv"), 2, ["a.csv", "a.csv.yaml"]),
    (("view", "bag", "--save", "a.rrd"), 1, ["a.rrd"]),
    (("score", "bag", "--reference", "--entry", "entries/a.json"), 1, ["entries/a.json"]),
    (("config", "new", *BEARING, "-o", "a.yaml"), 1, ["a.yaml"]),
    (("recover", "bag", "-o", "old", "--force"), 1, ["old/metadata.yaml", "old/old_0.mcap"]),
    (
        ("collect", "list.csv", "--about", "about.yaml", "-o", "set"),
        3,
        [
            *("set/README.md", "set/SHA256SUMS", "set/dataset.yaml", "set/labels.parquet"),
            *(f"set/{name}" for run in ("a", "b") for name in (f"runs/{run}.npz", f"windows/test/{run}.parquet")),
        ],
    ),
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, with an input for every command."""
    monkeypatch.chdir(tmp_path)
    recorded(tmp_path / "bag", 150)
    recorded(tmp_path / "old", 1)
    (tmp_path / "old.png").write_text("old")
    (tmp_path / "entries").mkdir()
    for seed, name in enumerate("ab"):
        np.savez(tmp_path / f"{name}.npz", de=np.random.default_rng(seed).normal(size=12000))
    (tmp_path / "list.csv").write_text("file,fault\na.npz,healthy\nb.npz,outer_ring\n", encoding="utf-8")
    (tmp_path / "about.yaml").write_text(yaml.safe_dump({**ABOUT, "orders": ORDERS}), encoding="utf-8")
    return tmp_path


@pytest.mark.timeout(400)
@pytest.mark.parametrize(
    ("command", "at", "written"),
    [pytest.param(*case, id=" ".join(case[0][:3])) for case in COMMANDS],
)
def test_a_stopped_command_can_be_repeated(command: tuple[str, ...], at: int, written: list[str], folder: Path) -> None:
    before = contents(folder)
    terminated = stopped_dcrb("SIGTERM", at, *command)
    assert (terminated.returncode, terminated.stderr.splitlines()[-1]) == (130, "dcrb: stopped")
    assert contents(folder) == before
    assert stopped_dcrb("SIGKILL", at, *command).returncode == -signal.SIGKILL
    kept = {name: digest for name, digest in contents(folder).items() if not name.startswith("old/")}
    assert kept.items() >= {name: digest for name, digest in before.items() if not name.startswith("old/")}.items()
    assert not set(written) & set(kept) - set(before)
    assert dcrb(*command) == (1 if command[0] == "score" else 0)  # noise gives a false alarm
    assert set(contents(folder)) == set(before) | set(written)
    assert not [path for path in folder.rglob(".*") if path.is_dir()]


def test_what_a_killed_command_left_is_not_an_entry(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stopped_dcrb("SIGKILL", 1, "score", "bag", "--reference", "--entry", "entries/a.json")
    assert dcrb("exam", "table", "entries") == 2
    assert "entries has no .json file" in capsys.readouterr().err


@pytest.mark.parametrize("at", [1, 3, 4])
def test_an_import_that_is_stopped_at_its_start_or_end_leaves_nothing(at: int, folder: Path) -> None:
    before = set(folder.iterdir())
    stopped = stopped_dcrb("SIGTERM", at, "import", "a.npz", "--about", "about.yaml", "-o", "imported")
    assert (stopped.returncode, stopped.stderr.splitlines()[-1]) == (130, "dcrb: stopped")
    assert set(folder.iterdir()) == before
