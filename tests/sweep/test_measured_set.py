"""Measured recordings with missing samples in a data set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from full_disk import files_of_at_most

from dcrb_ros import DataSet, Refusal
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.sweep.measured_set import MeasuredRun, write_measured_set
from dcrb_ros.sweep.store import StoreFailed
from dcrb_ros.sweep.sweep_file import Windows

STEP = 0.1
"""Angle of the shaft between two samples [rad]."""


def recorded(*stretches: tuple[int, int]) -> Waveform:
    """Return noise at 1 kHz from one index to another in each stretch."""
    kept = np.concatenate([np.arange(*stretch) for stretch in stretches])
    samples = int(kept.max()) + 1
    whole = Waveform.from_arrays(np.random.default_rng(1).standard_normal(samples), 1000, shaft_angle=STEP * np.arange(samples))
    return replace(whole, acceleration=whole.acceleration[kept], shaft_angle=whole.shaft_angle[kept], index=kept)


def stored(waveform: Waveform, folder: Path) -> DataSet:
    run = MeasuredRun("run", waveform, "healthy")
    write_measured_set([run], folder, title="set", licence="CC0-1.0", windows=Windows(length=500, kind="parquet"))
    return DataSet(folder)


def test_missing_samples_are_missing_in_the_data_set(tmp_path: Path) -> None:
    waveform = recorded((0, 1400), (2521, 4000), (4100, 4101))
    data_set = stored(waveform, tmp_path / "set")
    read = data_set.waveform("run")
    assert np.array_equal(read.index, waveform.index)
    assert np.array_equal(read.acceleration, waveform.acceleration)
    assert float(data_set.labels()["speed"][0]) == pytest.approx(STEP * 1000.0, rel=1e-6)
    # Windows begin every 500 samples of the file; the third holds the first gap.
    windows = data_set.windows("test").arrays()[0]
    assert [int(np.flatnonzero(waveform.acceleration[:, 1] == window[1, 0])[0]) for window in windows] == [0, 500, 1500, 2000]
    with pytest.raises(Refusal, match=r"samples of the run run in .* are missing, which new windows would bridge: leave out length"):
        data_set.windows("test", length=400).arrays()


def test_an_address_on_this_machine_is_its_folder(tmp_path: Path) -> None:
    data_set = stored(recorded((0, 1000)), tmp_path / "my set")
    assert DataSet(f"file://{tmp_path}/my set").folder == data_set.folder
    with pytest.raises(Refusal, match=r"^memory://set is not on this machine: give a folder on it"):
        DataSet("memory://set")
    with pytest.raises(Refusal, match=r"^ftps://set cannot be used for a data set: "):
        DataSet("ftps://set")


def test_a_whole_recording_needs_no_index(tmp_path: Path) -> None:
    waveform = recorded((100, 2100))
    data_set = stored(waveform, tmp_path / "set")
    with np.load(tmp_path / "set" / "runs" / "run.npz") as content:
        assert sorted(content.files) == ["ax", "ay", "first_index", "sampling_rate", "shaft_angle"]
    assert np.array_equal(data_set.waveform("run").index, waveform.index)
    assert len(data_set.windows("test", length=400)) == 9


def test_of_three_axes_two_are_kept_and_hashed(tmp_path: Path) -> None:
    waveform = recorded((0, 1000))
    third = replace(waveform, acceleration=np.column_stack([waveform.acceleration, np.ones(1000, np.float32)]))
    two, three = stored(waveform, tmp_path / "two"), stored(third, tmp_path / "three")
    assert np.array_equal(two.windows("test").arrays()[0], three.windows("test").arrays()[0])
    assert two.labels()["sha256"][0] == three.labels()["sha256"][0]


def test_a_set_on_a_full_disk_leaves_nothing_that_could_be_continued(tmp_path: Path) -> None:
    with files_of_at_most(1000), pytest.raises(StoreFailed, match=r"free some space and run the same command again$"):
        stored(recorded((0, 1000)), tmp_path / "set")
    assert not (tmp_path / "set").exists()


def test_a_recording_that_is_shorter_than_a_window_has_none(tmp_path: Path) -> None:
    runs = [MeasuredRun(name, recorded((0, samples)), "healthy") for name, samples in (("short", 499), ("long", 1000))]
    write_measured_set(runs, tmp_path, title="set", licence="CC0-1.0", windows=Windows(length=500, kind="parquet"))
    assert DataSet(tmp_path).windows("test").arrays()[0].shape == (2, 2, 500)


@pytest.mark.parametrize("stretches", [((0, 1), (5, 6)), ((0, 1),)])
def test_single_samples_have_no_speed(stretches: tuple[tuple[int, int], ...], tmp_path: Path) -> None:
    assert stored(recorded(*stretches), tmp_path / "set").labels()["speed"].isna().all()


@pytest.mark.parametrize("wrong", [None, 3, [], ["test"], {}, np.array([1, 2])])
def test_names_and_lengths_of_wrong_types_are_refused(wrong: Any, tmp_path: Path) -> None:
    data_set = stored(recorded((0, 2000)), tmp_path / "set")
    with pytest.raises(Refusal, match="has no run"):
        data_set.waveform(wrong)
    with pytest.raises(Refusal, match="has no split"):
        data_set.windows(wrong)
    if not isinstance(wrong, int | None):
        with pytest.raises(Refusal, match=r"length = .* is not a number of samples"):
            data_set.windows("test", wrong)
        with pytest.raises(Refusal, match="has no split"):
            data_set.labels(wrong)
