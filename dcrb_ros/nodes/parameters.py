"""The ROS parameters of a node: declared from a schema, and checked or refused with the schema's error messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from dcrb_ros.nodes.refusals import shortened
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten, parameter_fields, validated
from dcrb_ros.settings.sections import OF_ROS

Model = TypeVar("Model", bound=Group)


class ParameterNode(Node):
    """A node whose parameters are those of a schema."""

    def __init__(self, name: str, namespace: str) -> None:
        super().__init__(name, namespace=namespace, automatically_declare_parameters_from_overrides=True)

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
        given: Mapping[str, Any] = self.get_parameters_by_prefix("")
        overrides = {key: parameter.value for key, parameter in given.items() if key not in OF_ROS}
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
