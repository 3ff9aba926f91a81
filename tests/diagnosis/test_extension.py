"""The page on adding a detector rule, followed literally."""

from __future__ import annotations

import json

import pytest
from how_to import ROOT, copied_package, effort, run

PAGE = ROOT / "docs/how-to/add-a-detector-rule.md"

DIAGNOSE = f"""
import json, sys
sys.path.insert(0, {str(ROOT / "tests" / "support")!r})
import numpy as np
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from synthetic_bearing import ORDERS, RATE, bursts, synthetic, diagnoses

def diagnosis(amplitude, **parameters):
    acceleration, angle = synthetic()
    turns = 20.0 * np.arange(len(angle)) / RATE
    acceleration += bursts(turns, 1.0 - ORDERS.ftf, amplitude)[:, None].astype(np.float32)
    found = diagnoses(FaultDetector(ORDERS, RATE, DetectorParameters(**parameters)), (acceleration, angle))[-1]
    return found.verdict, found.reason, found.scores["cage"]

print(json.dumps({{
    "rubbing": diagnosis(300.0),
    "tolerated": diagnosis(300.0, rub_depth=2.0),
    "healthy": diagnosis(0.0),
}}))
"""


def test_a_rule_is_one_file_and_one_line() -> None:
    assert effort(PAGE) == (1, 1)


@pytest.mark.slow
def test_the_new_rule_reaches_a_verdict(tmp_path_factory: pytest.TempPathFactory) -> None:
    found = json.loads(run(copied_package(tmp_path_factory.mktemp("package"), PAGE), DIAGNOSE))
    verdict, reason, score = found["rubbing"]
    assert verdict == "cage"
    assert "a rubbing cage at 0.5" in reason
    assert score > 0.0
    assert found["healthy"][0] == "healthy"
    assert "rubbing" not in found["tolerated"][1]
