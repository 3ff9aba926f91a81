"""Diagnoses and features of a running bench as JSON over MQTT: python examples/mqtt_bridge.py --broker localhost. Needs paho-mqtt."""

import argparse
import json
import math
import signal
import threading

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState


def diagnosis_json(message: DiagnosticArray) -> str:
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
    return json.dumps({"time": seconds(message), **dict(zip(message.name, message.position, strict=True))})


def seconds(message: DiagnosticArray | JointState) -> float:
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def main() -> None:
    import paho.mqtt.client as mqtt

    parser = argparse.ArgumentParser(description="Diagnoses and features of a bench as JSON over MQTT.")
    parser.add_argument("--broker", default="localhost")
    parser.add_argument("--port", type=int, default=1883)
    parser.add_argument("--namespace", default="dcrb")
    options = parser.parse_args()

    broker = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    # Without a limit, an absent broker would fill the memory; it reconnects by itself.
    broker.max_queued_messages_set(1000)
    try:
        broker.connect(options.broker, options.port)
    except (OSError, ValueError) as error:
        parser.exit(1, f"mqtt_bridge: no connection to the broker {options.broker}:{options.port}: {error}\n")
    broker.loop_start()
    stopped = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("mqtt_bridge", namespace=options.namespace)

    def forward(kind: type, topic: str, encode, *, retain: bool) -> None:
        name = f"{options.namespace}/{topic}"
        node.create_subscription(
            kind, topic, lambda message: broker.publish(name, encode(message), qos=1, retain=retain), QoSProfile(depth=200)
        )

    forward(DiagnosticArray, "diagnosis", diagnosis_json, retain=True)
    forward(JointState, "outer_ring/features", features_json, retain=False)
    while not stopped.is_set():
        rclpy.spin_once(node, timeout_sec=0.1)
    broker.disconnect()
    broker.loop_stop()


if __name__ == "__main__":
    main()
