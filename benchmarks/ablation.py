"""The contribution of each rule of the detector: the results with one rule off at a time, as a table in Markdown.

``python benchmarks/ablation.py MEASURED [RECORDINGS]`` evaluates the folder of measured recordings, 21 machines of the independent
generator without and with a fault, and, if the folder of recordings of the exam ``standard`` is given, its healthy scenarios and its
defects of 1 and 2 mm. Recordings that are missing, or were made by another model, are simulated.
"""

from __future__ import annotations

import argparse
import functools
import math
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))

from jittered_impacts import Machine  # type: ignore[import-not-found]

from dcrb_ros.diagnosis.hysteresis import Hysteresis
from dcrb_ros.diagnosis.line_search import GUARD, LineSearch
from dcrb_ros.diagnosis.order_spectrum import decibels, ratio
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rules.roller import Roller
from dcrb_ros.exam.detector_run import shipped_detector
from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.measured import diagnose_as_a_whole, read_measured
from dcrb_ros.exam.recording_cache import cached_recording
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.recordings.reader import Recording

DIAGNOSIS = "dcrb_ros.diagnosis"
FAULTS = ("outer_ring", "inner_ring", "roller")


def rows() -> Iterator[tuple[str, dict[str, Any], list[Any]]]:
    """Yield name, changed parameters and patches of each row."""
    depths = ("outer_depth", "inner_depth", "roller_depth", "cage_depth")
    shaft = functools.cached_property(lambda search: np.where(search.orders <= GUARD * search.step, np.float32(0.0), np.float32(1.0)))
    shaft.__set_name__(LineSearch, "_kept")
    yield "all rules", {}, []
    yield "search of 0.4 % instead of 2 %", {"slip": 0.004}, []
    yield "whole band only", {"band": "fixed"}, []
    yield "depth of 0.34 instead of 0.17", dict.fromkeys(depths, 0.34), []
    yield "depth of 0.05", dict.fromkeys(depths, 0.05), []
    yield (
        "no significance",
        {},
        [patch(f"{DIAGNOSIS}.rule.modulation_excess", lambda lines, least, *_: decibels(ratio(lines.depth, least)))],
    )
    yield "no joint explanation", {}, [patch(f"{DIAGNOSIS}.combination.explains", lambda *_: False)]
    yield "explained only if left without lines", {"shadow": 0.0}, []
    yield "harmonics of the shaft are evidence", {}, [patch.object(LineSearch, "_kept", shaft)]
    yield "no contrast of BPFO to FTF", {"cage_contrast": 0.0}, []
    yield "no limit of 2 BPFO", {"outer_double": 20.0}, []
    without_clusters = [
        patch(f"{DIAGNOSIS}.rules.cage.clusters_at_spin", lambda *_: (0.0, math.inf)),
        patch(f"{DIAGNOSIS}.rules.cage.spin_of_clusters", lambda *_: (0.0, 1.0)),
    ]
    yield "clusters at 2 BSF are evidence for the cage", {}, without_clusters
    yield "no whitening", {"whitening": 0.0}, []
    yield "quiet bands are evidence", {}, [patch(f"{DIAGNOSIS}.evidence.QUIET", 1000.0)]
    yield (
        "no contrast of a ring to FTF",
        {},
        [patch(f"{DIAGNOSIS}.rules.{ring}.over_the_cage", lambda *_: 1.0) for ring in ("outer_ring", "inner_ring")],
    )
    as_they_should = [
        patch(f"{DIAGNOSIS}.rules.roller.spin_of_clusters", lambda *_: (0.0, 1.0)),
        patch.object(Roller, "_slower", lambda _, found, *__: found),
    ]
    yield "rollers at their kinematic spin only", {}, as_they_should
    yield "a monitored bearing is named at the threshold", {"alarm_evidence": 0.0}, []
    at_once = patch(f"{DIAGNOSIS}.detector.Hysteresis", lambda confirm, release, margin, persist: Hysteresis(confirm, release, margin, 1))
    yield "the same, and weak evidence need not last", {"alarm_evidence": 0.0}, [at_once]


def measured(folder: Path, parameters: DetectorParameters) -> str:
    """Return false alarms, right names of both rings and alarms of ball faults."""
    count: Counter[tuple[str, str]] = Counter()
    for recording in read_measured(folder):
        verdict = diagnose_as_a_whole(recording.samples(), recording.rate, recording.speed, recording.orders, parameters).verdict
        count[recording.truth, "right"] += verdict == recording.truth
        count[recording.truth, "alarm"] += verdict != "healthy"
    return f"{count['healthy', 'alarm']} | {count['outer_ring', 'right']} | {count['inner_ring', 'right']} | {count['roller', 'alarm']}"


def generated(parameters: DetectorParameters) -> str:
    """Return false alarms and right names of 21 machines."""
    alarms = right = 0
    for seed in range(21):
        rate, speed, departure = (12000, 25600)[seed % 2], 15.0 + (7 * seed) % 30, 0.008 * (seed % 5 - 2)
        machine = Machine(seed, balls=7 + seed % 8, ratio=0.15 + 0.02 * (seed % 7), rate=rate, speed=speed, departure=departure)
        fault = FAULTS[seed % 3]
        calm = machine.healthy(2.0, shaft=0.4, gear=0.5)
        signals = calm, calm + 0.5 * machine.impacts(2.0, fault)
        verdicts = [diagnose_as_a_whole(signal, rate, speed, machine.orders, parameters).verdict for signal in signals]
        alarms, right = alarms + (verdicts[0] != "healthy"), right + (verdicts[1] == fault)
    return f"{alarms} | {right}"


def simulated(folder: Path, parameters: DetectorParameters) -> str:
    """Return false alarms in healthy scenarios and right names of defects of 1 and 2 mm in the exam ``standard``."""
    exam = read_exam("standard")
    alarms = right = 0
    for case in exam.cases:
        expected = case.expectation
        if expected.verdict == "healthy" or expected.tags.get("width") in (0.001, 0.002):
            recording = Recording(cached_recording(case, folder))
            result = score_scenario(expected, shipped_detector(parameters).diagnose(recording).received, exam.criteria)
            alarms += len(result.false_alarms)
            right += result.delay is not None
    return f"{alarms} | {right}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("measured", type=Path)
    parser.add_argument("recordings", nargs="?", type=Path)
    parser.add_argument("--only", default="", help="rows whose names contain this")
    options = parser.parse_args()
    np.seterr(all="ignore")
    for name, changes, patches in rows():
        if options.only not in name:
            continue
        parameters = DetectorParameters(**changes)
        with ExitStack() as stack:
            for switch in patches:
                stack.enter_context(switch)
            cells = [measured(options.measured, parameters), generated(parameters)]
            cells += [simulated(options.recordings, parameters)] if options.recordings is not None else []
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
