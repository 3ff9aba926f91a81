"""An MQTT broker as a process of its own: mosquitto where it is installed, otherwise amqtt."""

from __future__ import annotations

import importlib.util
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from waiting import PATIENCE, wait_for

# Debian installs the broker where the PATH of a user does not reach.
MOSQUITTO = shutil.which("mosquitto", path=os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin"]))
ATTEMPTS = 3
"""How often a broker is started: another program may take the free port first."""
INSTALLED = MOSQUITTO is not None or importlib.util.find_spec("amqtt") is not None

CONFIGURATION = """
listeners:
  default:
    type: tcp
    bind: 127.0.0.1:{port}
plugins:
  amqtt.plugins.authentication.AnonymousAuthPlugin:
    allow_anonymous: true
"""


def command(port: int, folder: Path) -> list[str]:
    """Return the command that runs a broker on a port of this machine."""
    if MOSQUITTO:
        return [MOSQUITTO, "-p", str(port)]
    file = folder / "broker.yaml"
    file.write_text(CONFIGURATION.format(port=port), encoding="utf-8")
    return [sys.executable, "-c", "from amqtt.scripts.broker_script import main; main()", "-c", str(file)]


def free_port() -> int:
    """Return a port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def broker(folder: Path) -> Iterator[int]:
    """Run a broker; yield its port once it accepts connections."""
    for attempt in range(ATTEMPTS):
        port = free_port()
        with (folder / "broker.log").open("wb") as log:
            process = subprocess.Popen(command(port, folder), stdout=log, stderr=subprocess.STDOUT)
        try:
            if _accepts(port, process):
                yield port
                return
            assert attempt + 1 < ATTEMPTS, (folder / "broker.log").read_text(errors="replace")
        finally:
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait(PATIENCE)


def _accepts(port: int, process: subprocess.Popen[bytes]) -> bool:
    """Wait until a broker accepts connections; return false if it has ended, as where another program has taken its port meanwhile."""

    def connected() -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    wait_for(lambda: process.poll() is not None or connected())
    return process.poll() is None
