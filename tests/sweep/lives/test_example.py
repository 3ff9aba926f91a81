"""The example that estimates remaining lives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.store import record_of

pytest.importorskip("matplotlib")

import remaining_life


def bearing(failure: float, seed: int, name: str) -> pd.DataFrame:
    """Return a bearing whose severity is 1, and grows hyperbolically to 20 in its last 2000 hours."""
    hours = np.append(np.arange(0.0, failure, 200.0), failure)
    left = np.clip(failure - hours, 0.0, 2000.0) / 2000.0
    level = 1.0 / (0.05 + 0.95 * left) * np.exp(0.01 * np.random.default_rng(seed).standard_normal(len(hours)))
    return pd.DataFrame({"bearing_id": name, "hours": hours, "severity": level, "remaining_life": failure - hours})


@pytest.fixture(scope="module")
def train() -> pd.DataFrame:
    """Return three training bearings: all take 2000 h from their first rise, whatever their age."""
    rows = pd.concat([bearing(failure, seed, str(seed)) for seed, failure in enumerate((3900.0, 4300.0, 5100.0))])
    return rows.assign(damage=np.where(rows["remaining_life"] < 2000.0, 0.001, 0.0), censored=False)


def test_no_estimate_uses_later_inspections(train: pd.DataFrame) -> None:
    whole = bearing(4300.0, 11, "a")
    changed = whole.assign(severity=whole["severity"].where(whole["hours"] < 3500.0, 1.0))
    before, after = (remaining_life.estimates(rows, train) for rows in (whole, changed))
    early = before["hours"] < 3500.0
    assert early.sum() >= 2
    assert before[early].equals(after[after["hours"] < 3500.0])


def test_an_early_estimate_does_not_use_the_inspection_after_it(train: pd.DataFrame) -> None:
    """Two high inspections at the start are a trend before there are five inspections, which tell what is normal."""
    whole = bearing(4300.0, 11, "a").assign(severity=lambda rows: [2.0, 2.0, 1.0, 1.0, *rows["severity"][4:]])
    changed = whole.assign(severity=whole["severity"].where(whole.index != 4, 3.0))
    before, after = (remaining_life.estimates(rows, train).iloc[0] for rows in (whole, changed))
    assert before["hours"] == whole["hours"][3]
    assert before.equals(after)


def test_the_constant_estimate_uses_no_life_of_a_censored_bearing(train: pd.DataFrame) -> None:
    censored = bearing(90000.0, 3, "censored").head(20).assign(damage=0.001, censored=True)
    tables = [remaining_life.estimates(bearing(4700.0, 12, "a"), lives) for lives in (train, pd.concat([train, censored]))]
    assert tables[0].equals(tables[1])


def test_both_methods_estimate_a_trend_of_their_form(train: pd.DataFrame) -> None:
    table = remaining_life.estimates(bearing(4700.0, 12, "a"), train)
    assert np.allclose(table["trend"], table["true"], atol=150.0)
    assert np.allclose(table["update"], table["true"], atol=150.0)


def test_a_trend_begins_at_the_first_of_two_high_inspections() -> None:
    assert remaining_life.begin(np.array([1.0, 1.0, 1.2, 1.0, 1.0, 1.0, 1.2, 1.3, 1.4])) == 6
    assert remaining_life.begin(np.ones(9)) == 9


def test_without_three_estimates_of_a_bearing_no_figure_is_drawn(
    train: pd.DataFrame, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = remaining_life.estimates(bearing(4700.0, 12, "a"), train).head(2)
    remaining_life.plot_estimates(table, str(tmp_path / "lives.png"))
    assert capsys.readouterr().out.endswith("lives.png is not drawn: no bearing has three estimates\n")
    assert not (tmp_path / "lives.png").exists()


def written_set(folder: Path) -> None:
    """Write a data set of five bearings; a refused inspection has no file."""
    (folder / "runs").mkdir(parents=True)
    tables = []
    for number, split in enumerate(("train", "train", "train", "test", "test")):
        rows = bearing(4000.0 + 300.0 * number, number, f"bearing{number}")
        rows["run"] = [f"{number}-{place}" for place in range(len(rows))]
        rows["file"], rows["files"] = [f"runs/{run}.npz" for run in rows["run"]], ""
        for place, (file, severity) in enumerate(zip(rows["file"], rows["severity"], strict=True)):
            vertical = severity * np.array([-1.0, 1.0])
            np.savez(folder / file, ax=np.zeros(2), ay=vertical, shaft_angle=np.zeros(2))
            rows.loc[place, "files"] = json.dumps({file: record_of(folder / file)})
        about = {"status": "done", "fault": "outer_ring", "sampling_rate": 25600, "samples": 2}
        tables.append(rows.assign(split=split, censored=False, damage=np.where(rows["remaining_life"] < 2000.0, 0.001, 0.0), **about))
    refused = tables[0].head(1).assign(run="refused", status="refused", file=None, files=None)
    pd.concat([refused, *tables]).drop(columns="severity").to_parquet(folder / "labels.parquet")


@pytest.mark.filterwarnings("ignore:.*has no SHA256SUMS")
def test_the_script_prints_the_scores_and_draws_its_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    written_set(tmp_path / "set")
    monkeypatch.chdir(tmp_path)
    remaining_life.main(tmp_path / "set")
    printed = capsys.readouterr().out
    assert "3 failures of training bearings" in printed
    assert "bearing3: " in printed
    assert "bearing4: " in printed
    assert "each life from all others: " in printed
    assert all((tmp_path / figure).stat().st_size > 10_000 for figure in ("severity.png", "remaining-life.png"))


@pytest.mark.filterwarnings("ignore:.*has no SHA256SUMS")
def test_a_changed_waveform_gives_no_estimate(tmp_path: Path) -> None:
    written_set(tmp_path / "set")
    waveform = tmp_path / "set" / "runs" / "3-5.npz"
    waveform.write_bytes(waveform.read_bytes()[:-1] + b"x")
    with pytest.raises(Refusal, match=r"3-5\.npz has been changed"):
        remaining_life.inspections(tmp_path / "set")
