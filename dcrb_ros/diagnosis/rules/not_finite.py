"""Samples that are not finite numbers."""

from __future__ import annotations

from dcrb_ros.diagnosis.evidence import SampleEvidence
from dcrb_ros.diagnosis.rule import SampleRule
from dcrb_ros.schema.fields import Group, quantity


class NotFiniteParameters(Group):
    """Threshold for samples that are not finite."""

    most_senseless: float = quantity(
        0.01, "-", "Largest share of samples in a hop that are not finite numbers; more indicate a sensor fault", 0.0, 1.0
    )


class NotFinite(SampleRule[NotFiniteParameters]):
    """Counts samples that arrived as infinity or NaN."""

    parameters = NotFiniteParameters
    at_standstill, fewest_samples = True, 0

    def flaw(self, evidence: SampleEvidence) -> str:
        if evidence.not_finite <= self.p.most_senseless * evidence.count:
            return ""
        return f"{evidence.not_finite} of {evidence.count} samples are not finite numbers"
