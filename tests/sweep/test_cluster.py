"""Workers of a Dask cluster: with TLS, nobody without the certificate can use them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("distributed")

import dask
from distributed import LocalCluster, Security
from waiting import wait_for

from dcrb_ros.sweep.cluster import cluster_workers

CERTIFICATE = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "1"]


def settings(certificate: str, key: str) -> dict[str, object]:
    """Return the settings of Dask that docs/how-to/make-a-data-set.md exports."""
    files = {"cert": certificate, "key": key}
    roles = {f"distributed.comm.tls.{role}.{part}": path for role in ("scheduler", "worker", "client") for part, path in files.items()}
    return {"distributed.comm.require-encryption": True, "distributed.comm.tls.ca-file": certificate, **roles}


@pytest.fixture(scope="module")
def protected(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, dict[str, object]]]:
    """Provide the address of a scheduler with TLS, and the settings of those who may use it."""
    if shutil.which("openssl") is None:
        pytest.skip("openssl makes the certificate")
    folder = tmp_path_factory.mktemp("tls")
    certificate, key = str(folder / "cert.pem"), str(folder / "key.pem")
    subprocess.run([*CERTIFICATE, "-keyout", key, "-out", certificate, "-subj", "/CN=test"], check=True, capture_output=True, timeout=400)
    allowed = settings(certificate, key)
    with (
        dask.config.set(allowed),
        LocalCluster(n_workers=1, processes=False, protocol="tls://", security=Security(), dashboard_address=None) as cluster,
    ):
        yield cluster.scheduler_address, allowed


def test_the_certificate_opens_the_cluster(protected: tuple[str, dict[str, object]]) -> None:
    address, allowed = protected
    assert address.startswith("tls://")
    with dask.config.set(allowed), cluster_workers(address) as workers:
        assert workers.count >= 1


REACH = """
import sys
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep import cluster

cluster.PATIENCE = 3.0
try:
    with cluster.cluster_workers(sys.argv[1]):
        print("reached")
except Refusal as refusal:
    print(refusal)
"""
"""Run in a process of its own, because a client that failed can keep later clients of its process from starting."""


@pytest.mark.parametrize("protocol", ["tls", "tcp"])
def test_a_connection_without_the_certificate_is_refused(protocol: str, protected: tuple[str, dict[str, object]]) -> None:
    address = protected[0].replace("tls:", f"{protocol}:")
    done = subprocess.run([sys.executable, "-c", REACH, address], capture_output=True, text=True, timeout=400, check=False)
    assert done.stdout.startswith(f"the scheduler {address} cannot be reached"), done.stdout + done.stderr[-2000:]


@pytest.mark.parametrize(
    ("address", "settings", "sentence"),
    [
        ("tls://127.0.0.1:9", {}, "Dask has no certificate on this machine; set DASK_DISTRIBUTED__COMM__TLS__CA_FILE"),
        ("tcp://127.0.0.1:9", {"DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION": "True"}, "give an address that begins with tls://"),
    ],
)
def test_settings_that_do_not_fit_the_address_are_refused(address: str, settings: dict[str, str], sentence: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", REACH, address], env=os.environ | settings, capture_output=True, text=True, timeout=400, check=False
    )
    assert done.stdout.startswith(f"the scheduler {address} cannot be reached"), done.stdout + done.stderr[-2000:]
    assert sentence in done.stdout


LOSE = """
import os, signal, sys, threading
from types import SimpleNamespace
from dcrb_ros.sweep import cluster

cluster._compare = lambda client, scheduler: None
with cluster.cluster_workers(sys.argv[1]) as workers:
    threading.Timer(0.2, os.kill, (int(sys.argv[2]), signal.SIGKILL)).start()
    try:
        next(workers.dispatched(None, iter([[SimpleNamespace(name="run")]])))
    except RuntimeError as error:
        print(error)
"""


@pytest.mark.slow
def test_a_lost_scheduler_is_named_without_a_traceback(tmp_path: Path) -> None:
    file = tmp_path / "scheduler.json"
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)]
    with subprocess.Popen([*command, "--no-dashboard"], stderr=subprocess.DEVNULL) as scheduler:
        try:
            wait_for(lambda: file.is_file() and bool(file.read_text(encoding="utf-8")))
            address = json.loads(file.read_text(encoding="utf-8"))["address"]
            run = [sys.executable, "-c", LOSE, address, str(scheduler.pid)]
            done = subprocess.run(run, capture_output=True, text=True, timeout=400, check=False)
        finally:
            scheduler.kill()
    lost = f"the connection to the scheduler {address} was lost: start it and its workers again, and run the same command again to continue"
    assert done.stdout == f"{lost}\n", done.stderr[-2000:]
    assert "Traceback" not in done.stderr


@pytest.mark.slow  # it waits for ten seconds
def test_a_scheduler_that_does_not_answer_ends_the_command_with_status_2(tmp_path: Path) -> None:
    sweep = tmp_path / "sweep.yaml"
    sweep.write_text("duration: 0.02", encoding="utf-8")
    command = [
        sys.executable,
        "-m",
        "dcrb_ros.cli.program",
        "sweep",
        str(sweep),
        "-o",
        str(tmp_path / "set"),
        "--scheduler",
        "tcp://127.0.0.1:9",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 2, done.stderr
    assert "the scheduler tcp://127.0.0.1:9 cannot be reached" in done.stderr.splitlines()[-1]
    assert not (tmp_path / "set").exists()
