"""The nearest template: an order spectrum of the envelope is compared with the ideal one of each defect (McFadden and Smith 1984)."""

import numpy as np
from scipy.stats import pearson3, skew
from spectra import highpass, order_spectrum, struck
from trending import SLIP, Trending

VARIANTS = {
    "envelope templates": {},
    "envelope templates, whole band": {"lowest": 100.0},
    "envelope templates, careful": {"chance": 1e-6},
}
"""Settings of each member of the family; the first has the published ones."""
SIDEBANDS = {"outer_ring": (), "inner_ring": (1.0,), "roller": ("FTF",), "cage": ()}
"""Modulation of the impacts of each part: by the load zone once a turn, or by the cage."""


def noise_spectrum(lines, random):
    """Return a complex spectrum of white noise behind a Hann window, which joins each line to its two neighbours."""
    return np.convolve(random.standard_normal(lines) + 1j * random.standard_normal(lines), (-0.25, 0.5, -0.25), "same")


class EnvelopeTemplates(Trending):
    """Report the template with the largest cosine to the spectrum's excess over its median, without a healthy level.

    A template has lines at three harmonics of a part and at two sidebands of each, half as strong. The excess is ln(power / median), at
    least 0, below 30 orders, and a cosine counts from the level on that white noise exceeds with probability ``chance``: mean, deviation
    and skewness over 500 spectra of noise behind a Hann window give a gamma distribution. Independent of the gain; no recording was used.
    """

    learning, factor = 0, 1.0
    lowest = 2000.0
    """Lower end of the band [Hz]."""
    chance = 1e-4
    """Probability that a window of noise exceeds the level [-]."""

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        self.levels = {}

    def templates(self, places, turns):
        """Return the template of each part on the orders ``places``, of unit norm."""
        found = {}
        for part, order in struck(self.orders).items():
            template = np.zeros(len(places))
            for harmonic in (1.0, 2.0, 3.0):
                for modulation in (0.0, *SIDEBANDS[part]):
                    offset = self.orders[modulation] if isinstance(modulation, str) else modulation
                    for line in {harmonic * order - offset, harmonic * order + offset}:
                        width = max(0.5 * SLIP * line, 1.0 / turns)
                        template += (0.5 if offset else 1.0) / harmonic * np.exp(-0.5 * ((places - line) / width) ** 2)
            found[part] = template / max(np.linalg.norm(template), 1e-12)
        return found

    def cosines(self, spectrum, turns):
        """Return the cosine of the spectrum's excess to each template [-]."""
        power = spectrum[2 : max(int(30.0 * turns), 8)] ** 2
        groups = np.array_split(power, max(int(len(power) / turns / 3.0), 1))
        smooth = np.concatenate([np.full(len(part), np.median(part)) for part in groups])
        excess = np.maximum(np.log(power / smooth + 1e-12), 0.0)
        places = (np.arange(len(power)) + 2) / turns
        return {part: template @ excess / max(np.linalg.norm(excess), 1e-12) for part, template in self.templates(places, turns).items()}

    def features(self, acceleration, angle):
        """Return the cosine of every part relative to the level of noise."""
        spectrum, turns = order_spectrum(highpass(acceleration, self.rate, self.lowest) ** 2, angle)
        key = round(turns)
        if key not in self.levels:
            random = np.random.default_rng(1)
            noise = [self.cosines(np.abs(noise_spectrum(len(spectrum), random)), turns) for _ in range(500)]
            values = {part: np.array([cosines[part] for cosines in noise]) for part in SIDEBANDS}
            self.levels[key] = {part: pearson3.isf(self.chance, skew(value), value.mean(), value.std()) for part, value in values.items()}
        return {part: cosine / self.levels[key][part] for part, cosine in self.cosines(spectrum, turns).items()}
