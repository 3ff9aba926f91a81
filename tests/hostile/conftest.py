"""The number of random hostile inputs of each kind, and what is printed while they are run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import pytest

COUNTS: Counter[str] = Counter()


@pytest.fixture
def tally() -> Counter[str]:
    """Return the number of inputs of each kind that were run so far, to be increased by the tests."""
    return COUNTS


@pytest.fixture
def say(pytestconfig: pytest.Config) -> Callable[[str], None]:
    """Return a function that prints a line at once: a run that is stopped has then said what it found."""
    capture = pytestconfig.pluginmanager.get_plugin("capturemanager")

    def line(text: str) -> None:
        with capture.global_and_fixture_disabled():  # type: ignore[union-attr]
            print(f"\n{text}", end="", flush=True)

    return line


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the numbers."""
    if COUNTS:
        terminalreporter.section("random hostile inputs")
        for kind, count in COUNTS.most_common():
            terminalreporter.line(f"{count:8d}  {kind}")
        terminalreporter.line(f"{COUNTS.total():8d}  in total")
