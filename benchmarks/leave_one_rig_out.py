"""How far the rules for the bearing carry over to a rig that has set none of their thresholds.

``python benchmarks/leave_one_rig_out.py MEASURED RECORDINGS`` prints a table in Markdown. Rigs are those of the folder of
measured recordings, the healthy double-row roller bearings in its folder ``ims`` (every fifth snapshot, both axes together and each
alone), and a simulated one: the axle box, from the folder of recordings of the exam ``standard`` (the last 4 s of each healthy or damaged
bearing). It contributes the faults of rolling elements and cages that no other rig has.

The threshold of each rule is chosen on a grid by the share of its fault that it names less the share of other signals that it calls so,
each a mean over rigs; of equal thresholds the one in the middle is taken. A row has the right verdicts with the shipped thresholds, with
those chosen on all rigs, and with those chosen without the rig of the row. Which lines a rule looks at has seen all rigs.
"""

from __future__ import annotations

import argparse
import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.combination import Combination
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.evidence import Evidence
from dcrb_ros.diagnosis.hysteresis import Hysteresis, least_evidence
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.registry import BEARING_RULES
from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.measured import LONGEST, read_measured
from dcrb_ros.exam.recording_cache import cached_recording
from dcrb_ros.recordings.reader import Recording as FileRecording
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.text.markdown import table

THRESHOLDS = {"outer_ring": "outer_depth", "inner_ring": "inner_depth", "roller": "roller_depth", "cage": "cage_scatter"}
"""Threshold of each rule that is chosen."""
FACTORS = tuple(2.0 ** (k / 2.0) for k in range(-4, 5))
"""Thresholds that are tried, relative to the shipped one."""
IMS = Orders(ftf=0.443, bpfo=7.09, bpfi=8.91, bsf=4.20)
IMS_RATE, IMS_SPEED, GRAVITY = 20000, 2000.0 / 60.0, 9.80665
EVERY = 5
"""Snapshots of which one is taken."""
SECONDS = 4.0
"""Length of a simulated signal."""
CLASSES = ("twin", "outer", "inner", "roller", "cage")
"""Names of the scenarios of the exam that are evaluated."""


class Recording(NamedTuple):
    """A signal with known truth."""

    rig: str
    truth: str
    acceleration: Floats
    """Shape (samples, axes) [m/s^2]."""
    rate: int
    angle: Floats
    """Shape (samples,) [rad]."""
    orders: Orders


class Kept:
    """Keeps the evidence of a judgement, in the place of a learner of a baseline."""

    evidence: Evidence | None = None

    def add(self, evidence: Evidence, *_: object) -> None:
        """Keep the evidence."""
        self.evidence = evidence


def measured(folder: Path) -> Iterator[Recording]:
    """Yield the measured recordings and the healthy snapshots."""
    for one in read_measured(folder):
        rig, values = re.sub(r"\d.*", "", one.rig), one.longest_part(LONGEST)
        angle = turning(len(values), one.rate, one.speed)
        yield Recording(rig, one.truth, np.column_stack([values, values]), one.rate, angle, one.orders)
    for file in sorted((folder / "ims").glob("*.npz")):
        with np.load(file) as arrays:
            snapshots = GRAVITY * arrays["a"].astype(np.float64)
        for snapshot in snapshots[::EVERY]:
            for axes in ((0, 1), (0, 0), (1, 1)):
                angle = turning(snapshot.shape[1], IMS_RATE, IMS_SPEED)
                yield Recording("ims", "healthy", snapshot[list(axes)].T, IMS_RATE, angle, IMS)


def recorded(folder: Path) -> Iterator[Recording]:
    """Yield the last 4 s of the recordings of the exam ``standard``, healthy or with a fault of the bearing; missing ones are simulated."""
    for case in read_exam("standard").cases:
        if case.expectation.name.partition("/")[0] not in CLASSES:
            continue
        recording = FileRecording(cached_recording(case, folder))
        pieces, samples = list(recording.pieces()), round(SECONDS * recording.sampling_rate)
        acceleration = np.concatenate([piece.acceleration for piece in pieces])[-samples:]
        angle = np.concatenate([piece.shaft_angle for piece in pieces])[-samples:]
        yield Recording("simulated box", case.expectation.verdict, acceleration, recording.sampling_rate, angle, recording.orders)


def turning(samples: int, rate: int, frequency: float) -> Floats:
    """Return the angle of a shaft that turns evenly, shape (samples,) [rad]."""
    return np.asarray(np.mod(2.0 * math.pi * frequency / rate * np.arange(samples), 2.0 * math.pi), np.float64)


def evidence_of(recording: Recording) -> Evidence | None:
    """Return the evidence of a recording that is judged once, as a whole."""
    seconds = len(recording.acceleration) / recording.rate
    once = DetectorParameters(window=seconds, hop=seconds, least_window=0.5, confirm=1, least_turns=4.0)
    detector, kept = FaultDetector(recording.orders, recording.rate, once), Kept()
    detector.learner = kept  # type: ignore[assignment]
    detector.update(0, recording.acceleration, recording.angle)
    return kept.evidence


def verdict(recording: Recording, evidence: Evidence | None, parameters: DetectorParameters) -> str:
    """Return the verdict of the rules with given parameters."""
    if evidence is None:
        return "waiting"
    rules = [rule(parameters) for rule in BEARING_RULES]
    findings = Combination(rules, parameters.release_margin).findings(evidence)
    least = least_evidence(1, len(recording.acceleration) / recording.rate, parameters.alarm_evidence)
    required = {rule.component: max(least, rule.healthy_evidence(recording.orders)) for rule in rules}
    hysteresis = Hysteresis(1, parameters.release, parameters.release_margin)
    return hysteresis.verdict({component: finding.excess for component, finding in findings.items()}, required)


Judged = tuple[Recording, Mapping[tuple[str, float], str]]
"""A recording and its verdicts, by the fault whose threshold is changed and by the factor of the threshold."""


def chosen(judged: Sequence[Judged]) -> DetectorParameters:
    """Return the parameters that fit the verdicts on some rigs best."""
    shipped, changes = DetectorParameters(), {}
    for fault, name in THRESHOLDS.items():
        gains = [gain(judged, fault, factor) for factor in FACTORS]
        best = [factor for factor, value in zip(FACTORS, gains, strict=True) if value > max(gains) - 1e-9]
        changes[name] = getattr(shipped, name) * best[len(best) // 2]
    return shipped.model_copy(update=changes)


def gain(judged: Iterable[Judged], fault: str, factor: float) -> float:
    """Return the share of a fault that is named less the share of other signals with that name, means over rigs."""
    named = pd.Series({(one.truth == fault, one.rig, k): verdicts[fault, factor] == fault for k, (one, verdicts) in enumerate(judged)})
    shares = named.groupby(level=[0, 1]).mean().groupby(level=0).mean()
    return float(shares.get(True, 0.0) - shares.get(False, 0.0))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("measured", type=Path)
    parser.add_argument("recordings", type=Path)
    options = parser.parse_args()
    np.seterr(all="ignore")
    recordings = [*measured(options.measured), *recorded(options.recordings)]
    shipped = DetectorParameters()
    evidence = [evidence_of(recording) for recording in recordings]
    judged: list[Judged] = []
    for recording, found in zip(recordings, evidence, strict=True):
        verdicts = {
            (fault, factor): verdict(recording, found, shipped.model_copy(update={name: factor * getattr(shipped, name)}))
            for fault, name in THRESHOLDS.items()
            for factor in FACTORS
        }
        judged.append((recording, verdicts))
    rigs = list(dict.fromkeys(recording.rig for recording in recordings))
    everywhere = chosen(judged)
    without = {rig: chosen([one for one in judged if one[0].rig != rig]) for rig in rigs}
    counts: dict[tuple[str, str], list[int]] = defaultdict(lambda: [0, 0, 0, 0])
    for recording, found in zip(recordings, evidence, strict=True):
        row = counts[recording.rig, recording.truth]
        row[0] += 1
        for column, parameters in enumerate((shipped, everywhere, without[recording.rig]), 1):
            row[column] += verdict(recording, found, parameters) == recording.truth
    heads = ("rig", "truth", "signals", "shipped", "chosen on all rigs", "chosen on the other rigs")
    print(table(heads, ((rig, truth.replace("_", " "), *row) for (rig, truth), row in counts.items())))
    sets = {"shipped": shipped, "on all rigs": everywhere, **{f"without {rig}": without[rig] for rig in rigs}}
    values = ((name, *(f"{getattr(parameters, key):.2f}" for key in THRESHOLDS.values())) for name, parameters in sets.items())
    print("", table(("chosen", *THRESHOLDS.values()), values), sep="\n")


if __name__ == "__main__":
    main()
