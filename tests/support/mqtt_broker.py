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

from waiting import wait_for

# Debian installs the broker where the PATH of a user does not reach.
MOSQUITTO = shutil.which("mosquitto", path=os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin"]))
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
    port = free_port()
    with (folder / "broker.log").open("wb") as log:
        process = subprocess.Popen(command(port, folder), stdout=log, stderr=subprocess.STDOUT)

    def accepts() -> bool:
        assert process.poll() is None, (folder / "broker.log").read_text(errors="replace")
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    try:
        wait_for(accepts)
        yield port
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(10)
