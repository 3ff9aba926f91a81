"""The report as JUnit XML, the format that continuous integration services display."""

from __future__ import annotations

import re
from pathlib import Path

from junitparser import Failure, JUnitXml, Skipped, TestCase, TestSuite

from dcrb_ros.exam.report import Report
from dcrb_ros.runtime.version import __version__
from dcrb_ros.text.writing import whole_file

INVALID_IN_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""Characters that XML does not allow, such as the escape character of terminal colours and bytes of a name that are no UTF-8."""


def write_junit(report: Report, file: Path) -> None:
    """Write a test suite of the criteria and one of the scenarios; flaws that the criteria tolerate are skipped instead of failed.

    Raises:
        Refusal: the file cannot be written.
    """
    document = JUnitXml("dcrb score")
    document.add_testsuite(_criteria(report))
    document.add_testsuite(_scenarios(report))
    with whole_file(file) as temporary:
        document.write(str(temporary), pretty=True)


def _criteria(report: Report) -> TestSuite:
    exam = _valid(report.exam)
    suite = TestSuite(f"{exam}: criteria")
    for key, value in (("detector", _valid(report.detector)), ("scenarios_sha256", report.scenarios), ("dcrb_ros", __version__)):
        suite.add_property(key, value)
    for score in report.exam_scores():
        suite.add_property(f"exam_score_{score.profile}", f"{score.score.value:.2f}")
    for check in report.checks():
        case = TestCase(check.name, f"{exam}.criteria")
        if not check.holds:
            case.result = [Failure(f"required {check.wanted}, got {check.got}")]
        suite.add_testcase(case)
    return suite


def _scenarios(report: Report) -> TestSuite:
    exam = _valid(report.exam)
    suite = TestSuite(f"{exam}: scenarios")
    detected, quiet, _ = (check.holds for check in report.checks())
    for result in report.results:
        case = TestCase(_valid(result.expectation.name), f"{exam}.{result.expectation.verdict}", result.delay or 0.0)
        if not result.passed:
            flaw, missed = _valid(result.flaw), result.expectation.faulty and result.expectation.required and not result.found
            tolerated = not result.broken and (quiet or not result.false_alarms) and (detected or not missed)
            reason = "not required" if result.excused else "tolerated by the criteria"
            case.result = [Skipped(f"{reason}: {flaw}") if tolerated else Failure(flaw)]
        suite.add_testcase(case)
    return suite


def _valid(text: str) -> str:
    """Return a user's text with invalid characters replaced by question marks."""
    return INVALID_IN_XML.sub("?", text)
