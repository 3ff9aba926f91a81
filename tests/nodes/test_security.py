"""The recipe for SROS2: the form of the policy, the names on the page, and a node with a keystore."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from keystore import OPENSSL, keystore
from node_arguments import parameters

from dcrb_ros.messages.topics import NAMESPACE

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
POLICY = ROOT / "examples" / "ros" / "sros2_policy.xml"
PAGE = (ROOT / "docs" / "how-to" / "secure-with-sros2.md").read_text(encoding="utf-8")
PERMISSIONS = {"topics": {"publish", "subscribe"}, "services": {"request", "reply"}, "actions": {"call", "execute"}}


def enclaves() -> list[ElementTree.Element]:
    """Return the enclaves of the policy where `ros2 security create_permission` looks for them (sros2/api/_policy.py)."""
    return ElementTree.parse(POLICY).getroot().findall("enclaves/enclave")


def test_the_policy_has_the_form_that_sros2_reads() -> None:
    nodes = ("simulator", "fault_detector", "operator")
    assert [enclave.get("path") for enclave in enclaves()] == [f"{NAMESPACE}/{node}" for node in nodes]
    for enclave in enclaves():
        (profile,) = enclave.findall("profiles/profile")
        assert f"{profile.get('ns')}/{profile.get('node')}" == enclave.get("path")
        for group in profile:
            ((permission, rule),) = group.items()
            assert permission in PERMISSIONS[group.tag]
            assert rule == "ALLOW"
            assert {(entry.tag, bool(entry.text)) for entry in group} == {(group.tag.removesuffix("s"), True)}


def test_the_page_names_the_enclaves_and_executables_that_exist() -> None:
    paths = {enclave.get("path") for enclave in enclaves()}
    assert set(re.findall(r"^\| `(/\S+)` \|", PAGE, re.MULTILINE)) == paths
    (made,) = re.findall(r"^for node in (.+); do$", PAGE, re.MULTILINE)
    assert {f"{NAMESPACE}/{node}" for node in made.split()} == paths
    assert set(re.findall(r"(?:--enclave |OVERRIDE=)(\S+)", PAGE)) == paths
    for executable in re.findall(r"ros2 run dcrb_ros (\S+)", PAGE):
        assert (ROOT / "executables" / executable).is_file()
    for file in re.findall(r"examples/\S+\.xml", PAGE):
        assert (ROOT / file).is_file()


@pytest.mark.node
@pytest.mark.skipif(OPENSSL is None, reason="the keystore is made by openssl, which is not installed")
@pytest.mark.parametrize("enclave", [f"{NAMESPACE}/simulator", f"{NAMESPACE}/unknown"])
def test_a_node_that_cannot_be_secured_sends_nothing(enclave: str, tmp_path: Path) -> None:
    pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")
    from ros_bench import PATIENCE, domain, environment, graph_client, node

    # The wheels are built without the security libraries; a middleware that has them must refuse this governance, which has no rule.
    keys = keystore(tmp_path / "keys", f"{NAMESPACE}/simulator", POLICY)
    number = domain()
    secured = environment(number, ROS_SECURITY_KEYSTORE=str(keys), ROS_SECURITY_ENABLE="true", ROS_SECURITY_STRATEGY="Enforce")
    arguments = ["--duration", "0.5", *parameters(time_scale=0.0), "--enclave", enclave]
    with graph_client(number) as client, node("simulator", arguments, secured, tmp_path / "simulator.log") as simulator:
        client.until(lambda: simulator.process.poll() is not None, "the end of the node")
        assert simulator.process.wait(PATIENCE) == 1
        assert "security" in simulator.output.lower()
        assert "Traceback" not in simulator.output
        assert not any(client.received.values())
