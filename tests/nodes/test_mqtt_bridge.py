"""The recipe for MQTT: a real broker, the example, a simulator and a fault detector, each a process of its own."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from node_arguments import parameters

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")
pytest.importorskip("paho.mqtt.client", reason="the example needs paho-mqtt, which is in the extra 'test'")

from mqtt_broker import INSTALLED, broker, free_port
from paho.mqtt import client as mqtt
from ros_bench import PATIENCE, domain, environment, graph_client, node

from dcrb_ros.messages.joints import decode_joints
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import DIAGNOSIS, FEATURES, NAMESPACE

EXAMPLE = Path(__file__).parents[2] / "examples" / "mqtt_bridge.py"
DIAGNOSES, BLOCKS = f"dcrb/{DIAGNOSIS.name}", f"dcrb/{FEATURES.name}"

pytestmark = [pytest.mark.node, pytest.mark.slow]
brokered = pytest.mark.skipif(not INSTALLED, reason="no MQTT broker: neither mosquitto nor amqtt is installed")


class Listener:
    """An MQTT client that keeps what it receives, by topic, and whether it was retained."""

    def __init__(self, port: int) -> None:
        self.received: dict[str, list[tuple[dict[str, Any], bool]]] = defaultdict(list)
        self.subscribed = threading.Event()
        self._client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
        self._client.on_connect = lambda client, *_: client.subscribe("dcrb/#", qos=1)
        self._client.on_subscribe = lambda *_: self.subscribed.set()
        self._client.on_message = self._keep
        self._client.connect("127.0.0.1", port)
        self._client.loop_start()

    def _keep(self, client: Any, data: Any, message: Any) -> None:
        self.received[message.topic].append((json.loads(message.payload), message.retain))

    def values(self, topic: str) -> list[dict[str, Any]]:
        return [value for value, _ in list(self.received[topic])]

    def close(self) -> None:
        self._client.disconnect()
        self._client.loop_stop()


@contextmanager
def listener(port: int) -> Iterator[Listener]:
    """Yield a client that is subscribed to everything of the bench."""
    found = Listener(port)
    try:
        assert found.subscribed.wait(PATIENCE)
        yield found
    finally:
        found.close()


@contextmanager
def bridge(number: int, log: Path, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run the example, which is ended in any case."""
    with log.open("wb") as output:
        process = subprocess.Popen(
            [sys.executable, str(EXAMPLE), *arguments], env=environment(number), stdout=output, stderr=subprocess.STDOUT
        )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.wait(PATIENCE)


def feature_values(data: bytes) -> dict[str, Any]:
    """Return time and features of a ROS message."""
    found = decode_joints(data)
    return {"time": pytest.approx(found.stamp_ns * 1e-9), **dict(zip(found.names, found.position, strict=True))}


def verdict(data: bytes) -> tuple[Any, str]:
    """Return time and verdict of a ROS message."""
    stamp_ns, (status, *_) = decode_diagnostics(data)
    return pytest.approx(stamp_ns * 1e-9), status.message


def assert_same_tail(found: list[Any], expected: list[Any], least: int) -> None:
    """Require that two lists are equal over the length of the shorter one, which has at least ``least`` elements."""
    common = min(len(found), len(expected))
    assert common >= least
    assert found[-common:] == expected[-common:]


@brokered
def test_mqtt_carries_every_diagnosis_and_feature_of_the_nodes(tmp_path: Path) -> None:
    number = domain()
    with (
        broker(tmp_path) as port,
        listener(port) as received,
        graph_client(number) as client,
        bridge(number, tmp_path / "bridge.log", "--broker", "127.0.0.1", "--port", str(port)) as example,
    ):
        client.until(lambda: client.node.count_subscribers(f"{NAMESPACE}/{FEATURES.name}") == 2, "the subscription of the bridge")
        arguments = ["--duration", "4", *parameters(faults__outer_1__width=0.002, publishing__listeners=2)]
        with (
            node("fault_detector", [], environment(number), tmp_path / "detector.log"),
            node("simulator", arguments, environment(number), tmp_path / "simulator.log") as simulator,
        ):

            def complete() -> bool:
                assert example.poll() is None, (tmp_path / "bridge.log").read_text(errors="replace")
                assert simulator.process.poll() in (None, 0), simulator.output
                # The first messages may precede the connection of their subscriber; the last ones of the 4 s arrive everywhere.
                over_ros = [topic.stamp(client.received[topic][-1]) * 1e-9 for topic in (FEATURES, DIAGNOSIS)]
                over_mqtt = [received.values(topic)[-1]["time"] for topic in (BLOCKS, DIAGNOSES)]
                last = [198.5 * 1024 / 51200, 3.9]  # before the 200th block, and before the diagnosis at 4 s
                return all(time > begin for times in (over_ros, over_mqtt) for time, begin in zip(times, last, strict=True))

            client.until(complete, "the last features and diagnosis, over ROS and MQTT")

        blocks = [feature_values(data) for data in client.received[FEATURES]]
        verdicts = [verdict(data) for data in client.received[DIAGNOSIS]]
        # Once both subscribers are connected, no message is lost, repeated or late.
        assert_same_tail(received.values(BLOCKS), blocks, 150)
        assert_same_tail([(value["time"], value["verdict"]) for value in received.values(DIAGNOSES)], verdicts, 4)
        last, published = received.values(DIAGNOSES)[-1], decode_diagnostics(client.received[DIAGNOSIS][-1])[1][0].values
        texts = {"verdict", "reason", "remarks"}
        assert {key: last[key] for key in texts} == {key: published[key] for key in texts}
        numbers = {key: value for key, value in last.items() if key not in {"time", *texts}}
        assert numbers == {key: float(published[key]) for key in published.keys() - texts}
        assert last["verdict"] == "outer_ring"
        assert not any(retained for messages in received.received.values() for _, retained in messages)

        # Who comes later is told the last diagnosis, and nothing else.
        with listener(port) as late:
            client.until(lambda: late.values(DIAGNOSES), "the retained diagnosis")
            assert set(late.received) == {DIAGNOSES}
            # A broker may deliver a message of quality 1 more than once.
            for message in late.received[DIAGNOSES]:
                assert message == (received.values(DIAGNOSES)[-1], True)
        example.send_signal(signal.SIGINT)
        assert example.wait(PATIENCE) == 0


@pytest.mark.parametrize("port", ["free", "99999"])
def test_a_bridge_without_a_broker_says_so_in_one_line(port: str) -> None:
    found = subprocess.run(
        [sys.executable, str(EXAMPLE), "--broker", "127.0.0.1", "--port", str(free_port()) if port == "free" else port],
        env=environment(domain()),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert found.returncode == 1
    assert found.stderr.startswith("mqtt_bridge: no connection to the broker 127.0.0.1:")
    assert found.stderr.count("\n") == 1


@brokered
def test_a_bridge_survives_an_empty_diagnosis_and_says_that_its_broker_is_gone(tmp_path: Path) -> None:
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

    number, log = domain(), tmp_path / "bridge.log"
    with graph_client(number) as client, ExitStack() as stack:
        publisher = client.node.create_publisher(DiagnosticArray, DIAGNOSIS.resolved(NAMESPACE), 10)
        with broker(tmp_path) as port, listener(port) as received:
            example = stack.enter_context(bridge(number, log, "--broker", "127.0.0.1", "--port", str(port)))
            client.until(lambda: publisher.get_subscription_count() == 2, "the subscription of the bridge")
            publisher.publish(DiagnosticArray())
            publisher.publish(DiagnosticArray(status=[DiagnosticStatus(message="healthy")]))
            client.until(lambda: received.values(DIAGNOSES), "the diagnosis over MQTT")
            assert [value["verdict"] for value in received.values(DIAGNOSES)] == ["healthy"]
        place = f"the broker 127.0.0.1:{port}"
        client.until(lambda: f"no connection to {place}" in log.read_text(), "the sentence on the broker that is gone")
        assert f"connected to {place}" in log.read_text()
        example.send_signal(signal.SIGINT)
        assert example.wait(PATIENCE) == 0


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["--namespace", "a b"], 2, "--namespace a b: Invalid namespace"),
        (["--port", "x"], 2, "argument --port: invalid int value: 'x'"),
    ],
)
def test_invalid_arguments_of_the_bridge_are_refused(arguments: list[str], status: int, sentence: str) -> None:
    found = subprocess.run(
        [sys.executable, str(EXAMPLE), *arguments], env=environment(domain()), capture_output=True, text=True, timeout=PATIENCE
    )
    assert found.returncode == status
    assert sentence in found.stderr
    assert "Traceback" not in found.stderr
