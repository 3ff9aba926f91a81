"""Reserved ROS domains: every exam has its own."""

from __future__ import annotations

import secrets
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from dcrb_ros.nodes import reserved_domain
from dcrb_ros.nodes.reserved_domain import DOMAINS, FIRST_DOMAIN, ReservedDomain
from dcrb_ros.schema.refusal import Refusal

RESERVING = """
import os, sys
os.getpid = lambda: {pid}
from dcrb_ros.nodes import reserved_domain
from dcrb_ros.nodes.reserved_domain import ReservedDomain
reserved_domain.FIRST_PORT = {first_port}
reserved = ReservedDomain()
print(reserved.number, flush=True)
sys.stdin.read()
"""


@pytest.fixture
def first_port(monkeypatch: pytest.MonkeyPatch) -> int:
    """Reserve domains by ports that no exam on this machine uses, and hardly another run of these tests."""
    number = 21_000 + 240 * secrets.randbelow(45)
    monkeypatch.setattr(reserved_domain, "FIRST_PORT", number)
    return number


@contextmanager
def reserving(pid: int) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Run a process that believes to have a number ``pid``, as in another container, and yield it with its domain."""
    command = [sys.executable, "-c", RESERVING.format(pid=pid, first_port=reserved_domain.FIRST_PORT)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process, int(process.stdout.readline())
        finally:
            process.kill()


@pytest.mark.usefixtures("first_port")
def test_processes_of_the_same_number_have_different_domains() -> None:
    with reserving(7) as (_, first), reserving(7) as (_, second), reserving(7 + DOMAINS) as (_, third):
        assert len({first, second, third}) == 3
        assert all(FIRST_DOMAIN <= number < FIRST_DOMAIN + DOMAINS for number in (first, second, third))


@pytest.mark.usefixtures("first_port")
def test_a_killed_process_frees_its_domain() -> None:
    with reserving(7) as (process, first):
        process.send_signal(signal.SIGKILL)
        process.wait(60.0)
        with reserving(7) as (_, again):
            assert again == first


@pytest.mark.usefixtures("first_port")
def test_domains_run_out_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reserved_domain, "DOMAINS", 2)
    held = [ReservedDomain(), ReservedDomain()]
    assert len({domain.number for domain in held}) == 2
    with pytest.raises(Refusal, match=r"the ROS domains 110 \.\. 111 are all reserved by exams on this machine"):
        ReservedDomain()
    number = held.pop(0).number
    assert ReservedDomain().number == number
