"""The command line lets the linear algebra libraries use one thread, unless the environment says otherwise."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

PROGRAM = """
import os
from dcrb_ros.runtime.linear_algebra import one_thread_each
one_thread_each()
print(os.environ["OPENBLAS_NUM_THREADS"])
"""


@pytest.mark.parametrize(("given", "used"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_one_thread_unless_the_environment_says_otherwise(given: dict[str, str], used: str) -> None:
    bare = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True, timeout=400, env={**bare, **given})
    assert done.stdout.strip() == used


def test_the_modules_before_it_do_not_import_numpy() -> None:
    imported = "import sys, dcrb_ros.cli.program; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", imported], capture_output=True, text=True, check=True, timeout=400)
    assert done.stdout.strip() == "False"
