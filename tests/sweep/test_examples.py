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
