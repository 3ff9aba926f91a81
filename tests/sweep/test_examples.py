"""The example that loads a data set."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from synthetic_bearing import ORDERS, synthetic

EXAMPLE = Path(__file__).parents[2] / "examples" / "load_dataset.py"


def loaded(name: str) -> Any:
    """Return the example as a new module."""
    description = importlib.util.spec_from_file_location(name, EXAMPLE)
    assert description is not None
    assert description.loader is not None
    module = importlib.util.module_from_spec(description)
    description.loader.exec_module(module)
    return module


def made(folder: Path, runs: int) -> Path:
    """Write a data set whose windows contain the number of their run and of their first sample."""
    (folder / "runs").mkdir(parents=True)
    for run in range(runs):
        samples = run + np.arange(4096 + 2 * 2048, dtype=np.float32) / 10_000
        np.savez(folder / "runs" / f"{run}.npz", ax=samples, ay=samples, shaft_angle=samples)
    table = {"split": "train", "status": "done", "file": [f"runs/{run}.npz" for run in range(runs)], "fault": "healthy"}
    pd.DataFrame(table).to_parquet(folder / "labels.parquet")
    return folder


@pytest.mark.parametrize("workers", [1, 2, 3, 9])
def test_the_workers_of_a_data_loader_share_the_windows(workers: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The two names of PyTorch that the example uses; the environment of the tests has no PyTorch.
    data, current = ModuleType("torch.utils.data"), list[Any]([None])
    data.IterableDataset = object  # type: ignore[attr-defined]
    data.get_worker_info = lambda: current[0]  # type: ignore[attr-defined]
    for name, module in {"torch": ModuleType("torch"), "torch.utils": ModuleType("torch.utils"), "torch.utils.data": data}.items():
        monkeypatch.setitem(sys.modules, name, module)
    windows = loaded("load_dataset_with_torch").Windows(made(tmp_path / "set", 7), "train")
    alone = [float(window[0, 0]) for window, _ in windows]
    assert len(alone) == len(set(alone)) == 7 * 3
    shared: list[float] = []
    for number in range(workers):
        current[0] = SimpleNamespace(id=number, num_workers=workers)
        shared += [float(window[0, 0]) for window, _ in windows]
    assert sorted(shared) == sorted(alone)


def test_the_example_works_without_torch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    example = loaded("load_dataset_without_torch")
    assert not hasattr(example, "Windows")
    assert len(list(example.windows(made(tmp_path / "set", 2), "train"))) == 6


def test_the_classifier_of_the_twins_tells_noise_from_a_defect(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sklearn")
    monkeypatch.syspath_prepend(str(EXAMPLE.parent))
    monkeypatch.setitem(globals(), "EXAMPLE", EXAMPLE.with_name("twin_classifier.py"))
    example = loaded("twin_classifier")
    folders = [tmp_path / "twins", tmp_path / "recordings"]
    for seed, folder in enumerate(folders):
        (folder / "runs").mkdir(parents=True)
        rows = []
        for run, (fault, force) in enumerate([("healthy", 0.0), ("outer_ring", 80.0)] * 2):
            acceleration, angle = synthetic(outer=force, seconds=2.0, rate=12800, seed=10 * seed + run)
            np.savez(folder / "runs" / f"{run}.npz", ax=acceleration[:, 0], ay=acceleration[:, 1], shaft_angle=np.mod(angle, 2.0 * np.pi))
            lines = {name: getattr(ORDERS, name) * 20.0 for name in ("ftf", "bpfo", "bpfi", "bsf")}
            about = {"status": "done", "fault": fault, "file": f"runs/{run}.npz", "sampling_rate": 12800, "speed": 40.0 * np.pi}
            rows.append(about | lines)
        pd.DataFrame(rows).to_parquet(folder / "labels.parquet")
    features, truth = example.windows(folders[0])
    assert len(features) == len(truth) == 12
    assert not any("rms" in name or "peak" in name or "level" in name for name in features)
    assert example.main(*folders) == 1.0
