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


@pytest.mark.parametrize(
    ("bodies", "status"),
    [((PASS,), 0), ((FAIL, PASS), 1), ((CRASH, PASS), CRASHED), ((CRASH, FAIL, PASS), 1)],
)
def test_crashes_have_an_exit_status_of_their_own(bodies: tuple[str, ...], status: int, tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text("".join(f"def test_{number}(): {body}\n" for number, body in enumerate(bodies)))
    command = [sys.executable, "-m", "pytest", "-q", "-n", "1", "-p", "crashed_workers", "-c", os.devnull, "--rootdir", ".", "test_it.py"]
    ended = subprocess.run(
        command, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(SUPPORT)}, capture_output=True, text=True, check=False
    )
    assert ended.returncode == status, ended.stdout
