"""The memory of the machine and of a process."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from dcrb_ros.runtime.processes import available_memory, resident_memory

GROUP = Path("/sys/fs/cgroup/memory.max")


@pytest.mark.skipif(not hasattr(os, "sysconf"), reason="the memory is asked for with sysconf")
@pytest.mark.parametrize(("limit", "share"), [("1000000\n", 1_000_000), ("max\n", None), ("9" * 20, None), (None, None)])
def test_a_container_may_use_less_than_the_machine(limit: str | None, share: int | None, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_text(path: Path) -> str:
        if path != GROUP or limit is None:
            raise FileNotFoundError(path)
        return limit

    monkeypatch.setattr(Path, "read_text", read_text)
    assert available_memory() == (share or os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the memory of Linux")
def test_the_memory_of_a_process_grows_with_its_data() -> None:
    before = resident_memory()
    data = bytearray(os.urandom(1)) * 50_000_000
    after = resident_memory()
    assert before is not None
    assert after is not None
    assert 40_000_000 < after - before < 60_000_000
    del data
