"""A Rerun file for the viewer's web page.

Rerun's own data server keeps a core busy as long as it holds a recording (measured with 0.41). The page then lacks that core.
"""

from __future__ import annotations

import shutil
import threading
import urllib.parse
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

LOOPBACK = "127.0.0.1"


@contextmanager
def document_served(document: Path, page: str) -> Iterator[str]:
    """Serve a file to the web page of the origin ``page`` and to no other; yield its address. Only local connections are accepted."""
    path = "/" + urllib.parse.quote(document.name)

    class Handler(BaseHTTPRequestHandler):
        """Answers requests for the file, and refuses any other."""

        def do_GET(self) -> None:
            if self._head():
                with document.open("rb") as file:
                    shutil.copyfileobj(file, self.wfile)

        def do_HEAD(self) -> None:
            self._head()

        def _head(self) -> bool:
            """Send the status and the headers; return whether the file follows."""
            # The name of the host must be checked, since any page may have a name that leads to this machine.
            known = self.path == path and self.headers.get("Host") == f"{LOOPBACK}:{server.server_port}"
            self.send_response(HTTPStatus.OK if known else HTTPStatus.NOT_FOUND)
            self.send_header("Access-Control-Allow-Origin", page)
            self.send_header("Content-Length", str(document.stat().st_size if known else 0))
            self.end_headers()
            return known

        def log_message(self, format: str, *args: object) -> None:
            """Print nothing."""

    with ThreadingHTTPServer((LOOPBACK, 0), Handler) as server:
        threading.Thread(target=server.serve_forever, name="document", daemon=True).start()
        try:
            yield f"http://{LOOPBACK}:{server.server_port}{path}"
        finally:
            server.shutdown()
