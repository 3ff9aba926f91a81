"""Warnings about other publishers on the topics of a node, with a made-up graph."""

from __future__ import annotations

from types import SimpleNamespace

from dcrb_ros.messages.topics import CLOCK, DIAGNOSIS, VIBRATION
from dcrb_ros.nodes.other_publishers import OtherPublishers

OWN = ("/dcrb", "simulator")


class Graph:
    """Publishers by topic, as seen from the node /dcrb/simulator."""

    def __init__(self) -> None:
        self.known = {"/dcrb/outer_ring/vibration": [OWN], "/clock": [OWN]}
        self.publishers = [SimpleNamespace(topic_name=topic) for topic in self.known]
        """The node's own."""
        self.remapped: dict[str, str] = {}

    def resolve_topic_name(self, topic: str) -> str:
        name = f"{OWN[0]}/{topic}" if not topic.startswith("/") else topic
        return self.remapped.get(name, name)

    def get_fully_qualified_name(self) -> str:
        return "/".join(OWN)

    def get_publishers_info_by_topic(self, topic: str) -> list[SimpleNamespace]:
        return [SimpleNamespace(node_namespace=namespace, node_name=name) for namespace, name in self.known[topic]]


def test_a_second_node_is_reported_once_with_the_remedy() -> None:
    graph, said = Graph(), list[str]()
    others = OtherPublishers(graph, (VIBRATION, CLOCK), said.append)
    others.look()
    assert (others.names, said) == ([], [])
    graph.known["/dcrb/outer_ring/vibration"].append(("/dcrb", "replayer"))
    for _ in range(3):
        others.look()
    assert others.names == ["/dcrb/replayer"]
    assert said == [
        "/dcrb/replayer also publishes on /dcrb/outer_ring/vibration, and subscribers receive a mixture: give each bench its own "
        "namespace (--ros-args -r __ns:=/NAME) or its own ROS_DOMAIN_ID"
    ]


def test_a_remapped_topic_is_looked_for_under_its_new_name() -> None:
    graph, said = Graph(), list[str]()
    graph.remapped["/dcrb/outer_ring/vibration"] = "/accel"
    # The middleware itself remaps the name of a topic that it is asked about.
    graph.known["/accel"] = graph.known["/dcrb/outer_ring/vibration"]
    graph.publishers = [SimpleNamespace(topic_name="/accel")]
    others = OtherPublishers(graph, (VIBRATION,), said.append)
    others.look()
    assert (others.names, said) == ([], [])
    graph.known["/accel"].append(("/dcrb", "replayer"))
    others.look()
    assert said[0].startswith("/dcrb/replayer also publishes on /accel")


def test_a_second_node_of_the_same_name_is_reported() -> None:
    graph, said = Graph(), list[str]()
    graph.known["/dcrb/outer_ring/vibration"].append(OWN)
    others = OtherPublishers(graph, (VIBRATION,), said.append)
    others.look()
    assert others.names == ["/dcrb/simulator"]
    assert len(said) == 1


def test_a_node_of_the_same_name_is_reported_where_this_one_does_not_publish() -> None:
    graph, said = Graph(), list[str]()
    graph.known["/dcrb/diagnosis"] = [OWN]
    others = OtherPublishers(graph, (DIAGNOSIS,), said.append)
    others.look()
    assert others.names == ["/dcrb/simulator"]
    assert len(said) == 1


def test_a_second_clock_is_reported_with_its_own_remedy_and_forgotten_when_it_ends() -> None:
    graph, said = Graph(), list[str]()
    others = OtherPublishers(graph, (CLOCK,), said.append)
    graph.known["/clock"] = [("/", "player"), OWN]
    others.look()
    graph.known["/clock"] = [OWN]
    others.look()
    assert others.names == []
    assert said == ["/player also publishes on /clock, and subscribers receive a mixture: let one of them publish it"]


UNKNOWN = ("_NODE_NAMESPACE_UNKNOWN_", "_NODE_NAME_UNKNOWN_")
"""What rmw_dds_common reports until it has discovered the node of a publisher."""


def test_a_publisher_is_reported_by_its_name_if_it_is_known_at_the_next_look() -> None:
    graph, said = Graph(), list[str]()
    others = OtherPublishers(graph, (VIBRATION,), said.append)
    for found in ([OWN, UNKNOWN], [OWN, ("/dcrb", "replayer")], [OWN], [OWN, UNKNOWN], [OWN]):
        graph.known["/dcrb/outer_ring/vibration"] = found
        others.look()
    assert [sentence.split(" also ")[0] for sentence in said] == ["/dcrb/replayer"]
    assert others.names == []


def test_a_publisher_that_stays_without_a_name_is_reported_at_the_second_look() -> None:
    graph, said = Graph(), list[str]()
    others = OtherPublishers(graph, (VIBRATION,), said.append)
    graph.known["/dcrb/outer_ring/vibration"] = [OWN, UNKNOWN]
    for _ in range(4):
        others.look()
    assert [sentence.split(" also ")[0] for sentence in said] == ["a node without a known name"]
    assert others.names == ["a node without a known name"]
