"""The command line in a process of its own."""

from __future__ import annotations

import subprocess
import sys


def dcrb(*arguments: str, timeout: float = 200.0) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)
