"""Quality of service given by parameters of ROS: ``qos_overrides.TOPIC.publisher.depth``, as every node of ROS may offer it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

from rclpy.qos import QoSPolicyKind
from rclpy.qos_overriding_options import QoSOverridingOptions

from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.sections import QOS_OVERRIDES

DEEPEST = 100_000
"""Largest depth [messages]."""
RELIABILITIES = ("reliable", "best_effort")


def overridable() -> QoSOverridingOptions:
    """Return the policies that parameters may override; history and durability are part of what a topic promises."""
    return QoSOverridingOptions((QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY))


def is_override(key: str) -> bool:
    """Return whether a parameter overrides a quality of service."""
    return key.startswith(f"{QOS_OVERRIDES}.")


def check_overrides(given: Mapping[str, Any], topics: Iterable[str]) -> None:
    """Check the overrides of a node against the absolute names of its possible topics.

    Raises:
        Refusal: no node of the bench reads one of them, or its value is invalid.
    """
    known = [
        f"{QOS_OVERRIDES}.{topic}.{end}.{policy}"
        for topic, end, policy in product(sorted(topics), ("publisher", "subscription"), ("depth", "reliability"))
    ]
    for key, value in given.items():
        if key not in known:
            raise Refusal(f"unknown parameter '{key}': depth and reliability of the topics of the bench can be set{nearest(key, known)}")
        if key.endswith("depth") and not (type(value) is int and 1 <= value <= DEEPEST):
            raise Refusal(f"{key} = {value!r} is not a whole number within 1 .. {DEEPEST}")
        if key.endswith("reliability") and value not in RELIABILITIES:
            raise Refusal(f"{key} = {value!r} is not one of {', '.join(RELIABILITIES)}{nearest(str(value), RELIABILITIES)}")
