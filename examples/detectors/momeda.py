"""MOMEDA, a blind deconvolution: the filter whose output comes closest to a train of impulses (McDonald and Zhao 2017)."""

import numpy as np
from deconvolution import autocorrelation
from scipy.linalg import solve_toeplitz
from spectra import highpass, struck
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
    targets = np.stack([np.roll(folded, lag) for lag in range(TAPS)])  # shape (taps, positions)
    return np.sqrt(np.max(np.sum(targets * solve_toeplitz(autocorrelation(acceleration, TAPS), targets), axis=0)) / count)


class Momeda(Trending):
    """Report the part at whose period a filter finds the impulses that have grown most over the healthy level.

    The signal is the squared envelope above 2 kHz: rollers slip, so the impacts of a bearing do not repeat to a period of their ringing.
    """

    factor = 1.5

    def features(self, acceleration, angle):
        """Return the multi D-norm at the mean period of every part, the largest of three within its slip."""
        turn = self.rate * self.window / (abs(angle[-1] - angle[0]) / (2.0 * np.pi))
        squared = highpass(acceleration, self.rate, 2000.0) ** 2
        envelope = squared - squared.mean()
        orders = ((part, order) for part, order in struck(self.orders).items() if part != "cage")
        return {part: max(multi_d_norm(envelope, slip * turn / order) for slip in (0.99, 1.0, 1.01)) for part, order in orders}
