"""Read, command and change a running bench with rclpy, as the command ros2 does: python examples/control.py."""

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool, Trigger

TIMEOUT = 30.0
"""Longest wait for the bench [s]."""


def call(node, kind, name, **fields):
    """Call a service and return its answer: ros2 service call."""
    client = node.create_client(kind, name)
    if not client.wait_for_service(TIMEOUT):
        raise SystemExit(f"no bench offers the service {name} in {node.get_namespace()}: start dcrb bench")
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future, timeout_sec=TIMEOUT)
    if not future.done():
        raise SystemExit(f"the service {name} has not answered in {TIMEOUT:g} s: look at the bench")
    return future.result()


def change(node, **values):
    """Set parameters of the simulator together: ros2 param set."""
    parameters = [Parameter(key.replace("__", "."), value=value).to_parameter_msg() for key, value in values.items()]
    return call(node, SetParametersAtomically, "simulator/set_parameters_atomically", parameters=parameters).result


def next_message(node, kind, name, quality=10):
    """Return the next message on a topic: ros2 topic echo --once."""
    future = rclpy.Future()
    subscription = node.create_subscription(kind, name, lambda message: future.done() or future.set_result(message), quality)
    rclpy.spin_until_future_complete(node, future, timeout_sec=TIMEOUT)
    node.destroy_subscription(subscription)
    return future.result()


def main():
    rclpy.init()
    node = rclpy.create_node("control", namespace="dcrb")

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # reliable, as every profile of rclpy
    print(call(node, SetBool, "pause", data=True).message)
    sensor = next_message(node, String, "outer_ring/sensor", latched)
    print(f"{sensor.data[:60]} ..." if sensor else "no sensor is described")
    print(call(node, Trigger, "step").message)
    print(change(node, faults__outer_1__width=0.002).reason or "the fault is accepted")

    speed = node.create_publisher(Float64, "command/speed", 10)
    for _ in range(100):
        if not speed.get_subscription_count():  # the command would be lost
            rclpy.spin_once(node, timeout_sec=0.1)
    speed.publish(Float64(data=140.0))

    print(call(node, SetBool, "pause", data=False).message)
    diagnosis = next_message(node, DiagnosticArray, "diagnosis")
    print(diagnosis.status[0].message if diagnosis and diagnosis.status else "no detector has answered")


if __name__ == "__main__":
    try:
        main()
    except (Exception, KeyboardInterrupt) as error:
        if rclpy.ok() and not isinstance(error, KeyboardInterrupt):
            raise
        raise SystemExit("stopped") from None  # Ctrl-C shuts down the context, which several exceptions report
