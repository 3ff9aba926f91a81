"""Base class of the nodes: parameters from a schema, checked with the schema's error messages."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter

from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.statuses import Status, encode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, NAMESPACE, VIBRATION, Message, Topic
from dcrb_ros.nodes.other_publishers import OtherPublishers
from dcrb_ros.nodes.publisher import Publisher, message_class, qos
from dcrb_ros.nodes.refusals import shortened
from dcrb_ros.nodes.subscriber_wait import SubscriberWait
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten, parameter_fields, validated
from dcrb_ros.settings.sections import OF_ROS

Model = TypeVar("Model", bound=Group)
POLL_PERIOD = 0.05
"""Wall time between two counts of subscribers [s]."""


class BenchNode(Node):
    """A node with the life cycle that `dcrb_ros.nodes.ros.run_node` drives: construct, `start`, spin until `ended`, `close`."""

    purpose = "node"
    """Name of what the node runs, for the message about its failure."""

    def __init__(self, name: str) -> None:
        super().__init__(name, namespace=NAMESPACE, automatically_declare_parameters_from_overrides=True)

    def start(self) -> None:
        """Start the work of the node; its callbacks are not served yet."""

    @property
    def ended(self) -> bool:
        """Whether the work has ended by itself."""
        return False

    @property
    def failure(self) -> Exception | None:
        """The exception that ended the work, if one did."""
        return None

    def close(self) -> None:
        """End the work; also called if it has not started."""

    def on_parameters(self, changes: dict[str, Any]) -> None:
        """Apply a requested change of parameters.

        Raises:
            Refusal: it is invalid; nothing is changed.
        """

    def declare(self, model: type[Model], *, run_time: Sequence[str] = (), adjust: Callable[[Model], Model] = lambda model: model) -> Model:
        """Declare every parameter of a model with type, range and description; return the model with the node's overrides.

        Args:
            model: the schema.
            run_time: keys of the parameters that may change while the node runs; the others are read-only.
            adjust: changes the model with the overrides before it is declared.

        Raises:
            Refusal: an override is unknown, mistyped or out of range.
        """
        found: Mapping[str, Any] = self.get_parameters_by_prefix("")
        overrides = {key: parameter.value for key, parameter in found.items() if key not in OF_ROS}
        adjusted = adjust(validated(overrides, model, "parameters"))
        values = flatten(adjusted.model_dump())
        for field in parameter_fields(model):
            if self.has_parameter(field.key):
                self.undeclare_parameter(field.key)
            descriptor = _descriptor(field, read_only=field.key not in run_time)
            self.declare_parameter(field.key, values[field.key], descriptor, ignore_override=True)
        return adjusted

    def set_parameters_atomically(self, parameter_list: list[Any]) -> Any:
        """Apply a change of parameters that others request, or answer why not; an integer is accepted for a floating-point number.

        A read-only parameter may be set to the value that it has, as `ros2 param load` does with the file of `ros2 param dump`.
        `set_parameters`, which the node itself uses, does not call `on_parameters`.
        """
        given = (self._with_declared_type(parameter) for parameter in parameter_list)
        parameter_list = [parameter for parameter in given if not self._is_settled(parameter)]
        changes = {parameter.name: parameter.value for parameter in parameter_list if parameter.name not in OF_ROS}
        if changes:
            try:
                self.on_parameters(changes)
            except Refusal as refusal:
                return SetParametersResult(successful=False, reason=shortened(str(refusal)))
        return super().set_parameters_atomically(parameter_list)

    def _is_settled(self, parameter: Any) -> bool:
        """Return whether a parameter is read-only and has the requested value."""
        name = parameter.name
        if not (self.has_parameter(name) and self.describe_parameter(name).read_only):
            return False
        present = self.get_parameter(name)
        return bool(present.type_ == parameter.type_ and present.value == parameter.value)

    def _with_declared_type(self, parameter: Any) -> Any:
        """Return a parameter with an integer converted to a floating-point number if it is declared as one."""
        integer = parameter.type_ == Parameter.Type.INTEGER and self.has_parameter(parameter.name)
        if integer and self.get_parameter(parameter.name).type_ == Parameter.Type.DOUBLE:
            return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
        return parameter

    def subscribe(self, topic: Topic, callback: Callable[[bytes], None]) -> Any:
        """Pass the bytes of each message on a topic to ``callback``; return the subscription."""

        def receive(data: Any) -> None:
            callback(bytes(data))

        return self.create_subscription(message_class(topic), topic.name, receive, qos(topic), raw=True)

    def offer_action(self, kind: Any, name: str, execute: Callable[[Any], Awaitable[Any]], /, *, callback_group: Any = None) -> Any:
        """Offer an action whose goals are all accepted, and may be cancelled; ``execute`` gets the handle of a goal."""
        from rclpy.action.server import ActionServer, CancelResponse

        return ActionServer(self, kind, name, execute, callback_group=callback_group, cancel_callback=lambda _: CancelResponse.ACCEPT)

    def start_with_subscribers(self, publisher: Publisher, listeners: int, timeout: float, start: Callable[[], None]) -> None:
        """Call ``start`` once ``listeners`` subscribers to the waveform have joined, or after ``timeout`` of wall time [s] without them."""
        wait = SubscriberWait(publisher, listeners, timeout)
        if listeners:
            plural = "" if listeners == 1 else "s"
            self.get_logger().info(f"waiting for {listeners} subscriber{plural} to {VIBRATION.name}, at most {timeout:g} s")

        def poll() -> None:
            if wait.over():
                timer.cancel()
                if wait.missing:
                    self.get_logger().warning(wait.missing)
                start()

        timer = self.repeat(POLL_PERIOD, poll)

    def watch_publishers(self, *topics: Topic) -> OtherPublishers:
        """Warn about other publishers on topics of this node, within two seconds."""
        others = OtherPublishers(self, topics, self.get_logger().warning)
        self.repeat(1.0, others.look)
        return others

    def diagnostics(self, status: Status, time_ns: int, frame: str = FRAME) -> Message:
        """Return a status for /diagnostics, stamped with the wall clock, or with the simulated time [ns] if ``use_sim_time`` is set."""
        simulated = self.get_parameter("use_sim_time").value
        stamp_ns = time_ns if simulated else self.get_clock().now().nanoseconds
        return Message(BENCH_DIAGNOSTICS, stamp_ns, encode_diagnostics(stamp_ns, [status], frame))

    def repeat(self, period: float, callback: Callable[[], None]) -> Any:
        """Return a timer that calls ``callback`` every ``period`` of wall time [s], whatever ``use_sim_time`` says."""
        return self.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def _descriptor(field: ParameterField, *, read_only: bool) -> Any:
    unit = f" [{field.unit}]" if field.unit != "-" else ""
    descriptor = ParameterDescriptor(name=field.key, description=f"{field.description}{unit}", read_only=read_only)
    if field.low is not None and field.high is not None:
        if field.kind is int:
            descriptor.integer_range = [IntegerRange(from_value=int(field.low), to_value=int(field.high), step=1)]
        else:
            descriptor.floating_point_range = [FloatingPointRange(from_value=float(field.low), to_value=float(field.high), step=0.0)]
    elif field.choices:
        descriptor.additional_constraints = "one of " + ", ".join(field.choices)
    return descriptor
