"""What the example detectors share: windows of one second, lines of an order spectrum, and growth since the first windows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import pairwise
from typing import Literal, get_args, get_origin, get_type_hints

import numpy as np
from scipy.signal.windows import tukey

from dcrb_ros import Diagnosis, Refusal

PARTS = ("outer_ring", "inner_ring", "roller", "cage")
"""Verdicts on a part of the bearing."""
SLIP = 0.02
"""Deviation of a characteristic order by slip [-]."""
PER_TURN = 128
"""Samples per revolution of a signal over the shaft angle [-]."""
TAPER = 0.05
"""Share of a window over which it is faded in, and out [-]: the jump between its ends would be an impact in every band."""
HIGHEST = 0.43
"""Upper end of the bands relative to the sampling rate [-]: the anti-aliasing filter rules above."""


class Trending(ABC):
    """A detector that reports the feature that has grown most since the first windows; a subclass computes the features of a window.

    The public class attributes of numbers and texts are its settings; keyword arguments of the constructor replace their values. A text
    with a few possible values has the type `Literal`.
    """

    window, hop = 1.0, 0.5
    """Length of a window, and time from one to the next [s]."""
    learning = 4
    """Windows from which the healthy level of a feature is learnt [-]; with 0 the level is 1.

    A subclass that learns a model of its own needs 1."""
    factor = 3.0
    """Growth from which a feature is an alarm [-]."""
    fewest_turns = 4.0
    """Revolutions that a window must contain [-]."""

    def __init__(self, orders, rate, **settings):
        self.orders, self.rate = orders.as_dict(), rate
        allowed = settings_of(type(self))
        for name, value in settings.items():
            if name not in allowed:
                raise Refusal(f"{type(self).__name__} has no setting {name!r}. Choose among {', '.join(allowed)}.")
            setattr(self, name, value)
        for name, kind in get_type_hints(type(self)).items():
            if get_origin(kind) is Literal and (value := getattr(self, name)) not in get_args(kind):
                raise Refusal(f"{name} = {value!r} is unknown. Choose among {', '.join(get_args(kind))}.")
        if self.learning < 0:
            raise Refusal(f"learning = {self.learning} is negative: give the number of windows from which the healthy level is learnt.")
        self.length, self.step = int(self.window * rate), int(self.hop * rate)
        self.acceleration, self.angle = np.zeros(0), np.zeros(0)
        self.next_index, self.healthy, self.before = None, [], "healthy"
        self.verdict = "waiting" if self.learning else "healthy"

    @abstractmethod
    def features(self, acceleration, angle):
        """Return a positive number for each part of the bearing, or for each indicator that names none.

        ``acceleration`` is radial [m/s^2], ``angle`` is unwrapped [rad].
        """

    def update(self, index, acceleration, shaft_angle):
        """Take a block; return a diagnosis at the end of a window."""
        if index != self.next_index:  # blocks were lost
            self.acceleration, self.angle = np.zeros(0), np.zeros(0)
        self.next_index = index + len(shaft_angle)
        self.acceleration = np.concatenate([self.acceleration, acceleration[:, 1].astype(float)])
        self.angle = np.concatenate([self.angle, shaft_angle.astype(float)])
        if len(self.angle) < self.length:
            return None
        window, angle = self.acceleration[-self.length :], np.unwrap(self.angle[-self.length :])
        self.acceleration, self.angle = window[self.step :], self.angle[-self.length :][self.step :]
        score, turning = None, abs(angle[-1] - angle[0]) >= self.fewest_turns * 2.0 * np.pi
        if turning and np.ptp(window) > 0.0:  # a constant is a broken sensor, which allows no judgement
            with np.errstate(divide="ignore", invalid="ignore"):
                found = self.features(window - window.mean(), angle)
            if np.isfinite(list(found.values())).all():
                score = self.judge(found)
        last = self.next_index - 1
        scores = {} if score is None else {"outer_ring": score}  # the exam takes the largest, whatever its name
        return Diagnosis(last, last / self.rate, self.verdict, "growth over the healthy level", scores=scores)

    def judge(self, found):
        """Set the verdict: after two windows with the same result; return the evidence relative to the threshold [dB].

        An indicator that names no part is taken for the most frequent fault, a defect of the outer ring.
        """
        if len(self.healthy) < self.learning:
            self.healthy.append(found)
            self.verdict = "healthy" if len(self.healthy) == self.learning else "waiting"
            return None
        healthy = {name: max(1e-12, *(past[name] for past in self.healthy)) if self.learning else 1.0 for name in found}
        grown = {name: value / healthy[name] for name, value in found.items()}
        largest = max(grown, key=grown.get)
        now = (largest if largest in PARTS else "outer_ring") if grown[largest] > self.factor else "healthy"
        self.verdict = now if now == self.before else self.verdict
        self.before = now
        return 20.0 * np.log10(max(grown[largest], 1e-6) / self.factor)


def settings_of(detector):
    """Return the names of the settings of a class of detectors: its public class attributes that are numbers or texts."""
    names = {name for kind in detector.__mro__ for name, value in vars(kind).items() if isinstance(value, (int, float, str))}
    return sorted(name for name in names if not name.startswith("_"))


def over_angle(signal, angle):
    """Return a signal averaged over equal steps of the shaft angle, and its number of revolutions [-]."""
    turns = np.abs(np.interp(np.linspace(0.0, 1.0, len(signal)), np.linspace(0.0, 1.0, len(angle)), angle) - angle[0]) / (2.0 * np.pi)
    turns = np.maximum.accumulate(turns)
    edges = np.linspace(0.0, turns[-1], int(turns[-1] * PER_TURN) + 1)
    total = np.concatenate([[0.0], np.cumsum(0.5 * (signal[1:] + signal[:-1]) * np.diff(turns))])
    return np.diff(np.interp(edges, turns, total)) / np.diff(edges), turns[-1]


def bands(acceleration, levels=5):
    """Yield low and high edge, relative to the sampling rate, and the squared envelope of each band of a 1/3-binary tree.

    The tree ends at `HIGHEST`. Each level halves the bands, or cuts them into three. The complex envelope of a band is its part of the
    Fourier transform of the tapered window, moved to 0; the edges are smooth so that an impact stays short.
    """
    transform = np.fft.rfft(acceleration * tukey(len(acceleration), 2.0 * TAPER))[: int(HIGHEST * len(acceleration)) + 1]
    for level in range(1, levels + 1):
        for count in (2**level, 3 * 2 ** (level - 1)):
            edges = np.linspace(1, len(transform) - 1, count + 1).astype(int)
            for low, high in pairwise(edges):
                part = transform[low:high] * np.hanning(high - low)
                envelope = np.abs(np.fft.ifft(part)) ** 2
                yield low / len(acceleration), high / len(acceleration), envelope
