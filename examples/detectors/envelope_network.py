"""A neural network on lines of the envelope, trained on impacts of the model of McFadden and Smith (1984) in noise.

``python envelope_network.py`` makes the signals, trains the network and rewrites envelope_network.json, which takes a minute and needs
scikit-learn. Running the detector needs neither.
"""

import json
from pathlib import Path

import numpy as np
from spectra import highpass, order_spectrum, struck
from trending import SLIP, Trending

VARIANTS = {
    "envelope network": {},
    "envelope network, certain": {"certain": 0.95},
    "envelope network, whole band": {"lowest": 100.0},
}
"""Settings of each member of the family; the first has the published ones."""
MODEL = Path(__file__).with_suffix(".json")
CLASSES = ("healthy", "outer_ring", "inner_ring", "roller")
RATE = 12_800.0
"""Sampling rate of the training signals [Hz]."""


def inputs(spectrum, turns, orders):
    """Return ln(line / median around it) of three harmonics of each part, and of the sidebands of the first two, shape (24,)."""
    places, numbers = np.arange(len(spectrum)) / turns, []
    for part, order in struck(orders).items():
        modulation = {"inner_ring": 1.0, "outer_ring": 1.0, "roller": orders["FTF"], "cage": 1.0}[part]
        lines = [k * order for k in (1, 2, 3)] + [order - modulation, order + modulation, 2.0 * order + modulation]
        for line in np.abs(lines):
            near = np.abs(places - line) <= max(SLIP * line, 1.0 / turns)
            around = np.abs(places - line) <= 1.5
            numbers.append(np.log(spectrum[near].max() / np.median(spectrum[around])) if near.any() else 1.0)
    return np.array(numbers)


class EnvelopeNetwork(Trending):
    """Report the most probable class of one hidden layer, from a probability ``certain`` on; there is no healthy level.

    Trained on 6000 windows of one second: random orders of bearings with 6 to 16 elements, 5 to 60 Hz, impacts with 1 % of slip and
    random strength, load zone and cage modulation, a healthy modulation at BPFO in a third of the healthy ones. The inputs are
    independent of the gain. No recording was used.
    """

    learning, factor = 0, 1.0
    certain = 0.8
    """Probability from which a fault is reported [-]."""
    lowest = 2000.0
    """Lower end of the band [Hz]."""

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        self.model = {name: np.array(value) for name, value in json.loads(MODEL.read_text()).items()}

    def features(self, acceleration, angle):
        """Return the odds of every fault against the rest, relative to those of ``certain``."""
        spectrum, turns = order_spectrum(highpass(acceleration, self.rate, self.lowest) ** 2, angle)
        x = (inputs(spectrum, turns, self.orders) - self.model["mean"]) / self.model["scale"]
        hidden = np.maximum(x @ self.model["first"] + self.model["first_bias"], 0.0)
        evidence = hidden @ self.model["second"] + self.model["second_bias"]
        likely = np.exp(evidence - evidence.max())
        p = dict(zip(CLASSES, np.clip(likely / likely.sum(), 1e-9, 1.0 - 1e-9), strict=True))
        return {part: p[part] / (1.0 - p[part]) * (1.0 - self.certain) / self.certain for part in CLASSES[1:]}


def window(random, kind):
    """Return squared signal, shaft angle and orders of a window of a class: noise, and impacts that ring."""
    count, share, speed = random.integers(6, 17), random.uniform(0.12, 0.3), random.uniform(5.0, 60.0)
    orders = {"FTF": (1 - share) / 2, "BPFO": count * (1 - share) / 2, "BPFI": count * (1 + share) / 2, "BSF": (1 / share - share) / 2}
    time = np.arange(int(RATE)) / RATE
    turns, signal = speed * time, random.normal(size=int(RATE))
    if kind == "healthy":
        if random.random() < 0.33:
            signal *= 1.0 + random.uniform(0.0, 0.4) * np.cos(2.0 * np.pi * (orders["BPFO"] * turns + random.random()))
    else:
        order = struck(orders)[kind]
        strikes = (np.cumsum(random.normal(1.0, 0.01, int(order * speed) + 2)) - random.random()) / (order * speed)
        strikes = strikes[(strikes > 0.0) & (strikes < 0.99)]
        modulation = {"outer_ring": 0.0, "inner_ring": 1.0, "roller": orders["FTF"]}[kind]
        depth = random.uniform(0.3, 1.0) if modulation else 0.0
        strength = 1.0 + depth * np.cos(2.0 * np.pi * (modulation * speed * strikes + random.random()))
        strength *= np.exp(random.normal(0.0, random.uniform(0.1, 0.5), len(strikes)))
        impulses = np.zeros(len(time))
        np.add.at(impulses, (strikes * RATE).astype(int), strength)
        ring = np.arange(128) / RATE
        response = np.exp(-ring * random.uniform(500.0, 2500.0)) * np.sin(2.0 * np.pi * random.uniform(2500.0, 5500.0) * ring)
        signal += 10.0 ** random.uniform(0.2, 1.3) * np.convolve(impulses, response)[: len(time)]
    return highpass(signal, RATE, 2000.0) ** 2, 2.0 * np.pi * turns, orders


def main():
    """Train and write the model."""
    from sklearn.neural_network import MLPClassifier  # only training needs it

    random, x, y = np.random.default_rng(7), [], []
    for k in range(6000):
        squared, angle, orders = window(random, kind := CLASSES[k % 4])
        x.append(inputs(*order_spectrum(squared, angle), orders))
        y.append(CLASSES.index(kind))
    x = np.array(x)
    mean, scale = x.mean(axis=0), x.std(axis=0) + 1e-9
    fitted = MLPClassifier((16,), alpha=0.1, max_iter=400, random_state=1).fit((x - mean) / scale, y)
    (first, second), (first_bias, second_bias) = fitted.coefs_, fitted.intercepts_
    arrays = {"mean": mean, "scale": scale, "first": first, "first_bias": first_bias, "second": second, "second_bias": second_bias}
    MODEL.write_text(json.dumps({name: np.round(value, 5).tolist() for name, value in arrays.items()}) + "\n")
    print(f"{len(y)} windows, {np.mean(fitted.predict((x - mean) / scale) == y):.2f} of them classified correctly")


if __name__ == "__main__":
    main()
