"""The message types that the package has of its own are those of ROS 2 Jazzy."""

from __future__ import annotations

import pytest
from ros_types import typestore as types_of_jazzy

from dcrb_ros.messages.cdr import definition_of, typestore
from dcrb_ros.messages.topics import DETECTED, SIMULATED

OWN = sorted(typestore("std_msgs/msg/Header").types)


@pytest.mark.parametrize("name", OWN)
def test_a_definition_is_that_of_jazzy(name: str) -> None:
    own, jazzy = typestore(name), types_of_jazzy()
    assert own is not jazzy
    assert own is typestore(OWN[0])
    assert own.generate_msgdef(name, ros_version=2) == jazzy.generate_msgdef(name, ros_version=2)
    assert own.hash_rihs01(name) == jazzy.hash_rihs01(name)


def test_the_topics_of_the_bench_need_no_other_type() -> None:
    assert {topic.type for topic in (*SIMULATED, *DETECTED)} <= set(OWN)


def test_other_types_are_those_of_jazzy() -> None:
    name = "sensor_msgs/msg/MagneticField"
    assert name not in OWN
    assert definition_of(name) == types_of_jazzy().generate_msgdef(name, ros_version=2)[0]
    assert definition_of("my_msgs/msg/Unknown") == ""
