"""MOMEDA, a blind deconvolution: the filter whose output comes closest to a train of impulses (McDonald and Zhao 2017)."""

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import butter, sosfilt
from trending import Trending

TAPS = 64
"""Length of the filter [samples]."""

VARIANTS = {
    "MOMEDA": {},
    "MOMEDA, factor 1.25": {"factor": 1.25},
    "MOMEDA, factor 2": {"factor": 2.0},
}
"""Settings of each member of the family; the first has the published ones."""


def multi_d_norm(acceleration, period):
    """Return the multi D-norm of the best filter for impulses at a period [samples], over all positions of the first impulse [-].

    The filter f = (X X^T)^-1 X t of the target t maximises D = t^T y / (|t| |y|) of its output y = X^T f; then
    D^2 = (X t)^T (X X^T)^-1 (X t) / |t|^2. X t adds the signal at the impulses, so it is the mean period of the signal, one lag
    for each tap. X X^T is taken as the Toeplitz matrix of the autocorrelation.
    """
    count, samples = int(len(acceleration) / period), int(period)
    positions = (np.arange(count)[:, None] * period).astype(int) + np.arange(samples)
    folded = acceleration[positions].sum(axis=0)
    power = np.abs(np.fft.rfft(acceleration, 2 * len(acceleration))) ** 2
    correlation = np.fft.irfft(power)[:TAPS]
    correlation[0] *= 1.0 + 1e-6
    targets = np.stack([np.roll(folded, lag) for lag in range(TAPS)])  # shape (taps, positions)
    return np.sqrt(np.max(np.sum(targets * solve_toeplitz(correlation, targets), axis=0)) / count)


class Momeda(Trending):
    """Report the part at whose period a filter finds the impulses that have grown most over the healthy level.

    The signal is the squared envelope above 2 kHz: rollers slip, so the impacts of a bearing do not repeat to a period of their ringing.
    """

    factor = 1.5

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        self.filter = butter(4, min(2000.0, 0.25 * rate), "highpass", fs=rate, output="sos")

    def features(self, acceleration, angle):
        """Return the multi D-norm at the mean period of every part, the largest of three within its slip."""
        turn = self.rate * self.window / (abs(angle[-1] - angle[0]) / (2.0 * np.pi))
        squared = sosfilt(self.filter, acceleration) ** 2
        envelope = squared - squared.mean()
        struck = {"outer_ring": self.orders["BPFO"], "inner_ring": self.orders["BPFI"], "roller": 2.0 * self.orders["BSF"]}
        slips = (0.99, 1.0, 1.01)
        return {part: max(multi_d_norm(envelope, slip * turn / order) for slip in slips) for part, order in struck.items()}
