"""A dead sensor: its signal drifts, but does not vibrate."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.fields import Group, quantity


class SilenceParameters(Group):
    """Slowest vibration."""

    silence: float = quantity(
        5.0, "Hz", "RMS frequency of a signal below which it drifts but does not vibrate; a turning bearing has hundreds", 0.0, 1e4
    )


class Silence(SampleRule[SilenceParameters]):
    """The RMS frequency, from the power of the differences between samples over that of the samples, which no gain changes."""

    parameters = SilenceParameters

    def flaw(self, evidence: SampleEvidence) -> str:
        for axis, column in evidence.axes:
            centred = column - column.mean()
            differences, power = float(np.mean(np.square(np.diff(centred)))), float(np.mean(np.square(centred)))
            frequency = math.sqrt(differences / power) * evidence.rate / (2.0 * math.pi) if power > 0.0 else 0.0
            if frequency < self.p.silence:
                return f"the acceleration in {axis} drifts but does not vibrate: the sensor is dead"
        return ""
