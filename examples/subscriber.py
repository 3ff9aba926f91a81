"""Blocks of the waveform as numpy arrays: python examples/subscriber.py, while a bench runs."""

import signal
import threading

import numpy as np
import rclpy
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import PointCloud2

SAMPLE = np.dtype([("t", "<u4"), ("ax", "<f4"), ("ay", "<f4"), ("shaft_angle", "<f4")])


def on_block(message: PointCloud2) -> None:
    samples = np.frombuffer(message.data, SAMPLE)
    start = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
    print(f"{start:9.3f} s  {len(samples)} samples  rms {np.std(samples['ay']):8.1f} m/s^2", flush=True)


stopped = threading.Event()
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda *_: stopped.set())  # rclpy's own handlers may shut down the context during a spin
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node("subscriber", namespace="dcrb")
node.create_subscription(PointCloud2, "outer_ring/vibration", on_block, QoSProfile(depth=200))
while not stopped.is_set():
    rclpy.spin_once(node, timeout_sec=0.1)
