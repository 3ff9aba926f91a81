"""Only tests whose process crashed are run again (`make nodes`)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from crashed_workers import CRASHED

pytest.importorskip("xdist")
SUPPORT = Path(__file__).parents[1] / "support"
CRASH, FAIL, PASS = "import os; os._exit(139)", "assert False", "pass"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bodies", "status"),
    [((PASS,), 0), ((FAIL, PASS), 1), ((CRASH, PASS), CRASHED), ((CRASH, FAIL, PASS), 1)],
)
def test_crashes_have_an_exit_status_of_their_own(bodies: tuple[str, ...], status: int, tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("".join(f"def test_{number}(): {body}\n" for number, body in enumerate(bodies)))
    workers = ("-p", "xdist", "-n", "1", "-p", "crashed_workers")
    command = [sys.executable, "-m", "pytest", "-q", *workers, "-c", os.devnull, "--rootdir", ".", "test_it.py"]
    # Other plugins take longer to load than these tests to run.
    environment = {**os.environ, "PYTHONPATH": str(SUPPORT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == status, ended.stdout
