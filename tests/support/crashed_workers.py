"""A pytest plugin (`-p crashed_workers`) that tells tests whose process crashed from tests that failed.

If nothing but crashes went wrong, the exit status is `CRASHED`; pytest-xdist reports a crash as the failure of the test that was running.
"""

from __future__ import annotations

import pytest

CRASHED = 9
"""Exit status of a session in which processes crashed and no test failed."""
_failed, _crashed = set[str](), set[str]()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note a failure; a crashed process reports no phase of its test."""
    if report.failed:
        (_crashed if report.when not in ("setup", "call", "teardown") else _failed).add(report.nodeid)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Set the exit status."""
    if _crashed and not _failed and session.exitstatus == pytest.ExitCode.TESTS_FAILED:
        session.exitstatus = CRASHED
