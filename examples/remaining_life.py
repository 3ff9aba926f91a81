"""Estimate the remaining life of bearings of a data set of lives: python examples/remaining_life.py DIR."""

from __future__ import annotations

import sys
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
SHARES = np.linspace(0.0, 1.0, 21)
"""Shares of the time from the begin of a trend to failure at which training bearings are compared."""
LEAST_DEVIATION = 0.1
"""Deviation of the logarithm of a severity beside that between training bearings."""


def inspections(folder: Path) -> pd.DataFrame:
    """Return the labels with the severity of each inspection: the root mean square of the vertical acceleration [m/s^2]."""
    table = pd.read_parquet(folder / "labels.parquet")
    table["severity"] = [float(np.std(np.load(folder / file)["ay"])) for file in table["file"]]
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


def estimates(bearing: pd.DataFrame, at_failure: float, deviation: float) -> pd.DataFrame:
    """Return an estimate for every inspection of a bearing at which a trend is known; nothing later than it is used."""
    hours, severity = bearing["hours"].to_numpy(), bearing["severity"].to_numpy()
    rows: list[tuple[float, ...]] = []
    for now in range(len(hours) - 1):
        since = max(begin(severity[: now + 1]), now + 1 - WINDOW)
        if now + 1 - since >= 4 and bearing["remaining_life"].iloc[now] > 0.0:
            seen = slice(since, now + 1)
            found = dcrb_ros.estimate_remaining_life(hours[seen], severity[seen], at_failure, growth=GROWTH, limit_deviation=deviation)
            rows.append((hours[now], bearing["remaining_life"].iloc[now], found.median, found.low, found.high))
    found = pd.DataFrame(rows, columns=["hours", "true", "median", "low", "high"], dtype=np.float64)
    return found.assign(bearing=bearing["bearing_id"].iloc[0])


def courses(train: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return the time from the trend's begin to failure of each training bearing that failed [h], and its course.

    A course is the logarithm of the severity over its healthy median at `SHARES` of that time, shape (bearings, shares).
    """
    times, found = [], []
    for _, rows in train.groupby("bearing_id"):
        hours, severity = rows["hours"].to_numpy(), rows["severity"].to_numpy()
        first = begin(severity)
        if rows["remaining_life"].iloc[-1] == 0.0 and first < len(hours) - 1:
            times.append(hours[-1] - hours[first])
            level = np.log(severity[first:] / np.median(severity[:HEALTHY]))
            found.append(np.interp(SHARES, (hours[first:] - hours[first]) / times[-1], level))
    return np.array(times), np.array(found)


def update(hours: np.ndarray, severity: np.ndarray, times: np.ndarray, known: np.ndarray) -> float:
    """Return the median of the remaining life after a Bayesian update [h], on a grid.

    The prior of the time from the trend's begin to failure is the lognormal one of the training bearings; each inspection since then has a
    normal likelihood about their mean course at its share of that time.
    """
    first = begin(severity)
    grid = np.exp(np.linspace(np.log(0.1 * times.min()), np.log(8.0 * times.max()), 400))
    spread = np.log(times).std(ddof=1) * np.sqrt(1.0 + 1.0 / len(times))
    likelihood = -0.5 * ((np.log(grid) - np.log(times).mean()) / spread) ** 2
    mean, deviation = known.mean(axis=0), known.std(axis=0, ddof=1) + LEAST_DEVIATION
    for time, level in zip(hours[first:] - hours[first], np.log(severity[first:] / np.median(severity[:HEALTHY])), strict=True):
        share = np.minimum(time / grid, 1.0)
        here = np.interp(share, SHARES, deviation)
        likelihood += -0.5 * ((level - np.interp(share, SHARES, mean)) / here) ** 2 - np.log(here)
    passed = hours[-1] - hours[first]
    likelihood[grid <= passed] = -np.inf
    if not np.isfinite(likelihood).any():
        return 0.0
    weight = np.cumsum(np.exp(likelihood - likelihood.max()))
    return float(np.interp(0.5 * weight[-1], weight, grid) - passed)


def updates(found: pd.DataFrame, others: pd.DataFrame, train: pd.DataFrame) -> list[float]:
    """Return the Bayesian estimate at the inspections of other estimates; nothing later than each is used."""
    times, known = courses(train)
    rows = dict(list(others.groupby("bearing_id")))
    estimated = []
    for name, hour in zip(found["bearing"], found["hours"], strict=True):
        seen = rows[name][rows[name]["hours"] <= hour]
        estimated.append(update(seen["hours"].to_numpy(), seen["severity"].to_numpy(), times, known))
    return estimated


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


def plot_estimates(found: pd.DataFrame, file: str) -> None:
    """Plot true and estimated remaining life of each bearing with three estimates or more."""
    names = [name for name, rows in found.groupby("bearing") if len(rows) >= 3]
    figure, axes = plt.subplots(1, len(names), figsize=(4.0 * len(names), 3.8), layout="constrained", squeeze=False, sharey=True)
    top = 1.6 * float(found["true"].max())
    for one, name in zip(axes[0], names, strict=True):
        rows = found[found["bearing"] == name]
        one.plot(rows["hours"], rows["true"], color="black", label="true")
        one.fill_between(
            rows["hours"], rows["low"].clip(upper=top), rows["high"].clip(upper=top), color="tab:blue", alpha=0.25, label="90 % interval"
        )
        one.plot(rows["hours"], rows["median"].clip(upper=top), "o-", color="tab:blue", ms=4.0, label="estimate")
        one.set(title=name, xlabel="operating hours [h]", ylim=(0.0, top))
    axes[0][0].set_ylabel("remaining life [h]")
    axes[0][0].legend()
    figure.savefig(file, dpi=100)


def main(folder: Path) -> None:
    """Learn the limit from the training bearings, and estimate the lives of all others."""
    table = inspections(folder)
    train, others = table[table["split"] == "train"], table[table["split"] != "train"]
    at_failure, deviation = limit(train)
    failures = int((train["remaining_life"] == 0.0).sum())
    print(f"limit {at_failure:.1f} m/s^2 from {failures} failures of training bearings")
    found = pd.concat([estimates(rows, at_failure, deviation) for _, rows in others.groupby("bearing_id")], ignore_index=True)
    for name, rows in found.groupby("bearing"):
        inside = ((rows["low"] <= rows["true"]) & (rows["true"] <= rows["high"])).mean()
        score = dcrb_ros.phm_2012_score(rows["true"], rows["median"])
        print(f"{name}: {len(rows)} estimates, PHM 2012 score {score:.2f}, {100 * inside:.0f} % within their intervals")
    constant = float(train.loc[train["damage"] > 0.0, "remaining_life"].median())
    by_chance = dcrb_ros.phm_2012_score(found["true"], np.full(len(found), constant))
    score = dcrb_ros.phm_2012_score(found["true"], found["median"])
    print(f"all: PHM 2012 score {score:.2f}, by always saying {constant:.0f} h {by_chance:.2f}")
    if failures >= 3:
        print(f"Bayesian update: PHM 2012 score {dcrb_ros.phm_2012_score(found['true'], updates(found, others, train)):.2f}")
    plot_severity(train, at_failure, "severity.png")
    plot_estimates(found, "remaining-life.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
