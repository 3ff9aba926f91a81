"""The Rerun viewer as a process: with a window for the user, or headless for a screenshot."""

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
from typing import IO, TYPE_CHECKING, TypeVar

from dcrb_ros.runtime.children import group_guard
from dcrb_ros.text.writing import whole_file
from dcrb_ros.viewer.columns import TIMELINE
from dcrb_ros.viewer.document_server import LOOPBACK, document_served

if TYPE_CHECKING:
    from rerun.experimental import ViewerClient

PATIENCE = 60.0
"""Longest wait for an action of the viewer [s]."""
END_TIMEOUT = 2.0
"""Time that the server of a page has to end after this program was killed [s]."""
POLL = 0.2
"""Interval at which the viewer is polled [s]."""
NOTICE_TIME = 6.0
"""Time for which the viewer's start-up notices cover a corner of the picture [s]."""
WIDTH, HEIGHT = 1600, 1000
"""Size of a picture [pixels]."""
BAR_HEIGHT = 37
"""Height of the empty bar above the views if the top panel is hidden [pixels]."""
DRIVER_REMEDY = "install a Vulkan driver, such as the software driver (Debian, Ubuntu: apt-get install mesa-vulkan-drivers)"

DISPLAY_REMEDY = "it needs a display; without one, save the view to a file (viewer --save FILE.rrd)"
WINDOW_REMEDY = "use the browser (--web), or write a file for Rerun on another machine (--save FILE.rrd)"
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET")
"""Environment variables, of which a Linux desktop sets at least one."""
MEMORY = "2GB"
"""Memory limit of the viewer of a running bench; the oldest data are dropped first."""

Answer = TypeVar("Answer")


class ViewerFailure(RuntimeError):
    """The viewer failed; the message is one sentence."""


def open_window(document: Path, *, web: bool = False) -> int:
    """Show a Rerun file until the viewer is closed; return its exit status. The viewer accepts local connections only.

    Its temporary files are beside the file.

    Raises:
        ViewerFailure: it cannot be opened.
    """
    if not (web or _has_display()):
        raise ViewerFailure(f"the viewer cannot open its window, because there is no display: {WINDOW_REMEDY}")
    command = [*_command(), "--bind", LOOPBACK, "--port", str(_free_port())]
    environment = _environment(document.parent)
    try:
        return _serve_page(command, document, environment) if web else _call([*command, str(document)], environment)
    except KeyboardInterrupt:
        return 0


def _has_display() -> bool:
    return sys.platform != "linux" or any(os.environ.get(name) for name in DISPLAYS)


def _environment(folder: Path) -> dict[str, str]:
    """Return the environment of the viewer; it logs errors only, without escape codes, unless RUST_LOG asks for more.

    It keeps its temporary files in ``folder``, since it leaves them behind if it is killed.
    """
    return {"RUST_LOG": "error", **os.environ, "NO_COLOR": "1", "TMPDIR": str(folder)}


def _call(command: list[str], environment: dict[str, str]) -> int:
    """Run the viewer with a window until it is closed; where it ends with an error, a `ViewerFailure` quotes its last line."""
    with tempfile.TemporaryFile() as output:
        with _running(command, environment, output) as viewer:
            status = _status_of(viewer)
        output.seek(0)
        lines = output.read().decode(errors="replace").splitlines()
    if status > 0:
        reason = lines[-1].removeprefix("Error: ") if lines else f"exit status {status}"
        raise ViewerFailure(f"the viewer failed ({reason}): {WINDOW_REMEDY}")
    return 0


@contextlib.contextmanager
def window_to_fill() -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """Open an empty viewer; yield its process and the address for data. The viewer accepts local connections only and stays open.

    Raises:
        ViewerFailure: it cannot be opened.
    """
    if not _has_display():
        # The viewer starts to listen before it notices the missing display.
        raise ViewerFailure(f"the viewer cannot open its window: {DISPLAY_REMEDY}")
    port = _free_port()
    command = [*_command(), "--bind", LOOPBACK, "--port", str(port), "--hide-welcome-screen", "--memory-limit", MEMORY]
    quiet = subprocess.DEVNULL
    viewer = subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True)
    _wait_for(viewer, "open its window", lambda: _listens(port), DISPLAY_REMEDY)
    yield viewer, f"rerun+http://{LOOPBACK}:{port}/proxy"


def page_address(page: str, data: str) -> str:
    """Return the address of the viewer's web page at ``page``, which loads the file at ``data``.

    The dark theme is requested since the colours are chosen for it.
    """
    return f"{page}/?url={urllib.parse.quote(data, safe='')}&theme=dark&hide_welcome_screen"


def _serve_page(command: list[str], document: Path, environment: dict[str, str]) -> int:
    """Serve the viewer as a web page, open it in the browser and wait until the server ends."""
    port = _free_port()
    page = f"http://{LOOPBACK}:{port}"
    serving = [*command, "--serve-web", "--web-viewer-port", str(port)]
    with document_served(document, page) as data, group_guard(END_TIMEOUT) as guarded, _running(serving, environment) as server:
        guarded(server.pid)
        _wait_for(server, "serve its page", lambda: _listens(port), "its messages are printed above")
        address = page_address(page, data)
        print(f"the viewer is at {address} until Ctrl-C", flush=True)
        webbrowser.open(address)
        return _status_of(server)


def _listens(port: int) -> bool | None:
    with contextlib.suppress(OSError), socket.create_connection((LOOPBACK, port), timeout=POLL):
        return True
    return None


def save_screenshot(document: Path, picture: Path, *, at_ns: int) -> None:
    """Write a PNG of the viewer with the cursor at ``at_ns`` [ns], without opening a window.

    Temporary files of the viewer are left beside ``document``.

    Raises:
        ViewerFailure: the installed Rerun is too old, or the viewer failed.
    """
    from rerun.experimental import ViewerClient

    if not hasattr(ViewerClient, "get_state"):
        raise ViewerFailure("a screenshot needs rerun-sdk 0.41 or later, which needs Python 3.11 or later; --save works with any version")
    port = _free_port()
    size = f"{WIDTH}x{HEIGHT + BAR_HEIGHT}"
    options = ["--headless", "--bind", LOOPBACK, "--port", str(port), "--hide-welcome-screen", "--window-size", size]
    environment = {**os.environ, "RERUN_APP_ONLY": "true", "TMPDIR": str(document.parent)}
    with _running([*_command(), *options, str(document)], environment, subprocess.DEVNULL) as viewer:
        started = time.monotonic()
        client = _wait_for(viewer, "load the recording", lambda: _client_with_recording(port))
        client.set_time(TIMELINE, timestamp=at_ns / 1e9, play_state="paused")
        _wait_for(viewer, "move the cursor to the time of the picture", lambda: _is_at(client, at_ns))
        time.sleep(max(0.0, started + NOTICE_TIME - time.monotonic()))
        drawn = _wait_for(viewer, "draw a stable picture", lambda: _stable_picture(client))
        reports = [f"{view.name}: {report.summary}" for view in client.get_state().views for report in view.reports]
    if reports:
        raise ViewerFailure(f"{picture} was not written, because the viewer could not draw everything: {'; '.join(reports)}")
    _save_cropped(drawn, picture)


def _save_cropped(png: bytes, picture: Path) -> None:
    from PIL import Image

    with Image.open(io.BytesIO(png)) as whole, whole_file(picture) as temporary:
        whole.convert("RGB").crop((0, BAR_HEIGHT, *whole.size)).save(temporary, format="PNG", optimize=True)


def _command() -> list[str]:
    return [sys.executable, "-m", "rerun_cli"]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def _running(command: list[str], environment: dict[str, str], output: IO[bytes] | int | None = None) -> Iterator[subprocess.Popen[bytes]]:
    """Run the viewer in a process group of its own and kill the whole group afterwards: ``rerun_cli`` starts the viewer as its child."""
    viewer = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, env=environment, start_new_session=True)
    try:
        yield viewer
    finally:
        _end(viewer)


def _status_of(viewer: subprocess.Popen[bytes]) -> int:
    """Wait until a viewer ends, and return its status; a signal that arrives just before a wait without end is noticed after it only."""
    while (status := viewer.poll()) is None:
        time.sleep(POLL)
    return status


def _end(viewer: subprocess.Popen[bytes]) -> None:
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError):
            os.killpg(viewer.pid, signal.SIGKILL)
    else:
        subprocess.call(["taskkill", "/PID", str(viewer.pid), "/T", "/F"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    viewer.wait(PATIENCE)


def _wait_for(viewer: subprocess.Popen[bytes], purpose: str, ask: Callable[[], Answer | None], remedy: str = DRIVER_REMEDY) -> Answer:
    """Poll until ``ask`` returns an answer, and return it; raise `ViewerFailure` if the viewer ends before, or after `PATIENCE`."""
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


def _is_at(client: ViewerClient, time_ns: int) -> bool | None:
    recordings = client.get_state().recordings
    close = [r for r in recordings if r.current_timeline == TIMELINE and abs((r.current_time or 0) - time_ns) < 1_000_000]
    return True if close else None


def _stable_picture(client: ViewerClient) -> bytes | None:
    """Return a picture if two consecutive ones are equal, otherwise None."""
    first = client.take_screenshot()
    time.sleep(POLL)
    second = client.take_screenshot()
    return second if second == first else None
