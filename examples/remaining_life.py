"""Estimate the remaining life of bearings of a data set of lives: python examples/remaining_life.py DIR."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Literal

import matplotlib as mpl
import numpy as np
import pandas as pd

import dcrb_ros

mpl.use("Agg")
import matplotlib.pyplot as plt

HEALTHY = 5
"""First inspections of a bearing, which tell what is normal for it."""
RISE = 1.15
"""Severity over its healthy median from which a trend begins, at two inspections in a row."""
GROWTH: Literal["hyperbolic"] = "hyperbolic"
"""Form of the trend: 1/severity falls more evenly than its logarithm rises."""
WINDOW = 8
"""Inspections to which a trend is fitted at most."""
FEWEST = 4
"""Inspections since the begin of a trend before which nothing is estimated."""


def inspections(folder: Path) -> pd.DataFrame:
    """Return the labels with the severity of each inspection: the root mean square of the vertical acceleration [m/s^2]."""
    data_set = dcrb_ros.DataSet(folder)
    table = data_set.labels()
    if "hours" not in table:
        raise dcrb_ros.Refusal(f"{folder} has no operating hours: give a data set of lives, such as that of dcrb sweep twenty_lives")
    table["severity"] = [float(np.std(data_set.waveform(run).acceleration[:, 1])) for run in table["run"]]
    return table


def begin(severity: np.ndarray) -> int:
    """Return the index of the inspection at which the trend begins; the number of inspections if it has not begun."""
    above = severity > RISE * np.median(severity[:HEALTHY])
    twice = above[:-1] & above[1:]
    return int(np.argmax(twice)) if twice.any() else len(severity)


def limit(train: pd.DataFrame) -> tuple[float, float]:
    """Return the median severity at failure [m/s^2], and the standard deviation of its reciprocal [s^2/m]."""
    at_failure = train.loc[train["remaining_life"] == 0.0, "severity"]
    return float(at_failure.median()), float((1.0 / at_failure).std())


def histories(train: pd.DataFrame) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return hours [h] and severity over its healthy median [-] of each training bearing that failed, from the begin of its trend on."""
    failed = []
    for _, rows in train.groupby("bearing_id"):
        hours, severity = rows["hours"].to_numpy(), rows["severity"].to_numpy()
        first = begin(severity)
        if rows["remaining_life"].iloc[-1] == 0.0 and first < len(hours) - 1:
            failed.append((hours[first:], severity[first:] / np.median(severity[:HEALTHY])))
    return failed


def estimates(bearing: pd.DataFrame, train: pd.DataFrame) -> pd.DataFrame:
    """Return estimates for every inspection of a bearing at which a trend is known; nothing later than it is used."""
    hours, severity = bearing["hours"].to_numpy(), bearing["severity"].to_numpy()
    failed, (at_failure, deviation) = histories(train), limit(train)
    constant = float(train.loc[(train["damage"] > 0.0) & ~train["censored"], "remaining_life"].median())
    rows = []
    for now, true in enumerate(bearing["remaining_life"]):
        first = begin(severity[: now + 1])
        if now + 1 - first >= FEWEST and true > 0.0:
            seen, last = slice(first, now + 1), slice(max(first, now + 1 - WINDOW), now + 1)
            update = dcrb_ros.update_remaining_life(hours[seen], severity[seen] / np.median(severity[: min(HEALTHY, now + 1)]), failed)
            trend = dcrb_ros.estimate_remaining_life(hours[last], severity[last], at_failure, growth=GROWTH, limit_deviation=deviation)
            rows.append((hours[now], true, update.median, update.low, update.high, trend.median, trend.low, trend.high, constant))
    columns = ["hours", "true", "update", "update_low", "update_high", "trend", "trend_low", "trend_high", "constant"]
    return pd.DataFrame(rows, columns=columns, dtype=np.float64).assign(bearing=bearing["bearing_id"].iloc[0])


def scores(table: pd.DataFrame) -> str:
    """Return the score of each method and how often its intervals contain the truth."""
    parts = []
    for method in ("update", "trend"):
        inside = (table[f"{method}_low"] <= table["true"]) & (table["true"] <= table[f"{method}_high"])
        parts.append(f"{method} {dcrb_ros.phm_2012_score(table['true'], table[method]):.2f} ({100 * inside.mean():.0f} % inside)")
    return f"{len(table)} estimates, {', '.join(parts)}, constant {dcrb_ros.phm_2012_score(table['true'], table['constant']):.2f}"


def plot_severity(table: pd.DataFrame, at_failure: float, file: str) -> None:
    """Plot the severity of the training bearings over their hours, with the limit."""
    figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
    for _, rows in table.groupby("bearing_id"):
        axes.semilogy(rows["hours"], rows["severity"], color="tab:gray" if rows["censored"].iloc[0] else "tab:blue", lw=1.0)
    axes.axhline(at_failure, color="tab:red", ls="--", label="limit: median severity at failure")
    axes.plot([], [], color="tab:blue", label="failed")
    axes.plot([], [], color="tab:gray", label="censored by the overhaul")
    axes.set(xlabel="operating hours [h]", ylabel="vertical acceleration, rms [m/s²]", title="Training bearings")
    axes.set_yticks([1, 2, 5, 10, 20, 50], labels=["1", "2", "5", "10", "20", "50"])
    axes.minorticks_off()
    axes.legend()
    figure.savefig(file, dpi=100)


def plot_estimates(table: pd.DataFrame, file: str) -> None:
    """Plot true and estimated remaining life of each bearing with three estimates or more."""
    names = [name for name, rows in table.groupby("bearing") if len(rows) >= 3]
    if not names:
        print(f"{file} is not drawn: no bearing has three estimates")
        return
    figure, axes = plt.subplots(1, len(names), figsize=(4.0 * len(names), 3.8), layout="constrained", squeeze=False, sharey=True)
    top = 1.6 * float(table["true"].max())
    for panel, name in zip(axes[0], names, strict=True):
        rows = table[table["bearing"] == name]
        low, high, update = (rows[column].clip(upper=top) for column in ("update_low", "update_high", "update"))
        panel.plot(rows["hours"], rows["true"], color="black", label="true")
        panel.fill_between(rows["hours"], low, high, color="tab:blue", alpha=0.25, label="90 % interval")
        panel.plot(rows["hours"], update, "o-", color="tab:blue", ms=4.0, label="update")
        panel.plot(rows["hours"], rows["trend"].clip(upper=top), color="tab:orange", lw=1.0, label="trend")
        panel.set(title=name, xlabel="operating hours [h]", ylim=(0.0, top))
    axes[0][0].set_ylabel("remaining life [h]")
    axes[0][0].legend()
    figure.savefig(file, dpi=100)


def main(folder: Path) -> None:
    """Estimate the lives of the validation and test bearings from the training bearings, then each life from all others."""
    table = inspections(folder)
    train, others = table[table["split"] == "train"], table[table["split"] != "train"]
    if others.empty:
        raise dcrb_ros.Refusal(f"{folder} has no validation and test bearings to estimate: give a data set with several splits")
    print(f"{len(histories(train))} failures of training bearings, median severity {limit(train)[0]:.1f} m/s^2")
    estimated = pd.concat([estimates(rows, train) for _, rows in others.groupby("bearing_id")], ignore_index=True)
    if estimated.empty:
        raise dcrb_ros.Refusal(f"no bearing to estimate has {FEWEST} inspections in a trend: give more lives, or inspect them more often")
    for name, rows in estimated.groupby("bearing"):
        print(f"{name}: {scores(rows)}")
    print(f"all: {scores(estimated)}")
    each = [estimates(rows, table[table["bearing_id"] != name]) for name, rows in table.groupby("bearing_id")]
    print(f"each life from all others: {scores(pd.concat(each, ignore_index=True))}")
    plot_severity(train, limit(train)[0], "severity.png")
    plot_estimates(estimated, "remaining-life.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder with a data set of lives of dcrb sweep")
    try:
        main(parser.parse_args().folder)
    except dcrb_ros.Refusal as refusal:
        parser.error(str(refusal))
