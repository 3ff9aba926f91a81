"""The number of random hostile inputs of each kind, which the end of a run prints."""

from __future__ import annotations

from collections import Counter

import pytest

COUNTS: Counter[str] = Counter()


@pytest.fixture
def tally() -> Counter[str]:
    """Return the number of inputs of each kind that were run so far, to be increased by the tests."""
    return COUNTS


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the numbers."""
    if COUNTS:
        terminalreporter.section("random hostile inputs")
        for kind, count in COUNTS.most_common():
            terminalreporter.line(f"{count:8d}  {kind}")
        terminalreporter.line(f"{COUNTS.total():8d}  in total")
