"""The file of the web page: the page gets it, nobody else does."""

from __future__ import annotations

import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest

from dcrb_ros.viewer.document_server import document_served

PAGE = "http://127.0.0.1:9090"
CONTENT = bytes(range(256)) * 1000


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    (tmp_path / "a bag [1].rrd").write_bytes(CONTENT)
    (tmp_path / "other.rrd").write_bytes(b"other")
    with document_served(tmp_path / "a bag [1].rrd", PAGE) as found:
        yield found


def test_the_page_gets_the_whole_file(address: str) -> None:
    with urllib.request.urlopen(address, timeout=400.0) as answer:
        assert answer.headers["Access-Control-Allow-Origin"] == PAGE
        assert answer.read() == CONTENT


def test_the_size_is_told_without_the_file(address: str) -> None:
    with urllib.request.urlopen(urllib.request.Request(address, method="HEAD"), timeout=400.0) as answer:
        assert (answer.headers["Content-Length"], answer.read()) == (str(len(CONTENT)), b"")


def test_other_files_and_other_names_of_the_host_are_refused(address: str) -> None:
    other = address.rpartition("/")[0]
    named = urllib.request.Request(address, headers={"Host": "somewhere.example"})
    for request in (f"{other}/other.rrd", f"{other}/", f"{other}/../other.rrd", named):
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(request, timeout=400.0)


def test_only_local_connections_are_accepted(address: str) -> None:
    assert address.startswith("http://127.0.0.1:")


def test_nothing_is_printed(address: str, capfd: pytest.CaptureFixture[str]) -> None:
    urllib.request.urlopen(address, timeout=400.0).close()
    assert capfd.readouterr() == ("", "")


def test_the_server_ends_with_the_context(tmp_path: Path) -> None:
    (tmp_path / "x.rrd").touch()
    with document_served(tmp_path / "x.rrd", PAGE) as found:
        pass
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(found, timeout=400.0)
