"""A keystore with one enclave: the files of `ros2 security create_keystore` and `create_enclave`, made by openssl."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

OPENSSL = shutil.which("openssl")
NEW_KEY = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]


def _openssl(*words: str | Path) -> None:
    assert OPENSSL is not None
    subprocess.run([OPENSSL, *words], check=True, capture_output=True, timeout=400)


def keystore(folder: Path, enclave: str, permissions: Path) -> Path:
    """Make a keystore with an authority, a signed governance and the signed ``permissions`` of an enclave; return its folder."""
    public, private, inside = folder / "public", folder / "private", folder / "enclaves" / enclave.strip("/")
    for path in (public, private, inside):
        path.mkdir(parents=True)
    authority, key = public / "ca.cert.pem", private / "ca.key.pem"
    _openssl("req", "-x509", *NEW_KEY, "-days", "10", "-subj", "/CN=authority", "-keyout", key, "-out", authority)
    for name in ("identity_ca.cert.pem", "permissions_ca.cert.pem"):
        (inside / name).symlink_to(authority)

    request = inside / "request.pem"
    subject = "/CN=" + enclave.replace("/", "\\/")
    _openssl("req", *NEW_KEY, "-subj", subject, "-keyout", inside / "key.pem", "-out", request)
    signing = ["-CA", authority, "-CAkey", key, "-CAcreateserial", "-days", "10"]
    _openssl("x509", "-req", "-in", request, *signing, "-out", inside / "cert.pem")

    governance = folder / "governance.xml"
    governance.write_text("<dds><domain_access_rules/></dds>", encoding="utf-8")
    for document, signed in ((governance, "governance.p7s"), (permissions, "permissions.p7s")):
        _openssl("smime", "-sign", "-in", document, "-text", "-out", inside / signed, "-signer", authority, "-inkey", key)
    return folder
