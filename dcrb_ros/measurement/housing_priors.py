"""Ranges from which housings and their backgrounds are drawn: a laboratory rig and an axle box.

Densities, losses, participation and seat of the laboratory rig follow measured spectra and decays of HIT and MFPT. Its background follows
the quiet quarter between the impacts of CWRU, HIT and MFPT, and the mounting how the spectra of their bearings differ. The first mode, the
axle box and all spreads are choices. Mode counts: plate and solid, Harris' Shock and Vibration Handbook, Eqs. 11.69 and 11.70.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

HousingName = Literal["none", "laboratory", "axle_box"]


class Lognormal(NamedTuple):
    """A median and the factor of one standard deviation; values are clipped at two of them."""

    median: float
    factor: float

    def drawn(self, random: np.random.Generator) -> float:
        """Return a random value."""
        return float(self.median * self.factor ** np.clip(random.standard_normal(), -2.0, 2.0))


class Uniform(NamedTuple):
    """A range with equal probability."""

    low: float
    high: float

    def drawn(self, random: np.random.Generator) -> float:
        """Return a random value."""
        return float(random.uniform(self.low, self.high))


class Normal(NamedTuple):
    """A normal distribution."""

    mean: float
    deviation: float

    def drawn(self, random: np.random.Generator) -> float:
        """Return a random value."""
        return float(random.normal(self.mean, self.deviation))


class Beta(NamedTuple):
    """A beta distribution on 0 to 1, whose mean is a/(a + b)."""

    a: float
    b: float

    def drawn(self, random: np.random.Generator) -> float:
        """Return a random value."""
        return float(random.beta(self.a, self.b))


class HousingPrior(NamedTuple):
    """Distributions of a kind of housing and of the background behind it."""

    density: Lognormal
    """Modal density at 1 kHz [1/Hz]."""
    growth: float
    """Exponent with which the modal density grows over the frequency [-]."""
    loss: Lognormal
    """Loss factor at 1 kHz [-]."""
    fall: float
    """Exponent with which the loss factor falls over the frequency [-]."""
    first: Lognormal
    """Frequency of the first elastic mode [Hz]."""
    participation: Lognormal
    """Scale g of the participation factors, sqrt(2) times their standard deviation at 1 kHz [-]."""
    rise: Uniform
    """Exponent with which the participation rises over the frequency [-]."""
    seat: Lognormal
    """Natural frequency of the ring in its seat [Hz]."""
    mounting: float
    """Correlation of the participation factors of two mountings [-]."""
    background: Normal
    """Level of the background over the healthy bearing [dB]."""
    lines: Beta
    """Share of the background's power in lines [-]."""


LABORATORY = HousingPrior(
    density=Lognormal(8e-3, 1.5),
    growth=0.3,
    loss=Lognormal(0.1, 1.4),
    fall=0.7,
    first=Lognormal(800.0, 1.4),
    participation=Lognormal(0.15, 1.5),
    rise=Uniform(0.3, 1.3),
    seat=Lognormal(18e3, 1.6),
    mounting=0.6,
    background=Normal(-5.0, 5.0),
    lines=Beta(1.0, 2.0),
)
"""A ball bearing in a machined support on a plate, beside a motor."""

AXLE_BOX = HousingPrior(
    density=Lognormal(3e-3, 1.5),
    growth=1.0,
    loss=Lognormal(0.03, 1.4),
    fall=0.25,
    first=Lognormal(900.0, 1.4),
    participation=Lognormal(0.10, 1.5),
    rise=Uniform(0.0, 0.5),
    seat=Lognormal(14e3, 1.3),
    mounting=0.6,
    background=Normal(0.0, 4.0),
    lines=Beta(1.0, 5.0),
)
"""A compact casting of 60 kg."""

PRIORS = {"laboratory": LABORATORY, "axle_box": AXLE_BOX}
"""Distributions by the name of a housing."""

FLOORS = {"outer": Lognormal(0.04, 3.0), "inner": Lognormal(0.04, 3.0), "roller": Lognormal(2.3, 2.0)}
"""Added power of the floor over added power of the bearing [-], by the damaged part; rings: what the simulated ringing leaves of the
quiet quarter between impacts on CWRU, HIT and MFPT; rollers: 70 % of all added power, as on CWRU."""
