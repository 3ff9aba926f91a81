"""Termination signals in every phase of a process: its start, its work and its end."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals that a process sends itself")

PATIENCE = 400.0
PRELUDE = """
import atexit, os, signal, sys, threading
from dcrb_ros.runtime import signals

def send(number=signal.SIGINT):
    os.kill(os.getpid(), number)
"""


def run(code: str) -> tuple[int, str]:
    """Run a program in a process; return its exit status and what it printed."""
    done = subprocess.run(
        [sys.executable, "-c", PRELUDE + code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=PATIENCE, check=False
    )
    return done.returncode, done.stdout


@pytest.mark.parametrize("kind", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_during_the_start_ends_the_process_at_once(kind: str) -> None:
    # As a process that was started with the signal ignored (nohup) would leave it ignored.
    heeded = f"signal.signal(signal.{kind}, signal.SIG_DFL)"
    code = f"{heeded}; signals.end_at_once(7, 'program: stopped'); send(signal.{kind}); print('not reached')"
    assert run(code) == (7, "program: stopped\n")


def test_a_signal_that_was_ignored_from_the_start_stays_ignored() -> None:
    code = "signal.signal(signal.SIGHUP, signal.SIG_IGN); signals.end_at_once(7); send(signal.SIGHUP); print('reached')"
    assert run(code) == (0, "reached\n")


def test_a_node_in_the_background_heeds_ctrl_c_but_not_the_end_of_its_terminal_under_nohup() -> None:
    code = """
for number in signals.TERMINATION:
    signal.signal(number, signal.SIG_IGN)
signals.restore_ignored_signals()
signals.end_at_once(7)
send(signal.SIGHUP)
print("reached", flush=True)
send(signal.SIGINT)
print("not reached")
"""
    assert run(code) == (7, "reached\n")


def test_an_interrupt_during_an_import_is_raised_after_it(tmp_path: Path) -> None:
    (tmp_path / "interrupted.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGTERM)\nfor _ in range(1000): pass\n")
    code = f"""
signals.interrupt()
sys.path.insert(0, {str(tmp_path)!r})
import interrupted
print("imported", flush=True)
try:
    threading.Event().wait({PATIENCE})
except KeyboardInterrupt:
    print("interrupted")
"""
    assert run(code) == (0, "imported\ninterrupted\n")


def test_an_interrupt_waits_for_the_end_of_a_step_but_a_second_one_does_not() -> None:
    code = """
signals.interrupt()
for count in (1, 2):
    try:
        with signals.Uninterrupted():
            for _ in range(count):
                send()
            print("step", count)
        print("not reached")
    except KeyboardInterrupt:
        print("stopped")
"""
    assert run(code) == (0, "step 1\nstopped\nstopped\n")


def test_an_interrupt_in_a_destructor_is_not_lost() -> None:
    code = f"""
class Interrupted:
    def __del__(self):
        send()
        for _ in range(1000): pass

signals.interrupt()
try:
    Interrupted()
    threading.Event().wait({PATIENCE})
except KeyboardInterrupt:
    print("interrupted")
"""
    assert run(code) == (0, "interrupted\n")


def test_the_destructor_of_an_object_that_an_interrupt_left_half_made_prints_nothing() -> None:
    code = """
class HalfMade:
    def __init__(self):
        send()
        for _ in range(1000): pass
        self.part = 1
    def __del__(self):
        del self.part

signals.interrupt()
try:
    HalfMade()
except KeyboardInterrupt as interrupt:
    del interrupt
print("stopped")
"""
    assert run(code) == (0, "stopped\n")


def test_other_failures_of_destructors_are_reported() -> None:
    status, printed = run("signals.interrupt()\nclass Failing:\n    def __del__(self): raise ValueError('mine')\nFailing()\n")
    assert (status, "ValueError: mine" in printed) == (0, True)


LAST_STEPS = {
    "before it": "sys.exit = lambda status: (send(KIND), print('not reached'))",
    "at exit": "atexit.register(send, KIND)",
    "while threads end": "threading.Thread(target=lambda: (threading.main_thread().join(), send(KIND))).start()",
    "when modules are cleared": "class Late:\n    def __del__(self): send(KIND)\nkept = Late()",
}


@pytest.mark.parametrize("kind", ["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("step", LAST_STEPS.values(), ids=LAST_STEPS.keys())
def test_a_second_signal_does_not_change_the_exit(step: str, kind: str) -> None:
    assert run(f"KIND = signal.{kind}\n{step}\nprint('said', end='')\nsignals.leave(3)\n") == (3, "said")


def test_a_node_flushes_its_output_and_ignores_further_signals() -> None:
    code = """
class Interrupted:
    def flush(self):
        for number in signals.TERMINATION:
            send(number)

print("said", end="")
sys.stderr = Interrupted()
signals.leave_at_once(0)
"""
    assert run(code) == (0, "said")


def test_blocked_signals_are_delivered_once_they_are_handled() -> None:
    code = """
signal.pthread_sigmask(signal.SIG_BLOCK, signals.TERMINATION)
send()
signals.end_at_once(7)
print("started", flush=True)
signals.accept_termination()
print("not reached")
"""
    assert run(code) == (7, "started\n")


def test_the_command_is_stopped_during_its_imports() -> None:
    code = """
class Interrupting:
    def find_spec(self, name, *rest):
        if name == "dcrb_ros.cli.app":
            send()

sys.meta_path.insert(0, Interrupting())
from dcrb_ros.cli.program import main
main()
"""
    assert run(code) == (130, "dcrb: stopped\n")


@pytest.mark.parametrize("signals_sent", [1, 2])
def test_the_command_reports_an_interrupt_in_one_line(signals_sent: int) -> None:
    code = f"""
from dcrb_ros.cli import app
from dcrb_ros.runtime import exit_status

said = exit_status.print_error
def report(*words):
    said(*words)
    if {signals_sent} == 2:
        send()

def work(**options):
    send()
    threading.Event().wait({PATIENCE})

exit_status.print_error = report
app.app = work
from dcrb_ros.cli.program import main
main()
"""
    assert run(code) == (130, "dcrb: stopped\n")


def test_the_installed_command_handles_signals_first() -> None:
    assert '"dcrb = dcrb_ros.cli.program:main"' in (Path(__file__).parents[2] / "setup.py").read_text()
