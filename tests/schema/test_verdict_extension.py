"""The page on adding a verdict, followed literally."""

from __future__ import annotations

import json
import re

import pytest
import yaml
from how_to import ROOT, copied_package, effort, run

PAGE = ROOT / "docs/how-to/add-a-verdict.md"
EXAM = re.compile(r'^```yaml title="my_exam.yaml"\n(.*?)^```$', re.MULTILINE | re.DOTALL)

SCORE = """
import json
from pathlib import Path
from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.figure import write_figure
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.verdicts import title_of

exam = read_exam("my_exam.yaml")
results = []
for case in exam.cases:
    expected = case.expectation
    verdicts = ["healthy" if not expected.faulty or time < expected.onset + 3.0 else "seal" for time in range(1, 31)]
    diagnoses = [ReceivedDiagnosis(float(time), verdict, float(verdict == "seal")) for time, verdict in enumerate(verdicts, 1)]
    results.append(score_scenario(expected, diagnoses, exam.criteria))
report = Report(exam.name, "seals", exam.criteria, "", tuple(results))
write_figure(report, Path("report.svg"))
print(json.dumps({
    "passed": report.passed,
    "limit": exam.criteria.delay.of("seal"),
    "delays": [(delay.verdict, delay.median) for delay in report.delays()],
    "title": title_of("seal", {}),
    "colour": "#00798c" in Path("report.svg").read_text(),
}))
"""


def test_a_verdict_is_one_line() -> None:
    assert effort(PAGE) == (0, 1)


@pytest.mark.slow
def test_the_new_verdict_is_scored_and_drawn(tmp_path_factory: pytest.TempPathFactory) -> None:
    environment = copied_package(folder := tmp_path_factory.mktemp("package"), PAGE)
    (text,) = EXAM.findall(PAGE.read_text(encoding="utf-8"))
    (folder / "my_exam.yaml").write_text(text, encoding="utf-8")
    assert yaml.safe_load(text)["scenarios"][0]["verdict"] == "seal"
    about = json.loads(run(environment, SCORE))
    assert about == {"passed": True, "limit": 20.0, "delays": [["seal", 3.0]], "title": "rubbing seal", "colour": True}
