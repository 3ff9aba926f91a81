"""Temperatures on their topics, in recordings and in the ground truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import dcrb_ros
from dcrb_ros.cli.app import app
from dcrb_ros.messages.statuses import decode_diagnostics, decode_truth, encode_truth
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, BOX_TEMPERATURE, OUTER_RING_TEMPERATURE
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.stream.block import Truth

TOPICS = (OUTER_RING_TEMPERATURE, BOX_TEMPERATURE, AMBIENT_TEMPERATURE)


@pytest.mark.slow
def test_a_recording_has_the_readings_of_each_second_and_is_made_again_bit_for_bit(tmp_path: Path) -> None:
    bag, again = tmp_path / "warm", tmp_path / "again"
    said = CliRunner().invoke(app, ["simulate", "healthy", "-o", str(bag), "--duration", "1.1", "--set", "thermal.law=network"])
    assert said.exit_code == 0, said.output
    for topic in TOPICS:
        read = [(message.time_ns, message.content) for message in Recording(bag).messages([topic])]
        assert [time for time, _ in read] == [0, 1_000_000_000]
        assert all(10.0 < value < 60.0 for _, value in read)
    said = CliRunner().invoke(app, ["simulate", "--from", str(bag), "-o", str(again)])
    assert said.exit_code == 0, said.output
    kept, made = (list(Recording(folder).messages(TOPICS)) for folder in (bag, again))
    assert [(m.topic.name, m.data) for m in kept] == [(m.topic.name, m.data) for m in made]
    assert Recording(bag).truth().truths[-1].thermal["box [deg C]"] == pytest.approx(kept[1].content, abs=10.0)


def test_a_bench_without_a_network_publishes_no_temperature() -> None:
    assert not any(topic.enabled(dcrb_ros.load_configuration("healthy")) for topic in TOPICS)


def test_the_ground_truth_keeps_its_temperatures_through_a_message() -> None:
    truth = dcrb_ros.simulate("healthy", 0.05, settings={"thermal.law": "network"}).truth.truths[-1]
    assert decode_truth(encode_truth(truth)).thermal == truth.thermal
    assert said_of_heat(truth) == ""
    fast = replace(truth, thermal={**truth.thermal, "acceleration": 200.0})
    assert decode_truth(encode_truth(fast)).thermal["acceleration"] == 200.0
    assert said_of_heat(fast) == "heat is stored 200 times as fast as in reality, and speed, load, ambient and faults keep their time"


def said_of_heat(truth: Truth) -> str:
    """Return the message of the status of temperatures."""
    return next(status.message for status in decode_diagnostics(encode_truth(truth))[1] if status.name == "thermal")


def test_the_page_on_heat_says_what_a_time_lapse_does_to_a_changing_speed() -> None:
    page = " ".join((Path(__file__).parents[2] / "docs" / "explanation" / "thermal.md").read_text(encoding="utf-8").split())
    assert "multiplies the storage of heat alone. Speed, load and faults keep their time." in page
