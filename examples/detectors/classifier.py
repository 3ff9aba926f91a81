"""A small classifier trained on simulated bearings alone: logistic regression on features of one window.

``python classifier.py`` simulates bearings of many individuals, speeds, loads and paths, trains on them and rewrites classifier.json, which
takes some minutes and needs scikit-learn. Running the detector needs neither.
"""

import json
from pathlib import Path

import numpy as np

from dcrb_ros import Diagnosis, FeatureExtractor, simulate

MODEL = Path(__file__).with_suffix(".json")
USED = ("kurtosis", "crest_factor", "kurtogram_kurtosis", "_depth", "_significance", "cepstrum", "coherence")
"""Parts of the names of the features used: none of them has a unit, so that the gain of the sensor does not matter."""
CERTAIN = 0.6
"""Probability from which a fault is reported [-]."""
SPALL = {"kind": "spall", "depth": 6e-5, "share": 0.35, "row": 1}
FAULTS = {
    "healthy": {},
    "outer_ring": {"outer_1": SPALL},
    "inner_ring": {"inner_1": SPALL},
    "roller": {"roller_1": {"row": 1, "roller": 3, "depth": 2e-5}},
}

VARIANTS = {
    "classifier": {},
    "classifier, certain": {"certain": 0.9},
    "classifier, majority": {"certain": 0.4},
}
"""Settings of each member of the family; the first has the published ones."""


def used(names):
    """Return the places of the used features."""
    return [k for k, name in enumerate(names) if any(part in name for part in USED)]


def inputs(values):
    """Return features compressed to a similar range; lines and kurtosis grow by orders of magnitude with a defect."""
    return np.arcsinh(values)


class Classifier:
    """Report the class with the largest probability, after two windows with the same result."""

    def __init__(self, orders, rate, certain=CERTAIN):
        self.certain = certain
        self.extractor, self.rate = FeatureExtractor(orders, rate, axes=("y",)), rate
        self.places, model = used(self.extractor.names), json.loads(MODEL.read_text())
        self.classes = model["classes"]
        self.mean, self.scale, self.weights, self.bias = (np.array(model[key]) for key in ("mean", "scale", "weights", "bias"))
        self.before, self.verdict = "healthy", "waiting"

    def probabilities(self, values):
        """Return the probability of each class for one window, shape (classes,)."""
        evidence = self.weights @ ((inputs(values[self.places]) - self.mean) / self.scale) + self.bias
        likely = np.exp(evidence - evidence.max())
        return likely / likely.sum()

    def update(self, index, acceleration, shaft_angle):
        """Take a block; return a diagnosis at the end of a window."""
        windows, diagnosis = self.extractor.update(index, acceleration, shaft_angle), None
        for time, values in zip(windows.time, windows.values, strict=True):
            score = None
            if np.isfinite(values[self.places]).all():
                p = dict(zip(self.classes, self.probabilities(values), strict=True))
                likely = max(p, key=p.get)
                now = likely if p[likely] > self.certain else "healthy"
                self.verdict = now if now == self.before else "healthy" if self.verdict == "waiting" else self.verdict
                self.before = now
                score = float(np.log10((1.0 - p["healthy"] + 1e-9) / (p["healthy"] + 1e-9)))
            scores = {} if score is None else {"outer_ring": score}  # the exam takes the largest, whatever its name
            diagnosis = Diagnosis(index + len(shaft_angle) - 1, float(time), self.verdict, "logistic regression", scores=scores)
        return diagnosis


def training_set(random, bearings=12, duration=4.0):
    """Return inputs and class of the windows of simulated bearings; no exam uses their individuals."""
    rows, classes = [], []
    for individual in range(bearings):
        machine = {
            "operating.speed": float(random.uniform(50.0, 200.0)),
            "operating.load": float(random.uniform(5e4, 1.2e5)),
            "surfaces.seed": 50_000 + individual,
            "structure.modes": int(random.integers(0, 11)),
            "structure.seed": int(random.integers(1, 10_000)),
            "sensor.noise_density": float(10.0 ** random.uniform(-3.5, -2.0)),
        }
        for verdict, defects in FAULTS.items():
            width = float(10.0 ** random.uniform(-3.2, -2.5))
            faults = {
                f"faults.{defect}.{key}": value for defect, keys in defects.items() for key, value in {**keys, "width": width}.items()
            }
            run = simulate("healthy", duration, settings={**machine, **faults}, seed=individual + 1)
            extractor = FeatureExtractor(run.orders, run.sampling_rate, axes=("y",))
            table = extractor.update(0, run.acceleration, run.shaft_angle)
            found = inputs(table.values[:, used(table.names)])
            found = found[np.isfinite(found).all(axis=1)]
            rows.append(found)
            classes += [verdict] * len(found)
    return np.concatenate(rows), np.array(classes)


def main():
    """Train and write the model."""
    from sklearn.linear_model import LogisticRegression  # only training needs it

    x, y = training_set(np.random.default_rng(5))
    mean, scale = x.mean(axis=0), x.std(axis=0) + 1e-9
    fitted = LogisticRegression(C=0.1, max_iter=2000).fit((x - mean) / scale, y)
    arrays = {"mean": mean, "scale": scale, "weights": fitted.coef_, "bias": fitted.intercept_}
    model = {"classes": list(fitted.classes_), **{key: np.round(value, 6).tolist() for key, value in arrays.items()}}
    MODEL.write_text(json.dumps(model) + "\n")
    print(f"{len(y)} windows, {np.mean(fitted.predict((x - mean) / scale) == y):.2f} of them classified correctly")


if __name__ == "__main__":
    main()
