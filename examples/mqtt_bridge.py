"""Diagnoses and features of a running bench as JSON over MQTT: python examples/mqtt_bridge.py --broker localhost. Needs paho-mqtt."""

import argparse
import json
import math
import signal
import sys
import threading

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.exceptions import InvalidNamespaceException
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_namespace import validate_namespace
from sensor_msgs.msg import JointState


def diagnosis_json(message: DiagnosticArray) -> str | None:
    """Return the diagnosis as JSON; None for a message without one."""
    if not message.status:
        return None
    status = message.status[0]
    return json.dumps({"time": seconds(message), "verdict": status.message, **{pair.key: value_of(pair.value) for pair in status.values}})


def value_of(text: str) -> float | str:
    """Return the number in a text; one that is not finite stays a text, since JSON has none."""
    try:
        number = float(text)
    except ValueError:
        return text
    return number if math.isfinite(number) else text


def features_json(message: JointState) -> str:
    """Return the features as JSON."""
    values = zip(message.name, message.position, strict=False)  # another publisher may send fewer values than names
    return json.dumps({"time": seconds(message), **{name: value_of(repr(value)) for name, value in values}})


def seconds(message: DiagnosticArray | JointState) -> float:
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def say(sentence: str) -> None:
    print(f"mqtt_bridge: {sentence}", file=sys.stderr, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Diagnoses and features of a bench as JSON over MQTT.")
    parser.add_argument("--broker", default="localhost")
    parser.add_argument("--port", type=int, default=1883)
    parser.add_argument("--namespace", default="dcrb")
    options = parser.parse_args()
    options.namespace = options.namespace.strip("/")
    try:
        validate_namespace(f"/{options.namespace}")
    except InvalidNamespaceException as error:
        parser.error(f"--namespace {options.namespace}: {error}")
    try:
        import paho.mqtt.client as mqtt

        broker = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    except (ImportError, AttributeError):
        parser.exit(1, 'mqtt_bridge: paho-mqtt 2 is missing: pip install "paho-mqtt>=2"\n')

    stopped = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("mqtt_bridge", namespace=options.namespace)

    # Without a limit, an absent broker would fill the memory; it reconnects by itself.
    broker.max_queued_messages_set(1000)
    place = f"the broker {options.broker}:{options.port}"

    def connected(client, data, flags, reason, properties) -> None:
        say(f"{place} refuses the connection: {reason}" if reason.is_failure else f"connected to {place}")

    def disconnected(client, data, flags, reason, properties) -> None:
        if reason.is_failure:
            say(f"no connection to {place} ({reason}): connecting again, up to 1000 messages are kept")

    broker.on_connect, broker.on_disconnect = connected, disconnected
    try:
        broker.connect(options.broker, options.port)
    except (OSError, ValueError) as error:
        parser.exit(1, f"mqtt_bridge: no connection to {place}: {error}\n")
    broker.loop_start()

    def forward(kind: type, topic: str, encode, *, retain: bool) -> None:
        name = f"{node.get_namespace()}/{topic}".strip("/")

        def publish(message) -> None:
            if (text := encode(message)) is not None:
                broker.publish(name, text, qos=1, retain=retain)

        node.create_subscription(kind, topic, publish, QoSProfile(depth=200))

    forward(DiagnosticArray, "diagnosis", diagnosis_json, retain=True)
    forward(JointState, "outer_ring/features", features_json, retain=False)
    while not stopped.is_set():
        rclpy.spin_once(node, timeout_sec=0.1)
    broker.disconnect()
    broker.loop_stop()


if __name__ == "__main__":
    main()
