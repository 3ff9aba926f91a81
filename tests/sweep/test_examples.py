"""The examples that load data sets."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from synthetic_bearing import ORDERS, synthetic
from waiting import PATIENCE

from dcrb_ros import DataSet, Refusal
from dcrb_ros.sweep.store import record_of

EXAMPLES = Path(__file__).parents[2] / "examples"


def row_of(folder: Path, run: str, acceleration: Any, angle: Any, fault: str) -> dict[str, Any]:
    """Write a run and return its row in the table of labels."""
    file = f"runs/{run}.npz"
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    np.savez(folder / file, ax=acceleration[:, 0], ay=acceleration[:, 1], shaft_angle=np.mod(angle, 2.0 * np.pi))
    about = {"run": run, "split": "train", "status": "done", "fault": fault, "file": file, "samples": len(angle), "sampling_rate": 12800}
    lines = {name: getattr(ORDERS, name) * 20.0 for name in ("ftf", "bpfo", "bpfi", "bsf")}
    return about | lines | {"files": json.dumps({file: record_of(folder / file)}), "speed": 40.0 * np.pi}


@pytest.mark.filterwarnings("ignore:.*has no SHA256SUMS")
def test_the_loader_counts_the_windows_of_every_class(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import load_dataset

    silence = np.zeros((3 * 4096, 2), np.float32)
    pd.DataFrame([row_of(tmp_path, fault, silence, silence[:, 0], fault) for fault in ("lubrication", "cage")]).to_parquet(
        tmp_path / "labels.parquet"
    )
    load_dataset.main(tmp_path)
    assert capsys.readouterr().out == "train: 10 windows; 5 cage, 5 lubrication\n"


@pytest.mark.filterwarnings("ignore:.*has no SHA256SUMS")
def test_the_classifier_of_the_twins_tells_noise_from_a_defect(tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    import twin_classifier

    folders = [tmp_path / "twins", tmp_path / "recordings"]
    for seed, folder in enumerate(folders):
        rows = []
        for run, (fault, force) in enumerate([("healthy", 0.0), ("outer_ring", 80.0)] * 2):
            acceleration, angle = synthetic(outer=force, seconds=2.0, rate=12800, seed=10 * seed + run)
            rows.append(row_of(folder, str(run), acceleration, angle, fault))
        pd.DataFrame(rows).to_parquet(folder / "labels.parquet")
    features, truth = twin_classifier.windows(folders[0])
    assert len(features) == len(truth) == 12
    assert not any("rms" in name or "peak" in name or "level" in name for name in features)
    assert twin_classifier.main(*folders) == 1.0


@pytest.mark.filterwarnings("ignore:.*has no SHA256SUMS")
@pytest.mark.parametrize(
    ("faults", "sentence"),
    [
        (("cage", "roller"), "twins has no runs with cage, roller, which .* has"),
        (("healthy",), "recordings has fewer than two classes: give"),
    ],
)
def test_the_classifier_of_the_twins_refuses_recordings_that_give_no_score(faults: tuple[str, ...], sentence: str, tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    import twin_classifier

    folders = [tmp_path / "twins", tmp_path / "recordings"]
    for folder, named in zip(folders, (("healthy", "outer_ring"), faults), strict=True):
        rows = [row_of(folder, fault, *synthetic(outer=0.0, seconds=1.0, rate=12800, seed=1), fault) for fault in named]
        pd.DataFrame(rows).to_parquet(folder / "labels.parquet")
    with pytest.raises(Refusal, match=sentence):
        twin_classifier.main(*folders)


@pytest.mark.filterwarnings("ignore:.*has no SHA256SUMS")
def test_the_features_of_the_baseline_do_not_depend_on_the_direction_of_rotation(tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    import baseline

    acceleration, angle = synthetic(outer=80.0, seconds=2.0, rate=12800, seed=1)
    rows = [row_of(tmp_path, name, acceleration, sign * angle, "outer_ring") for name, sign in (("forwards", 1.0), ("backwards", -1.0))]
    rows[1]["speed"] *= -1.0
    pd.DataFrame(rows).to_parquet(tmp_path / "labels.parquet")
    data_set = DataSet(tmp_path)
    forwards, backwards = (baseline.features(data_set, row) for _, row in data_set.labels().iterrows())
    assert backwards == pytest.approx(forwards, abs=0.02)


@pytest.mark.filterwarnings("ignore:.*has no SHA256SUMS")
def test_remaining_lives_need_a_data_set_of_lives(tmp_path: Path) -> None:
    import remaining_life

    silence = np.zeros((3 * 4096, 2), np.float32)
    pd.DataFrame([row_of(tmp_path, "0", silence, silence[:, 0], "cage")]).to_parquet(tmp_path / "labels.parquet")
    with pytest.raises(Refusal, match="has no operating hours: give a data set of lives"):
        remaining_life.main(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        (["baseline.py", "nowhere"], "nowhere has no labels.parquet"),
        (["load_dataset.py"], "the following arguments are required: folder"),
        (["remaining_life.py", "nowhere"], "nowhere has no labels.parquet"),
        (["twin_classifier.py", "nowhere", "nowhere"], "nowhere has no labels.parquet"),
        (["burn_off.py", "nowhere"], "there is no recording nowhere"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_an_example_refuses_what_is_missing_in_one_sentence(command: list[str], sentence: str, tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    found = subprocess.run(
        [sys.executable, str(EXAMPLES / command[0]), *command[1:]], cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE
    )
    assert found.returncode == 2
    assert sentence in found.stderr.splitlines()[-1]
    assert "Traceback" not in found.stderr
