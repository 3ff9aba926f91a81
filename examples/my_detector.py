"""A simple fault detector as a ROS 2 node: dcrb score smoke --node "python3 examples/my_detector.py"."""

import json
from contextlib import suppress

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile
from scipy.signal import butter, sosfilt
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

SAMPLE = np.dtype([("t", "<u4"), ("ax", "<f4"), ("ay", "<f4"), ("shaft_angle", "<f4")])
about, blocks, healthy = {}, [], []  # sensor description, blocks of the current window, lines of the first two windows


def on_block(message: PointCloud2) -> None:
    blocks.append(np.frombuffer(message.data, SAMPLE))
    if not about or sum(map(len, blocks)) < about["sampling_rate"]:  # windows of one second
        return
    samples = np.concatenate(blocks)
    blocks.clear()
    band = butter(4, 2000.0, "highpass", fs=about["sampling_rate"], output="sos")
    envelope, angle = sosfilt(band, samples["ay"]) ** 2, np.unwrap(samples["shaft_angle"].astype(float))
    # Amplitudes of two lines of the squared envelope spectrum over the shaft angle, which a changing speed does not smear.
    lines = [abs(np.mean(envelope * np.exp(-1j * about["orders"][name] * angle))) for name in ("BPFO", "BPFI")]
    healthy.extend([lines] if len(healthy) < 2 else [])
    rise = np.array(lines) / np.max(healthy, axis=0)
    verdict = ("outer_ring", "inner_ring")[np.argmax(lines * (rise > 4.0))] if rise.max() > 4.0 else "healthy"
    publish(message.header.stamp, verdict, float(rise.max()))


def publish(stamp, verdict: str, score: float) -> None:
    values = [KeyValue(key="verdict", value=verdict), KeyValue(key="score", value=str(score))]
    level = DiagnosticStatus.OK if verdict == "healthy" else DiagnosticStatus.ERROR
    status = DiagnosticStatus(level=level, name="my_detector", message=verdict, values=values)
    diagnosis = DiagnosticArray(status=[status])
    diagnosis.header.stamp = stamp  # simulated time of the samples, not the wall clock
    publisher.publish(diagnosis)


rclpy.init()
node = rclpy.create_node("my_detector", namespace="dcrb")
publisher = node.create_publisher(DiagnosticArray, "diagnosis", 10)
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, "outer_ring/sensor", lambda message: about.update(json.loads(message.data)), latched)
node.create_subscription(PointCloud2, "outer_ring/vibration", on_block, QoSProfile(depth=200))
with suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
