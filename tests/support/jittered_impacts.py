"""Signals of ball bearings that the simulation did not make: jittered impacts through resonances, noise, gears and shafts.

The model of Randall, Antoni and Chobsaard 2001, "The relationship between spectral correlation and envelope analysis in the diagnostics of
bearing faults and other cyclostationary machine signals": impacts at nearly equal intervals, whose random deviations add up, modulated by
the load at the defect, through the resonances of a structure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from dcrb_ros.bearing.frequencies import Orders

Floats = npt.NDArray[np.float64]


@dataclass
class Machine:
    """A machine with a ball bearing."""

    seed: int
    balls: int = 9
    ratio: float = 0.2
    """Ball diameter times the cosine of the contact angle over the pitch diameter [-]."""
    rate: int = 12000
    """[Hz]"""
    speed: float = 25.0
    """[Hz]"""
    departure: float = 0.0
    """Relative departure of the fault lines from the kinematic orders [-]."""
    jitter: float = 0.008
    """Standard deviation of an interval between impacts relative to its mean [-]."""
    random: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)

    @property
    def orders(self) -> Orders:
        """Kinematic orders of the bearing."""
        cage = 0.5 * (1.0 - self.ratio)
        return Orders(cage, self.balls * cage, self.balls * (1.0 - cage), 0.5 * (1.0 - self.ratio**2) / self.ratio)

    def structure(self, excitation: Floats) -> Floats:
        """Return a signal after three random resonances."""
        out = np.zeros(len(excitation))
        for frequency in self.random.uniform(0.12, 0.42, 3) * self.rate:
            damping = self.random.uniform(0.02, 0.06)
            pole = math.exp(-2.0 * math.pi * damping * frequency / self.rate)
            turn = 2.0 * math.pi * frequency / self.rate
            out += self.random.uniform(0.3, 1.0) * lfilter([math.sin(turn)], [1.0, -2.0 * pole * math.cos(turn), pole**2], excitation)
        return out

    def healthy(self, seconds: float, *, coloured: bool = True, shaft: float = 0.0, gear: float = 0.0, compliance: float = 0.0) -> Floats:
        """Return noise of unit variance with parts of a healthy machine.

        ``shaft`` is the depth at which the shaft modulates the noise, ``gear`` the amplitude of a mesh with sidebands, ``compliance`` the
        depth at which the balls that pass the load modulate the noise.
        """
        time = np.arange(round(seconds * self.rate)) / self.rate
        noise = self.random.normal(size=len(time))
        noise = self.structure(noise) + 0.2 * self.random.normal(size=len(time)) if coloured else noise
        noise /= noise.std()
        turns = 2.0 * math.pi * self.speed * time
        noise *= 1.0 + sum(shaft / k * np.cos(k * turns + self.random.uniform(0.0, 6.3)) for k in (1, 2, 3))
        noise *= 1.0 + compliance * np.cos(self.orders.bpfo * turns)
        teeth = int(self.random.integers(19, 60))
        mesh = sum(np.cos(h * teeth * turns + self.random.uniform(0.0, 6.3)) / h for h in (1, 2, 3))
        tones = gear * mesh * (1.0 + 0.5 * np.cos(turns)) + 0.5 * shaft * np.cos(turns)
        return np.asarray(noise + tones, np.float64)

    def impacts(self, seconds: float, fault: str) -> Floats:
        """Return the impacts of a fault of ``outer_ring``, ``inner_ring`` or ``roller`` through the structure, of unit variance."""
        o = self.orders
        order = {"outer_ring": o.bpfo, "inner_ring": o.bpfi, "roller": 2.0 * o.bsf}[fault] * (1.0 + self.departure)
        interval = self.rate / (self.speed * order)
        count = int(seconds * self.rate / interval) + 10
        places = np.cumsum(interval * (1.0 + self.jitter * self.random.normal(size=count)))
        places = places[places < seconds * self.rate - 1.0]
        phase = 2.0 * math.pi * self.speed * places / self.rate
        load = {"outer_ring": np.ones(len(places)), "inner_ring": 0.6 + 0.4 * np.cos(phase), "roller": 0.6 + 0.4 * np.cos(o.ftf * phase)}[
            fault
        ]
        excitation = np.zeros(round(seconds * self.rate))
        np.add.at(excitation, places.astype(np.int64), load * self.random.normal(1.0, 0.15, len(places)))
        found = self.structure(excitation)
        return np.asarray(found / found.std(), np.float64)

    def wandering_ball(self, seconds: float, *, spread: float = 0.01, load_zone: float = 0.3) -> Floats:
        """Return the impacts of a ball whose spin wanders through the structure, of unit variance.

        In each turn of the cage it strikes at 2 BSF within a ``load_zone`` [turns of the cage]. Its phase is lost outside, and its spin
        scatters by ``spread`` (relative).
        """
        o, excitation = self.orders, np.zeros(round(seconds * self.rate))
        turns = int(seconds * self.speed * o.ftf)
        for turn in range(turns):
            order = 2.0 * o.bsf * (1.0 + self.departure) * (1.0 + spread * self.random.normal())
            interval = o.ftf / order
            strikes = np.arange(self.random.uniform(0.0, interval), load_zone, interval)
            load = np.cos(math.pi * (strikes / load_zone - 0.5))
            places = (turn + strikes) / (o.ftf * self.speed) * self.rate
            inside = places < len(excitation)
            np.add.at(excitation, places[inside].astype(np.int64), load[inside])
        found = self.structure(excitation)
        return np.asarray(found / found.std(), np.float64)
