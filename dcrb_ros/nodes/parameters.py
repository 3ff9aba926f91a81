"""The ROS parameters of a node: declared from a schema, and checked or refused with the schema's error messages."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import yaml
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from dcrb_ros.messages.topics import BENCH, COMMANDS, DETECTED, ENVELOPE_SPECTRUM, SIMULATED, WAYSIDE
from dcrb_ros.messages.topics.vehicle import VEHICLE, VEHICLE_COMMANDS
from dcrb_ros.nodes.qos_overrides import check_overrides, is_override
from dcrb_ros.nodes.refusal_counts import shortened
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import ParameterField, wrong_type
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten, parameter_fields, validated
from dcrb_ros.settings.sections import OF_ROS
from dcrb_ros.stream.vehicle_description import SIDES
from dcrb_ros.text.yaml import parsed
from dcrb_ros.vehicle.file import DEFAULT_X

Model = TypeVar("Model", bound=Group)
OF_BOXES = tuple(
    topic.below(f"{axle}/{side}") for axle in DEFAULT_X for side in SIDES for topic in (*SIMULATED, *COMMANDS, ENVELOPE_SPECTRUM)
)
"""Topics of the axle boxes of a vehicle."""
LONGEST_NUMBER = 100
"""Longest text that is read as a number [characters]."""


def changed_by_topic(key: str, topic: str) -> Refusal:
    """Return the refusal of a parameter that a command changes."""
    return Refusal(f"parameters: {key} changes by the topic {topic}; the parameter is its value at the start")


def not_while_running(parameter: str, remedy: str) -> Refusal:
    """Return the refusal of a parameter that a running node does not take."""
    return Refusal(f"parameters: {parameter} cannot be set while the node runs: {remedy}")


class ParameterNode(Node):
    """A node whose parameters are those of a schema."""

    def __init__(self, name: str, namespace: str) -> None:
        super().__init__(name, namespace=namespace, automatically_declare_parameters_from_overrides=True)
        given: Mapping[str, Any] = self.get_parameters_by_prefix("")
        overrides = {key: parameter.value for key, parameter in given.items() if is_override(key)}
        topics = (*SIMULATED, *DETECTED, *WAYSIDE, *BENCH, *COMMANDS, *VEHICLE, *VEHICLE_COMMANDS.values(), *OF_BOXES)
        check_overrides(overrides, (self.resolve_topic_name(topic.name) for topic in topics))
        for key in overrides:  # declared again, read-only, by the publisher or subscription
            self.undeclare_parameter(key)
        self._fields: dict[str, ParameterField] = {}
        """Declared parameters of the schema by their keys."""

    def declare_parameters(self, namespace: str, parameters: list[Any], ignore_override: bool = False) -> Any:
        """Declare parameters; the constructor of rclpy so declares those that are given to the node.

        Raises:
            Refusal: one has no value, as ROS reads an empty list.
        """
        for name, *about in parameters:
            if about and about[0] is None:
                raise Refusal(f"parameters: {name} has no value, as an empty list: give one, or leave it out")
        return super().declare_parameters(namespace, parameters, ignore_override)

    def on_parameters(self, changes: dict[str, Any]) -> None:
        """Apply a requested change of parameters; a node that overrides this method accepts the declared ones.

        The simulators do, and `bearing.runtime_change.altered` says which they accept.

        Raises:
            Refusal: it is invalid; nothing is changed.
        """
        for key, value in changes.items():
            if key in self._fields:
                fixed = f"{key} is fixed while the node runs: give it at the start"
                raise Refusal(f"parameters: {wrong_type(self._fields[key], value) or fixed}")

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
        overrides = {key: parameter.value for key, parameter in given.items() if not is_of_ros(key)}
        adjusted = adjust(validated(overrides, model, "parameters"))
        values = flatten(adjusted.model_dump())
        self._fields = {field.key: field for field in parameter_fields(model)}
        for field in self._fields.values():
            self.declare_field(field.key, field, values[field.key], read_only=field.key not in run_time)
        return adjusted

    def declare_field(self, key: str, field: ParameterField, value: Any, *, read_only: bool = False) -> None:
        """Declare a parameter under a key, with type, range and description of a field and a checked value."""
        if self.has_parameter(key):
            self.undeclare_parameter(key)
        self.declare_parameter(key, value, _descriptor(key, field, read_only=read_only), ignore_override=True)

    def set_parameters_atomically(self, parameter_list: list[Any]) -> Any:
        """Apply a change of parameters that others request, or answer why not.

        A read-only parameter may be set to the value that it has, also in another type (`_with_declared_type`). `ros2 param load` therefore
        accepts the file of `ros2 param dump`. `set_parameters`, which the node itself uses, does not call `on_parameters`.
        """
        given = (self._with_declared_type(parameter) for parameter in parameter_list)
        parameter_list = [parameter for parameter in given if not self._is_settled(parameter)]
        changes = {parameter.name: _plain(parameter.value) for parameter in parameter_list if not is_of_ros(parameter.name)}
        if changes:
            try:
                self._check_of_ros(parameter_list)  # once `on_parameters` has applied the others, none may be refused
                self.on_parameters(changes)
            except Refusal as refusal:
                return SetParametersResult(successful=False, reason=shortened(str(refusal)))
        return super().set_parameters_atomically(parameter_list)

    def _check_of_ros(self, parameters: Iterable[Any]) -> None:
        """Refuse parameters of ROS that ROS would refuse: those that are unknown or read-only here, or have a value of another type."""
        for parameter in parameters:
            name = parameter.name
            if not is_of_ros(name) or (
                self.has_parameter(name)
                and not self.describe_parameter(name).read_only
                and parameter.type_ == self.get_parameter(name).type_
            ):
                continue
            raise not_while_running(f"{name} = {parameter.value!r}", "leave it out, nothing is changed")

    def _is_settled(self, parameter: Any) -> bool:
        """Return whether a parameter is read-only and has the requested value."""
        name = parameter.name
        if not (self.has_parameter(name) and self.describe_parameter(name).read_only):
            return False
        present = self.get_parameter(name)
        return bool(present.type_ == parameter.type_ and present.value == parameter.value)

    def _with_declared_type(self, parameter: Any) -> Any:
        """Return a parameter with a value of the declared type if the given one means such a value.

        `ros2 param load` reads with YAML 1.1: ``5e-06`` is a text there, and the text ``2026`` is a number.
        """
        # A request without a value would delete the parameter; it is no empty text.
        if not self.has_parameter(parameter.name) or parameter.type_ == Parameter.Type.NOT_SET:
            return parameter
        present, number = self.get_parameter(parameter.name), parameter.value
        numeric = present.type_ in (Parameter.Type.DOUBLE, Parameter.Type.INTEGER)
        with suppress(yaml.YAMLError, Refusal, ValueError):
            if present.type_ == Parameter.Type.STRING and parameter.type_ != Parameter.Type.STRING:
                return present if yaml.safe_load(present.value) == parameter.value else parameter
            if numeric and isinstance(number, str) and len(number) <= LONGEST_NUMBER:
                number = parsed(number)
        if type(number) in (int, float) and present.type_ == Parameter.Type.DOUBLE:
            return Parameter(parameter.name, Parameter.Type.DOUBLE, float(number))
        if type(number) is int and present.type_ == Parameter.Type.INTEGER and -(2**63) <= number < 2**63:
            return Parameter(parameter.name, Parameter.Type.INTEGER, number)
        return parameter


def _plain(value: Any) -> Any:
    """Return the value of a parameter as a file gives it: that of a request may be an array."""
    return value.tolist() if isinstance(value, array) else value


def is_of_ros(key: str) -> bool:
    """Return whether a parameter is one that every node of ROS has."""
    return key in OF_ROS or is_override(key)


def _descriptor(key: str, field: ParameterField, *, read_only: bool) -> Any:
    unit = f" [{field.unit}]" if field.unit != "-" else ""
    descriptor = ParameterDescriptor(name=key, description=f"{field.description}{unit}", read_only=read_only)
    if field.low is not None and field.high is not None:
        if field.kind is int:
            descriptor.integer_range = [IntegerRange(from_value=int(field.low), to_value=int(field.high), step=1)]
        else:
            descriptor.floating_point_range = [FloatingPointRange(from_value=float(field.low), to_value=float(field.high), step=0.0)]
    elif field.choices:
        descriptor.additional_constraints = "one of " + ", ".join(field.choices)
    return descriptor
