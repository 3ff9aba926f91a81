"""The page on adding a topic, followed literally."""

from __future__ import annotations

import json

import pytest
from how_to import ROOT, copied_package, effort, run
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

PAGE = ROOT / "docs/how-to/add-a-topic.md"

RECORD = """
import json
import numpy as np
from dcrb_ros.stream.states import Account, BodyNames
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import SIMULATED, topic_table
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder, chosen_topics
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.block import Block

def block(number):
    zeros = np.zeros((1024, 2), np.float32)
    energy = Account(10.0 * number, 0.0, 4.0, 3.0, 0.0, 0.0, 2.0) if number != 1 else None
    return Block(1024 * number, 51200, zeros, zeros[:, 0], zeros, energy=energy)

configuration, bodies = Configuration(), BodyNames(2, 16)
published = [message.topic.name for message in BlockEncoder(configuration, bodies).encode(block(0))]
with Recorder("bag", configuration, bodies) as recorder:
    for number in range(3):
        recorder.write(block(number))
(energy,) = (topic for topic in SIMULATED if topic.name == "energy")
read = [(message.time_ns, message.content.names, message.content.position.tolist()) for message in Recording("bag").messages([energy])]
print(json.dumps({
    "published": published,
    "read": read,
    "counts": Recording("bag").counts(),
    "chosen": sorted(topic.name for topic in chosen_topics("energy")),
    "table": topic_table(),
}))
"""
NAMES = ["drive", "friction", "loss", "residual"]
EXPECTED = [(20_000_000, [0.0, 4.0, 3.0, -9.0]), (60_000_000, [20.0, 4.0, 3.0, 11.0])]
"""Times [ns] and values of the messages: the second block has no energy account."""


def test_a_topic_is_one_file_and_one_line() -> None:
    assert effort(PAGE) == (1, 1)


def test_the_new_topic_is_encoded_recorded_and_read_back(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("package")
    found = json.loads(run(copied_package(folder, PAGE), RECORD))
    assert "energy" in found["published"]
    assert found["counts"]["/dcrb/energy"] == 2
    assert [(time_ns, position) for time_ns, _, position in found["read"]] == EXPECTED
    assert all(names == NAMES for _, names, _ in found["read"])
    assert found["chosen"] == ["energy", "outer_ring/sensor"]
    assert "| `energy` | `sensor_msgs/JointState` | energy since the start [J]" in found["table"]
    with AnyReader([folder / "bag"]) as reader:
        connections = [connection for connection in reader.connections if connection.topic == "/dcrb/energy"]
        messages = [(time_ns, reader.deserialize(data, connection.msgtype)) for connection, time_ns, data in reader.messages(connections)]
        assert [(time_ns, list(message.position)) for time_ns, message in messages] == EXPECTED
    (file,) = (folder / "bag").glob("*.mcap")
    with file.open("rb") as stream:
        records = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=["/dcrb/energy"])
        decoded = [message for _, _, _, message in records]
    assert [list(message.position) for message in decoded] == [position for _, position in EXPECTED]
    assert [message.header.stamp.nanosec for message in decoded] == [time_ns for time_ns, _ in EXPECTED]
