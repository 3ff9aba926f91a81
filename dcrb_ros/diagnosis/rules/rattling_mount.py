"""A loose mount: it transmits one direction better than the other."""

from __future__ import annotations

from collections import deque

import numpy as np

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.order_spectrum import medians
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

SHARES = (0.02, 0.05, 0.1, 0.25)
"""Shares of the samples beyond the quantiles that are compared: from rare, large samples to frequent, small ones."""
LATEST = 3
"""Hops of which the median counts."""
FEWEST = 4
"""Earlier hops without which nothing is compared."""
ALIKE = 1.5
"""Largest ratio of the changes of an axis among small and large samples [-]."""
REMEMBERED = 120
"""Earlier hops from which the usual asymmetry is taken: a minute."""


class RattlingMountParameters(Group):
    """Threshold for the asymmetry of the samples."""

    rattle_change: float = quantity(
        0.05,
        "-",
        "Common change of the asymmetry of small and large samples in all axes that is a loose mount; up to 0.03 in simulations of others",
        0.005,
        2.0,
    )


class RattlingMount(SampleRule[RattlingMountParameters]):
    """The asymmetry of the quantiles of each axis, compared with its median in the past minute.

    A linear path transmits both directions alike. A contact that opens has two stiffnesses, as a crack that breathes has, so that a
    sample a becomes a + r |a|: the asymmetry of a symmetric signal is then r, whatever its level, for large samples as for small ones. The
    impacts of a defect push in one direction, too, but large samples otherwise than small ones. A mount carries all axes, so that all
    must change.
    """

    parameters = RattlingMountParameters
    fewest_samples, fault = 2000, "mount that rattles"

    def __init__(self, parameters: RattlingMountParameters) -> None:
        super().__init__(parameters)
        self._earlier: deque[Floats] = deque(maxlen=REMEMBERED)
        self._latest: deque[Floats] = deque(maxlen=LATEST)

    def restart(self) -> None:
        """Discard earlier hops."""
        self._earlier.clear()
        self._latest.clear()

    def flaw(self, evidence: SampleEvidence) -> str:
        present = asymmetry(evidence.acceleration)
        if self._latest and self._latest[0].shape != present.shape:  # an axis has been added or removed
            self.restart()
        if len(self._latest) == LATEST and self._change() < self.p.rattle_change:
            self._earlier.append(self._latest[0])
        self._latest.append(present)
        change = self._change()
        if change < self.p.rattle_change:
            return ""
        return f"the asymmetry of large and small samples has changed by {change:.2f} in all axes: the mount of the sensor is loose"

    def _change(self) -> float:
        """Return the least change of the asymmetry among small and large samples of all axes; 0 if those of an axis are not alike [-]."""
        if len(self._latest) < LATEST or len(self._earlier) < FEWEST:
            return 0.0
        changes = np.median(self._latest, axis=0) - np.median(self._earlier, axis=0)
        sizes = np.abs(changes)
        same_sign = (changes > 0.0).all(axis=0) | (changes < 0.0).all(axis=0)
        alike = same_sign & (sizes.max(axis=0) <= ALIKE * sizes.min(axis=0))
        return float(sizes.min()) if alike.all() else 0.0


def asymmetry(samples: Floats) -> Floats:
    """Return (q_high + q_low - 2 median) / (q_high - q_low) of ``samples`` of shape (samples, axes), shape (shares, axes) [-].

    It is Kelly's measure of skewness for a share of 0.1, and Bowley's for 0.25; 0 without a spread.
    """
    beyond, columns = np.array(SHARES), np.ascontiguousarray(samples.T)
    low, high = np.quantile(columns, [beyond, 1.0 - beyond], axis=-1)
    spread = high - low
    skewness = np.divide(high + low - 2.0 * medians(columns), spread, out=np.zeros_like(spread), where=spread > 0.0)
    return np.asarray(skewness, np.float64)
