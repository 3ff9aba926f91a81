"""Warnings about other nodes that publish on the topics of a node: their subscribers would receive a mixture."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from dcrb_ros.messages.topics import CLOCK, Topic

REMEDIES = {CLOCK: "let one of them publish it"}
"""What to do about two publishers of a topic that is not in the namespace of the bench."""
NAMESPACES = "give each bench its own namespace (--ros-args -r __ns:=/NAME) or its own ROS_DOMAIN_ID"

PLACEHOLDER, UNNAMED = "_NODE_NAME_UNKNOWN_", "a node without a known name"
"""What the middleware reports as the name of a node whose publisher was discovered before the node itself, and what is reported instead."""


class OtherPublishers:
    """Looks for other publishers on some topics of a node, and warns when their names change."""

    def __init__(self, node: Any, topics: Iterable[Topic], warn: Callable[[str], object]) -> None:
        self._node, self._topics, self._warn = node, tuple(topics), warn
        self._found: dict[Topic, list[str]] = {}
        self._unnamed: set[Topic] = set()
        """Topics on which the last `look` found a publisher without a name."""

    def look(self) -> None:
        """Look for them, and warn. A publisher without a name is left to the next look, in which it mostly has one."""
        for topic in self._topics:
            name = self._node.resolve_topic_name(topic.name)  # remapped, as the node publishes it
            others = self._others(name)
            if UNNAMED in others and topic not in self._unnamed:
                self._unnamed.add(topic)
                continue
            if UNNAMED not in others:
                self._unnamed.discard(topic)
            if others != self._found.get(topic, []) and others:
                remedy = REMEDIES.get(topic, NAMESPACES)
                self._warn(f"{', '.join(others)} also publishes on {name}, and subscribers receive a mixture: {remedy}")
            self._found[topic] = others

    @property
    def names(self) -> list[str]:
        """Names of the nodes found by the last `look`."""
        return sorted({name for names in self._found.values() for name in names})

    def _others(self, topic: str) -> list[str]:
        """Return the names of the publishers on a topic without one of this node's name; a node of the same name remains."""
        publishers = [
            UNNAMED if about.node_name == PLACEHOLDER else f"{about.node_namespace.rstrip('/')}/{about.node_name}"
            for about in self._node.get_publishers_info_by_topic(topic)
        ]
        name = self._node.get_fully_qualified_name()
        if name in publishers and any(publisher.topic_name == topic for publisher in self._node.publishers):
            publishers.remove(name)
        return sorted(publishers)
