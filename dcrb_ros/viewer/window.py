"""The Rerun viewer as a process: a window for the user, or none for a screenshot."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.parse
import webbrowser
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from dcrb_ros.viewer.timeline import TIMELINE

if TYPE_CHECKING:
    from rerun.experimental import ViewerClient

LOOPBACK = "127.0.0.1"
PATIENCE = 60.0
"""How long the viewer may take for a step [s]."""
POLL = 0.2
"""Time between two questions to the viewer [s]."""
NOTICES = 6.0
"""How long the viewer's notices of its start hide a corner [s]."""
EMPTY_BAR = 37
"""Height of the bar that the viewer leaves above the views when its top panel is hidden [pixels]."""
DRIVER_REMEDY = "install a Vulkan driver, without a graphics card the software one (Debian, Ubuntu: apt-get install mesa-vulkan-drivers)"

DISPLAY_REMEDY = "it needs a display; without one save the view into a file (viewer --save FILE.rrd)"
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET")
"""Environment variables of which a desktop on Linux sets one."""
MEMORY = "2GB"
"""What a viewer of a running bench keeps; of more the oldest is left out."""

Answer = TypeVar("Answer")


class ViewerFailure(RuntimeError):
    """The viewer could not do its work; one sentence."""


def open_window(document: Path, *, web: bool = False) -> int:
    """Show a Rerun file, bound to this machine alone, until the viewer is closed; return its exit status."""
    port = _free_port()
    command = [*_command(), "--bind", LOOPBACK, "--port", str(port), str(document)]
    try:
        return _serve_page(command, port) if web else subprocess.call(command)
    except KeyboardInterrupt:
        return 0


@contextlib.contextmanager
def window_to_fill() -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """Open an empty viewer, bound to this machine alone; yield it with the address for data. It stays open afterwards.

    Raises:
        ViewerFailure: it cannot be opened.
    """
    if sys.platform == "linux" and not any(os.environ.get(name) for name in DISPLAYS):
        # The viewer listens before it finds that out.
        raise ViewerFailure(f"the viewer cannot open its window: {DISPLAY_REMEDY}")
    port = _free_port()
    command = [*_command(), "--bind", LOOPBACK, "--port", str(port), "--hide-welcome-screen", "--memory-limit", MEMORY]
    with tempfile.TemporaryFile() as output:
        viewer = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True)
        _awaited(viewer, "open its window", lambda: _listens(port), DISPLAY_REMEDY)
        yield viewer, f"rerun+http://{LOOPBACK}:{port}/proxy"


def page_address(page_port: int, port: int) -> str:
    """Return where the browser finds the viewer's page, which gets its data from ``port``.

    The pictures are made for the dark theme, whatever the browser prefers.
    """
    data = urllib.parse.quote(f"rerun+http://{LOOPBACK}:{port}/proxy", safe="")
    return f"http://{LOOPBACK}:{page_port}/?url={data}&theme=dark&hide_welcome_screen"


def _serve_page(command: list[str], port: int) -> int:
    """Serve the viewer as a web page, open it in the browser and wait for the end."""
    page_port = _free_port()
    with subprocess.Popen([*command, "--serve-web", "--web-viewer-port", str(page_port)]) as server:
        try:
            _awaited(server, "serve its page", lambda: _listens(page_port) and _listens(port), "its words are above")
            address = page_address(page_port, port)
            print(f"the viewer is at {address} until Ctrl-C", flush=True)
            webbrowser.open(address)
            return server.wait()
        except BaseException:
            server.terminate()
            raise


def _listens(port: int) -> bool | None:
    with contextlib.suppress(OSError), socket.create_connection((LOOPBACK, port), timeout=POLL):
        return True
    return None


def save_screenshot(document: Path, picture: Path, *, at_ns: int, width: int = 1600, height: int = 1000) -> None:
    """Write a PNG of the viewer with the cursor at ``at_ns``, without a window; raise `ViewerFailure` with the reason."""
    from rerun.experimental import ViewerClient

    if not hasattr(ViewerClient, "get_state"):
        raise ViewerFailure(
            "a picture needs rerun-sdk 0.41 or later, which needs Python 3.11 or later; --save writes a Rerun file with any"
        )
    port = _free_port()
    size = f"{width}x{height + EMPTY_BAR}"
    options = ["--headless", "--bind", LOOPBACK, "--port", str(port), "--hide-welcome-screen", "--window-size", size]
    with _running([*_command(), *options, str(document)]) as viewer:
        started = time.monotonic()
        client = _awaited(viewer, "load the recording", lambda: _client_with_recording(port))
        client.set_time(TIMELINE, timestamp=at_ns / 1e9, play_state="paused")
        _awaited(viewer, "go to the time of the picture", lambda: _stands_at(client, at_ns))
        time.sleep(max(0.0, started + NOTICES - time.monotonic()))
        _save_cropped(_awaited(viewer, "come to rest", lambda: _still_picture(client)), picture)
        reports = [f"{view.name}: {report.summary}" for view in client.get_state().views for report in view.reports]
    if reports:
        raise ViewerFailure(f"the viewer could not draw everything in {picture}: {'; '.join(reports)}")


def _save_cropped(png: bytes, picture: Path) -> None:
    from PIL import Image

    with Image.open(io.BytesIO(png)) as whole:
        whole.convert("RGB").crop((0, EMPTY_BAR, *whole.size)).save(picture, format="PNG", optimize=True)


def _command() -> list[str]:
    return [sys.executable, "-m", "rerun_cli"]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def _running(command: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """Run the viewer in a process group of its own, end the whole group afterwards: ``rerun_cli`` starts the viewer as its child."""
    environment = {**os.environ, "RERUN_APP_ONLY": "true"}
    with tempfile.TemporaryFile() as output:
        viewer = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, env=environment, start_new_session=True)
        try:
            yield viewer
        finally:
            _end(viewer)


def _end(viewer: subprocess.Popen[bytes]) -> None:
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError):
            os.killpg(viewer.pid, signal.SIGKILL)
    else:
        subprocess.call(["taskkill", "/PID", str(viewer.pid), "/T", "/F"], stdout=subprocess.DEVNULL)
    viewer.wait(PATIENCE)


def _awaited(viewer: subprocess.Popen[bytes], purpose: str, ask: Callable[[], Answer | None], remedy: str = DRIVER_REMEDY) -> Answer:
    """Ask until there is an answer; raise `ViewerFailure` when the viewer ends or `PATIENCE` does."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if viewer.poll() is not None:
            raise ViewerFailure(f"the viewer ended before it could {purpose}: {remedy}")
        with contextlib.suppress(ConnectionError):
            answer = ask()
            if answer is not None:
                return answer
        time.sleep(POLL)
    raise ViewerFailure(f"the viewer did not {purpose} within {PATIENCE:g} s: try a shorter recording")


def _client_with_recording(port: int) -> ViewerClient | None:
    from rerun.experimental import ViewerClient

    client = ViewerClient.connect(f"rerun+http://{LOOPBACK}:{port}/proxy")
    state = client.get_state()
    return client if state.recordings and state.views and not state.loading else None


def _stands_at(client: ViewerClient, time_ns: int) -> bool | None:
    recordings = client.get_state().recordings
    close = [r for r in recordings if r.current_timeline == TIMELINE and abs((r.current_time or 0) - time_ns) < 1_000_000]
    return True if close else None


def _still_picture(client: ViewerClient) -> bytes | None:
    """Return the picture once two in succession are the same."""
    first = client.take_screenshot()
    time.sleep(POLL)
    second = client.take_screenshot()
    return second if second == first else None
