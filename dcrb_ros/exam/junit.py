"""The report as JUnit XML, which every continuous integration shows."""

from __future__ import annotations

import re
from pathlib import Path

from junitparser import Failure, JUnitXml, Skipped, TestCase, TestSuite

from dcrb_ros import __version__
from dcrb_ros.exam.report import Report
from dcrb_ros.runtime.refusal import Refusal

UNSPEAKABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
"""Characters that XML cannot hold, such as a terminal's colours."""


def write_junit(report: Report, file: Path) -> None:
    """Write a suite of the criteria and one of the scenarios; a scenario that is not required never fails.

    Raises:
        Refusal: the file cannot be written.
    """
    document = JUnitXml("dcrb score")
    document.add_testsuite(_criteria(report))
    document.add_testsuite(_scenarios(report))
    try:
        document.write(str(file), pretty=True)
    except OSError as error:
        raise Refusal(f"{file} cannot be written: {error.strerror}; give another file to --junit") from None


def _criteria(report: Report) -> TestSuite:
    exam = _spoken(report.exam)
    suite = TestSuite(f"{exam}: criteria")
    for key, value in (("detector", _spoken(report.detector)), ("scenarios_sha256", report.scenarios), ("dcrb_ros", __version__)):
        suite.add_property(key, value)
    for check in report.checks():
        case = TestCase(check.name, f"{exam}.criteria")
        if not check.holds:
            case.result = [Failure(f"wanted {check.wanted}, got {check.got}")]
        suite.add_testcase(case)
    return suite


def _scenarios(report: Report) -> TestSuite:
    exam = _spoken(report.exam)
    suite = TestSuite(f"{exam}: scenarios")
    for mark in report.marks:
        case = TestCase(_spoken(mark.question.name), f"{exam}.{mark.question.verdict}", mark.delay or 0.0)
        if not mark.passed:
            flaw = _spoken(mark.flaw)
            case.result = [Failure(flaw) if mark.question.required else Skipped(f"not required: {flaw}")]
        suite.add_testcase(case)
    return suite


def _spoken(text: str) -> str:
    """Return a text that users gave without what XML cannot hold."""
    return UNSPEAKABLE.sub("?", text)
