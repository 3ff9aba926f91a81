"""Child processes that end with the one that started them."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import PATIENCE, runs, wait_for

pytestmark = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="the states of processes are read from /proc")

CHILD = """
import threading
from dcrb_ros.runtime.children import end_with_parent
from dcrb_ros.runtime.signals import end_at_once
end_at_once(7, "ended")
print("started", flush=True)
end_with_parent()
threading.Event().wait(1000.0)
"""
PARENT = """
import subprocess, sys, threading
from dcrb_ros.runtime.children import signals_blocked
with signals_blocked():
    child = subprocess.Popen([sys.executable, "-c", {child!r}], stdin=subprocess.PIPE)
print(child.pid, flush=True)
threading.Event().wait(1000.0)
"""
POOL = """
import os, threading
from dcrb_ros.runtime.processes import in_processes

if __name__ == "__main__":
    jobs = in_processes({"first": os.getpid, "second": os.getpid}, 1)
    print(next(jobs)[1], flush=True)
    threading.Event().wait(1000.0)
"""
STOPPED_POOL = """
import multiprocessing, os, signal, sys, time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from dcrb_ros.runtime.processes import in_processes

workers = []

def submit(pool, call, submit=ProcessPoolExecutor.submit):
    future = submit(pool, call)
    workers.extend(worker.pid for worker in multiprocessing.active_children())
    os.kill(os.getpid(), signal.SIGINT)
    return future

if __name__ == "__main__":
    ProcessPoolExecutor.submit = submit
    try:
        next(in_processes({number: partial(time.sleep, 1000.0) for number in range(2)}, 2))
    except KeyboardInterrupt:
        sys.exit(1 if not workers or any(Path("/proc", str(worker)).exists() for worker in workers) else 7)
"""


def test_a_pool_that_is_stopped_while_its_workers_start_ends_at_once(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(STOPPED_POOL)
    done = subprocess.run([sys.executable, str(tmp_path / "program.py")], timeout=PATIENCE, check=False)
    assert done.returncode == 7


def test_a_child_ends_like_after_sigterm_when_its_standard_input_is_closed() -> None:
    with subprocess.Popen([sys.executable, "-c", CHILD], stdin=subprocess.PIPE, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as child:
        _, words = child.communicate(timeout=PATIENCE)
    assert (child.returncode, words) == (7, b"ended\n")


@pytest.mark.parametrize("code", [PARENT.format(child=CHILD), POOL], ids=["a child", "a worker"])
def test_no_child_outlives_a_killed_parent(code: str, tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(code)
    with subprocess.Popen([sys.executable, str(program)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        assert runs(child)
        parent.send_signal(signal.SIGKILL)
        parent.wait(PATIENCE)
    wait_for(lambda: not runs(child))
