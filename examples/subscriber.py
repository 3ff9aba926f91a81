"""Blocks of the waveform as numpy arrays: python examples/subscriber.py, beside a running bench."""

import signal
from contextlib import suppress

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2

SAMPLE = np.dtype([("t", "<u4"), ("ax", "<f4"), ("ay", "<f4"), ("shaft_angle", "<f4")])


def on_block(message: PointCloud2) -> None:
    samples = np.frombuffer(message.data, SAMPLE)
    start = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
    print(f"{start:9.3f} s  {len(samples)} samples  rms {np.std(samples['ay']):8.1f} m/s^2", flush=True)


signal.signal(signal.SIGINT, lambda *_: None)  # rclpy's own handler ends the spin; an interrupt amid a message would not end well
rclpy.init()
node = rclpy.create_node("subscriber", namespace="dcrb")
node.create_subscription(PointCloud2, "outer_ring/vibration", on_block, QoSProfile(depth=200))
with suppress(ExternalShutdownException):
    rclpy.spin(node)
