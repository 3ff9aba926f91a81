"""A ROS node whose parameters are refused in our words: with the value, the range and the remedy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from dcrb_ros.nodes.refusals import shortened
from dcrb_ros.runtime.refusal import Refusal

OWN = ("use_sim_time", "start_type_description_service")
"""Parameters that rclpy declares by itself."""


class ObedientNode(Node):
    """Lets its owner carry out or refuse what others ask of its parameters, before rclpy keeps them.

    What the node sets itself with ``set_parameters`` is kept without asking.
    """

    obey: Callable[[dict[str, Any]], None] | None = None

    def set_parameters_atomically(self, parameter_list: list[Any]) -> Any:
        """Carry out a change of parameters, or say why not; 1 will do for 1.0."""
        parameter_list = [self._as_declared(parameter) for parameter in parameter_list]
        changes = {parameter.name: parameter.value for parameter in parameter_list if parameter.name not in OWN}
        if self.obey is not None and changes:
            try:
                self.obey(changes)
            except Refusal as refusal:
                return SetParametersResult(successful=False, reason=shortened(str(refusal)))
        return super().set_parameters_atomically(parameter_list)

    def _as_declared(self, parameter: Any) -> Any:
        """Return a parameter with its integer as a floating-point number, where such a one is declared."""
        whole = parameter.type_ == Parameter.Type.INTEGER and self.has_parameter(parameter.name)
        if whole and self.get_parameter(parameter.name).type_ == Parameter.Type.DOUBLE:
            return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))
        return parameter
