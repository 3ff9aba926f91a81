"""A dead sensor: no power in any band."""

from __future__ import annotations

from dcrb_ros.diagnosis.evidence import LevelEvidence
from dcrb_ros.diagnosis.rule import LevelRule
from dcrb_ros.schema.fields import Group, quantity


class SilenceParameters(Group):
    """Least level of a turning bearing."""

    silence: float = quantity(
        1e-3, "m/s^2", "RMS at 20 Hz that at least one band of a working sensor has; the quietest healthy bearing has 0.2", 0.0, 10.0
    )


class Silence(LevelRule[SilenceParameters]):
    """The largest power of all bands."""

    parameters = SilenceParameters

    def flaw(self, evidence: LevelEvidence) -> str:
        # The mean squared envelope is twice the power.
        if not 0.0 < float(evidence.powers.max()) < 2.0 * self.p.silence**2:
            return ""
        return f"no band has more than {self.p.silence:g} m/s^2: the sensor is dead, or the signal is below its resolution"
