"""A deliberately bad detector that fails the exam: it alarms on any line at BPFO, but a healthy bearing also has one."""

import json
from contextlib import suppress

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

SAMPLE = np.dtype([("t", "<u4"), ("ax", "<f4"), ("ay", "<f4"), ("shaft_angle", "<f4")])
about, blocks = {}, []


def on_block(message: PointCloud2) -> None:
    blocks.append(np.frombuffer(message.data, SAMPLE))
    if not about or sum(map(len, blocks)) < about["sampling_rate"]:
        return
    samples = np.concatenate(blocks)
    blocks.clear()
    envelope, angle = np.abs(samples["ay"] - samples["ay"].mean()), np.unwrap(samples["shaft_angle"].astype(float))
    order = about["orders"]["BPFO"]
    # The line at BPFO and its neighbourhood, with which it is compared. The mistake is the conclusion drawn from it.
    lines = [abs(np.mean(envelope * np.exp(-1j * (order + shift) * angle))) for shift in np.linspace(-1.0, 1.0, 21)]
    level = 20.0 * np.log10(max(lines[8:13]) / np.median(lines))
    verdict = "outer_ring" if level > 6.0 else "healthy"
    values = [KeyValue(key="verdict", value=verdict), KeyValue(key="score", value=f"{level:.2f}")]
    status = DiagnosticStatus(level=DiagnosticStatus.ERROR, name="naive_detector", message=verdict, values=values)
    diagnosis = DiagnosticArray(status=[status])
    diagnosis.header.stamp = message.header.stamp
    publisher.publish(diagnosis)


rclpy.init()
node = rclpy.create_node("naive_detector", namespace="dcrb")
publisher = node.create_publisher(DiagnosticArray, "diagnosis", 10)
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, "outer_ring/sensor", lambda message: about.update(json.loads(message.data)), latched)
node.create_subscription(PointCloud2, "outer_ring/vibration", on_block, QoSProfile(depth=200))
with suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
