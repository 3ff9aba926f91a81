"""Worker processes on this machine."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from waiting import runs, wait_for

from dcrb_ros.runtime.processes import available_memory, resident_memory
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import validated
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.run import waveform_of
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.local_workers import LocalWorkers, local_workers, parsed_memory
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.store import PART, Store


@pytest.fixture(scope="module")
def workers() -> Iterator[LocalWorkers]:
    """Two workers for several tests, since each process takes seconds to import the model."""
    with local_workers(2, "auto") as here:
        yield here


LISTENING = {"/proc/net/tcp": ("0A", 3, 9), "/proc/net/tcp6": ("0A", 3, 9), "/proc/net/unix": ("00010000", 3, 6)}
"""Tables of sockets: the state of those that listen, and the columns of state and inode."""


def plan_of(runs: int, duration: float = 0.02) -> Plan:
    vary = {"operating.speed": {"low": 90.0, "high": 160.0}}
    tree = {"set": {"cage.joint": "revolute"}, "design": "random", "points": runs, "vary": vary, "duration": duration}
    return Plan(sweep_of(tree, "sweep.yaml"))


def listening_sockets(processes: list[int]) -> set[str]:
    """Return the inodes of the sockets on which any of the processes accepts connections."""
    own, found = set(), set()
    for link in (link for process in processes for link in Path(f"/proc/{process}/fd").iterdir()):
        with suppress(OSError):  # it was closed meanwhile
            own.add(link.readlink().name)
    for table, (state, column, inode) in LISTENING.items():
        for line in Path(table).read_text().splitlines()[1:]:
            cells = line.split()
            if cells[column] == state and f"socket:[{cells[inode]}]" in own:
                found.add(cells[inode])
    return found


def descendants(process: int) -> list[int]:
    """Return a process and those that it has started."""
    children: list[int] = []
    for task in Path(f"/proc/{process}/task").iterdir():
        with suppress(OSError):  # the thread has ended meanwhile
            children += map(int, (task / "children").read_text().split())
    return [process, *(found for child in children for found in descendants(child))]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="reads the sockets of Linux")
def test_nothing_listens_while_a_sweep_runs(tmp_path: Path, workers: LocalWorkers) -> None:
    before, seen = listening_sockets(descendants(os.getpid())), list[tuple[int, set[str]]]()

    def look(_: Counter[str]) -> None:
        processes = descendants(os.getpid())
        seen.append((len(set(processes) & set(workers.process_ids)), listening_sockets(processes) - before))

    with open_data_set(plan_of(8), Store(str(tmp_path / "set"))) as data_set:
        assert data_set.make(workers, look).statuses == {"done": 8}
    assert max(count for count, _ in seen) == 2
    assert all(found == set() for _, found in seen)


def test_a_listening_socket_would_be_found() -> None:
    import socket

    before = listening_sockets([os.getpid()])
    with socket.create_server(("127.0.0.1", 0)):
        assert len(listening_sockets([os.getpid()]) - before) == 1


@pytest.mark.slow
def test_tasks_of_killed_workers_are_run_again(tmp_path: Path, workers: LocalWorkers) -> None:
    killed: list[int] = []
    with open_data_set(plan_of(24, 0.1), Store(str(tmp_path / "set"))) as data_set:

        def kill(_: Counter[str]) -> None:
            if not killed:
                killed.append(workers.process_ids[0])
                os.kill(killed[0], signal.SIGKILL)
                (tmp_path / "set" / "runs" / f"{PART}of-a-killed-worker").write_bytes(b"half a run")

        tally = data_set.make(workers, kill)
    assert killed
    assert killed[0] not in workers.process_ids
    assert tally.statuses == {"done": 24}
    table = pd.read_parquet(tmp_path / "set" / "labels.parquet")
    assert table["run"].is_unique
    assert {f"runs/{path.name}" for path in (tmp_path / "set" / "runs").iterdir()} == set(table["file"])
    run = next(run for run in data_set.plan.runs() if run.name == table["run"][5])
    configuration = validated({**data_set.plan.sweep.base, **run.changes}, Configuration, "run")
    alone = waveform_of(list(Simulation(configuration, waveform_only=True).blocks(0.1)), configuration)
    assert np.array_equal(np.load(tmp_path / "set" / table["file"][5])["ax"], alone.acceleration[:, 0])


def test_a_task_whose_workers_exceed_their_memory_ends_in_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.sweep.local_workers.parsed_memory", lambda *_: 1_000_000)
    monkeypatch.setattr("dcrb_ros.sweep.local_workers.MOST_ATTEMPTS", 1)
    with local_workers(1, "1MB") as workers, open_data_set(plan_of(1, 600.0), Store(str(tmp_path / "set"))) as data_set:
        tally = data_set.make(workers, lambda _: None)
    assert tally.statuses == {"error": 1}
    assert list(tally.reasons) == ["its worker needed more than 0.001 GB of memory: increase --memory, or shorten the runs"]


@pytest.mark.slow
def test_workers_leave_signals_to_their_parent_and_end_with_it(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from dcrb_ros.sweep import local_workers as here\n"
        "def main():\n"
        "    process = here._Process(None); print(process.id, flush=True); sys.stdin.read()\n"
        "if __name__ == '__main__':\n"
        "    main()\n"
    )
    script = tmp_path / "parent.py"
    script.write_text(code)
    with subprocess.Popen([sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        status = dict(line.split(":", 1) for line in Path(f"/proc/{worker}/status").read_text().splitlines())
        blocked = int(status["SigBlk"], 16)
        assert all(blocked >> (number - 1) & 1 for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
        parent.kill()
    wait_for(lambda: not runs(worker))


def test_the_memory_limit_is_a_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.sweep.local_workers.resident_memory", lambda: 300_000_000)
    assert parsed_memory("2GB", 4) == 2_000_000_000
    assert parsed_memory("1.5 GiB", 4) == 3 * 2**29
    assert parsed_memory("auto", 4) == available_memory() // 4
    for text, sentence in (("much", "--memory much is not a size"), ("-2GB", "is not a size"), ("1MB", "is less than the")):
        with pytest.raises(Refusal, match=sentence):
            parsed_memory(text, 1)


def test_a_memory_limit_needs_a_system_that_tells_the_memory_of_a_process(monkeypatch: pytest.MonkeyPatch) -> None:
    assert (resident_memory() or 0) > 10_000_000
    monkeypatch.setattr("dcrb_ros.sweep.local_workers.resident_memory", lambda: None)
    assert parsed_memory("auto", 1) is None
    with pytest.raises(Refusal, match="--memory 2GB needs Linux"):
        parsed_memory("2GB", 1)
