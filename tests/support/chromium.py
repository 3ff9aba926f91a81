"""A browser without a window, spoken to through a pipe (`--remote-debugging-pipe`), and what its page shows."""

from __future__ import annotations

import base64
import io
import json
import os
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
PATIENCE = 600.0
"""Longest life of a browser [s]."""
ARRIVAL = 150.0
"""How long it may take to a page [s]."""


def found() -> str | None:
    """Return the browser of this machine, if it has one."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class NotNow(RuntimeError):
    """The browser refused a command; while it goes to a page it has none that it could show."""


class Page:
    """A page in a browser's process, by the DevTools protocol: JSON ended by a zero byte."""

    def __init__(self, writing: int, reading: int, url: str, size: tuple[int, int]) -> None:
        self._writing, self._reading, self._read, self._number, self._session = writing, reading, b"", 0, ""
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self.ask("Emulation.setDeviceMetricsOverride", **metrics)
        self.ask("Page.navigate", url=url)

    def ask(self, method: str, **parameters: Any) -> Any:
        """Return the answer to a command."""
        self._number += 1
        command = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            command["sessionId"] = self._session
        os.write(self._writing, json.dumps(command).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise NotNow(answer["error"]["message"])
                return answer["result"]

    def _message(self) -> Any:
        while b"\0" not in self._read:
            more = os.read(self._reading, 1 << 16)
            assert more, "the browser has ended"
            self._read += more
        message, _, self._read = self._read.partition(b"\0")
        return json.loads(message)

    def png(self) -> bytes:
        """Return what the page shows, as soon as there is one."""
        end = time.monotonic() + ARRIVAL
        while True:
            try:
                return base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])
            except NotNow:
                if time.monotonic() > end:
                    raise
                time.sleep(0.1)

    def pixels(self) -> npt.NDArray[np.int64]:
        """Return the colours of the page, shape (height, width, 3)."""
        from PIL import Image

        with Image.open(io.BytesIO(self.png())) as image:
            return np.asarray(image.convert("RGB")).astype(np.int64)


@contextmanager
def page(url: str, *, size: tuple[int, int] = (1600, 1000)) -> Iterator[Page]:
    """Open a page; the browser is ended whatever happens, and after `PATIENCE` at the latest."""
    browser = found()
    assert browser is not None
    to_read, writing = os.pipe()
    reading, to_write = os.pipe()
    command = 'exec 3<&"$0" 4>&"$1"; shift; exec "$@"'
    with tempfile.TemporaryDirectory(prefix="dcrb-browser-", ignore_cleanup_errors=True) as profile, Path(profile, "log").open("wb") as log:
        arguments = [browser, *FLAGS, "--remote-debugging-pipe", f"--user-data-dir={profile}/profile", "about:blank"]
        process = subprocess.Popen(
            ["bash", "-c", command, str(to_read), str(to_write), *arguments],
            pass_fds=(to_read, to_write),
            stdout=log,
            stderr=log,
            start_new_session=True,
        )
        os.close(to_read)
        os.close(to_write)
        watchdog = threading.Timer(PATIENCE, process.kill)
        watchdog.start()
        try:
            yield Page(writing, reading, url, size)
        finally:
            watchdog.cancel()
            process.terminate()
            try:
                process.wait(20.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            os.close(writing)
            os.close(reading)
