"""A baseline classifier on a data set of `dcrb sweep`: python examples/baseline.py DIR."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import signal
from sklearn.ensemble import RandomForestClassifier
from sklearn.metrics import balanced_accuracy_score, confusion_matrix

import dcrb_ros


def features(data_set: dcrb_ros.DataSet, row: pd.Series) -> list[float]:
    """Return level, kurtosis and the envelope lines relative to their background, as logarithms."""
    waveform = data_set.waveform(row["run"])
    found: list[float] = []
    turns = np.abs(waveform.turns)  # whichever way the shaft turns
    if turns[-1] - turns[0] < 2.0:  # the lines of a shorter run are not resolved
        raise dcrb_ros.Refusal(f"{row['run']} has {turns[-1] - turns[0]:.2g} revolutions, but a run needs two: simulate longer runs")
    for axis in np.ascontiguousarray(waveform.acceleration.T):
        filtered = signal.sosfiltfilt(signal.butter(4, 2000.0, "highpass", fs=row["sampling_rate"], output="sos"), axis)
        envelope = np.abs(signal.hilbert(filtered))
        found += [np.log(np.std(axis)), np.log(np.mean((axis - axis.mean()) ** 4) / np.var(axis) ** 2)]
        # Order tracking: over the shaft angle, the lines have the same orders at any speed.
        even = np.interp(np.linspace(turns[0], turns[-1], len(turns)), turns, envelope)
        spectrum = np.abs(np.fft.rfft((even - even.mean()) * np.hanning(len(even))))
        order, shaft = np.arange(len(spectrum)) / (turns[-1] - turns[0]), abs(row["speed"]) / (2.0 * np.pi)
        for name in ("ftf", "bpfo", "bpfi", "bsf"):
            for harmonic in (1, 2, 3, 4):
                line = harmonic * row[name] / shaft
                near, around = np.abs(order - line) < 0.3, np.abs(order - line) < 3.0
                found.append(np.log(spectrum[near].max() / np.median(spectrum[around])))
    return found


def main(folder: Path) -> float:
    """Train on the split train, print the confusion matrix of the split test, and return its balanced accuracy [-]."""
    data_set = dcrb_ros.DataSet(folder)
    tables = {split: data_set.labels(split) for split in ("train", "test")}
    x = {split: np.array([features(data_set, row) for _, row in table.iterrows()]) for split, table in tables.items()}
    forest = RandomForestClassifier(300, random_state=1).fit(x["train"], tables["train"]["fault"])
    found, truth = forest.predict(x["test"]), tables["test"]["fault"]
    print(pd.DataFrame(confusion_matrix(truth, found, labels=forest.classes_), forest.classes_, forest.classes_))
    accuracy = float(balanced_accuracy_score(truth, found))
    print(f"balanced accuracy on test: {accuracy:.2f}, by chance {1.0 / len(forest.classes_):.2f}")
    return accuracy


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder with a data set of dcrb sweep")
    try:
        main(parser.parse_args().folder)
    except dcrb_ros.Refusal as refusal:
        parser.error(str(refusal))
