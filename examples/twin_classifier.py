"""Train on simulated machines, test on recordings of a real one: python examples/twin_classifier.py TWINS RECORDINGS.

Both are folders with a data set, of `dcrb sweep` or `dcrb collect`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from sklearn.ensemble import RandomForestClassifier
from sklearn.metrics import roc_auc_score

import dcrb_ros


def windows(folder: Path) -> tuple[pd.DataFrame, pd.Series]:
    """Return the features of windows of one second of Y, without those that depend on the gain, and their faults."""
    data_set = dcrb_ros.DataSet(folder)
    parts, faults = [], []
    for _, row in data_set.labels().iterrows():
        waveform = data_set.waveform(row["run"])
        found = dcrb_ros.extract_features(waveform, window=1.0, hop=0.5, axes=["y"]).to_pandas()
        parts.append(found)
        faults += [row["fault"]] * len(found)
    features = pd.concat(parts)
    used = [name for name in features if name not in ("y_rms", "y_peak") and not name.startswith("y_level_")]
    return features[used], pd.Series(faults)


def main(twins: Path, recordings: Path) -> float:
    """Print how often each fault is called what, and return the mean area under the ROC curves of the faults [-]."""
    (x, fault), (tested, truth) = windows(twins), windows(recordings)
    if missing := sorted(set(truth) - set(fault)):
        raise dcrb_ros.Refusal(f"{twins} has no runs with {', '.join(missing)}, which {recordings} has: give twins of all its faults")
    if truth.nunique() < 2:
        raise dcrb_ros.Refusal(f"{recordings} has fewer than two classes: give recordings of two or more, such as healthy and outer_ring")
    forest = RandomForestClassifier(300, min_samples_leaf=2, class_weight="balanced", random_state=1).fit(x, fault)
    print(pd.crosstab(truth, forest.predict(tested), rownames=["truth"], colnames=["predicted"]))
    probability = pd.DataFrame(forest.predict_proba(tested), columns=forest.classes_)
    area = float(np.mean([roc_auc_score(truth == name, probability[name]) for name in truth.unique()]))
    print(f"macro AUROC: {area:.2f}, by chance 0.50")
    return area


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("twins", type=Path, help="data set to train on")
    parser.add_argument("recordings", type=Path, help="data set to test on")
    options = parser.parse_args()
    try:
        main(options.twins, options.recordings)
    except dcrb_ros.Refusal as refusal:
        parser.error(str(refusal))
