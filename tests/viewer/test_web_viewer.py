"""The viewer in a web browser: it accepts local connections only, and a headless browser shows the bearing."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import chromium
import numpy as np
import pytest
from runs import record, simulated
from waiting import wait_for

from dcrb_ros.viewer import palette
from dcrb_ros.viewer.window import page_address

PATIENCE = 300.0
"""Longest wait for the viewer [s]."""


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = simulated(0.6, fault="outer_1", state_rate=100)
    return record(tmp_path_factory.mktemp("bags") / "short", run.configuration, run.blocks)


@contextmanager
def served(bag: Path) -> Iterator[tuple[str, int]]:
    """Run `dcrb view --web`; yield the address that it prints, and the number of its process."""
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "view", str(bag), "--web"]
    environment = {**os.environ, "BROWSER": "true", "NO_COLOR": "1", "TMPDIR": str(bag.parent)}  # it is killed, its files would stay
    viewer = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment, start_new_session=True)
    assert viewer.stdout is not None
    watchdog = threading.Timer(2.0 * PATIENCE, viewer.kill)
    watchdog.start()
    try:
        found = next((at for line in viewer.stdout if (at := re.search(r"the viewer is at (http://\S+)", line))), None)
        assert found is not None
        yield found[1], viewer.pid
    finally:
        watchdog.cancel()
        viewer.kill()
        viewer.wait(PATIENCE)
        viewer.stdout.close()


def listeners(port: int) -> set[str]:
    """Return the local addresses of the sockets listening on a port, in the kernel's notation."""
    lines = [line.split() for table in ("tcp", "tcp6") for line in Path("/proc/net", table).read_text().splitlines()[1:]]
    return {words[1].split(":")[0] for words in lines if words[1].endswith(f":{port:04X}") and words[3] == "0A"}


def test_page_address_uses_the_loopback_address() -> None:
    assert (
        page_address("http://127.0.0.1:9090", "http://127.0.0.1:9876/a%20bag.rrd")
        == "http://127.0.0.1:9090/?url=http%3A%2F%2F127.0.0.1%3A9876%2Fa%2520bag.rrd&theme=dark&hide_welcome_screen"
    )


def test_web_viewer_accepts_local_connections_only(bag: Path) -> None:
    with served(bag) as (address, _):
        with urllib.request.urlopen(address, timeout=PATIENCE) as page:
            assert b"<html" in page.read().lower()
        for port in re.findall(r"127\.0\.0\.1(?::|%3A)(\d+)", address):
            assert listeners(int(port)) == {"0100007F"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_the_server_ends_with_the_command(kind: signal.Signals, bag: Path) -> None:
    with served(bag) as (address, process):
        port = int(address.split(":")[2].split("/")[0])
        assert listeners(port)
        os.kill(process, kind)
        wait_for(lambda: not listeners(port), PATIENCE)


@pytest.mark.skipif(chromium.found() is None, reason="needs a Chromium (Debian: apt-get install chromium)")
def test_browser_shows_the_bearing(bag: Path) -> None:
    wanted = [np.array(colour[:3]) for colour in (palette.LOAD, palette.DEFECT, palette.BRASS)]
    with served(bag) as (address, _), chromium.page(address, size=(900, 600)) as page:
        end, missing = time.monotonic() + PATIENCE, wanted
        while missing and time.monotonic() < end:
            pixels = page.pixels()
            missing = [colour for colour in wanted if (np.abs(pixels - colour).max(axis=2) < 12).sum() < 15]
        assert not missing
