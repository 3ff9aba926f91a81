"""Workers of a Dask cluster: with TLS, nobody without the certificate can use them."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator

import pytest

pytest.importorskip("distributed")

import dask
from distributed import LocalCluster, Security

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


@pytest.mark.parametrize("protocol", ["tls", "tcp"])
def test_a_connection_without_the_certificate_is_refused(protocol: str, protected: tuple[str, dict[str, object]]) -> None:
    # In a process of its own, without the certificate: two clients that fail in one process upset each other's event loop.
    address = protected[0].replace("tls:", f"{protocol}:")
    done = subprocess.run([sys.executable, "-c", REACH, address], capture_output=True, text=True, timeout=400, check=False)
    assert done.stdout.startswith(f"the scheduler {address} cannot be reached"), done.stdout + done.stderr[-2000:]
