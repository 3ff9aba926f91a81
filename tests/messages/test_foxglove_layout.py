"""The Foxglove layouts of a bench and of a vehicle: panels, message paths and the script that unrolls a block."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_blocks import recorded
from ros_types import typestore

from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, DETECTED, GROUND_TRUTH, NAMESPACE, SIMULATED, VIBRATION
from dcrb_ros.messages.topics.vehicle import VEHICLE, VEHICLE_DIAGNOSIS
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.vehicle.file import read_vehicle

ROOT = Path(__file__).parents[2]
LAYOUTS: dict[str, Any] = {name: json.loads((ROOT / "foxglove" / f"{name}.json").read_text("utf-8")) for name in ("dcrb", "vehicle")}
LAYOUT = LAYOUTS["dcrb"]
SCRIPT = next(iter(LAYOUT["userNodes"].values()))["sourceCode"]
BOXES = ("axle_1/left", "axle_1/right", "axle_2/left", "axle_2/right")
OUTPUT = re.search(r'output = "([^"]+)"', SCRIPT)[1]  # type: ignore[index]


@cache
def messages_by_topic() -> dict[str, Any]:
    """Return a message of every topic."""
    messages = [*Recording(ROOT / "bags" / "outer_ring_defect").messages(), *diagnosis_messages(Diagnosis(0, 0.0, "healthy", "made up"))]
    return {m.topic.resolved(NAMESPACE): typestore().deserialize_cdr(m.data, m.topic.type) for m in messages}


def panels(layout: dict[str, Any], place: Any) -> Iterator[str]:
    """Yield the panels of a part of a layout."""
    if isinstance(place, dict):
        yield from panels(layout, place["first"])
        yield from panels(layout, place["second"])
        return
    yield place
    for tab in layout["configById"][place].get("tabs", ()):
        yield from panels(layout, tab["layout"])


def paths(layout: dict[str, Any]) -> list[tuple[str, str]]:
    """Return every message path with its label."""
    configured = layout["configById"].values()
    plotted = [(path["value"], path["label"]) for config in configured for path in config.get("paths", ())]
    shown = [(config["topicPath"], "") for config in configured if "topicPath" in config]
    return [*plotted, *shown]


def rendered(layout: dict[str, Any]) -> set[str]:
    """Return the topics that are rendered."""
    return {config["topicToRender"] for config in layout["configById"].values() if "topicToRender" in config}


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
def test_every_panel_has_a_place_and_a_configuration(layout: dict[str, Any]) -> None:
    assert sorted(panels(layout, layout["layout"])) == sorted(layout["configById"])


def test_every_topic_exists() -> None:
    topics = {topic.resolved(NAMESPACE) for topic in (*SIMULATED, *DETECTED, BENCH_DIAGNOSTICS)}
    assert rendered(LAYOUT) <= topics
    assert set(re.findall(r'inputs = \["([^"]+)"\]', SCRIPT)) == {VIBRATION.resolved(NAMESPACE)}


def test_panels_of_one_piece_of_hardware_name_that_of_the_ground_truth(tmp_path: Path) -> None:
    truths = [message.data for message in Recording(recorded(tmp_path / "bag", 1)).messages((GROUND_TRUTH,))]
    (hardware,) = {status.hardware_id for data in truths for status in typestore().deserialize_cdr(data, GROUND_TRUTH.type).status}
    selected = [config["selectedHardwareId"] for config in LAYOUT["configById"].values() if "selectedHardwareId" in config]
    assert selected == [hardware]


@pytest.mark.parametrize(("path", "label"), [both for both in paths(LAYOUT) if not both[0].startswith(OUTPUT)])
def test_every_path_leads_to_the_quantity_of_its_label(path: str, label: str) -> None:
    topic, *steps = re.split(r"\.|(?=\[)", path)
    value = message = messages_by_topic()[topic]
    for step in steps:
        value = value[int(step[1:-1])] if step.startswith("[") else getattr(value, step)
    names = getattr(message, "name", None)
    if names:
        assert isinstance(value, float)
        number = int(steps[-1][1:-1])
        assert label.replace(" ", "_") in (
            names[number],
            names[number].replace("row1/roller", "roller_").replace("_0", "_"),
            f"cage_{names[number][-1]}",
        )


def test_script_unrolls_a_block(tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node (Debian: apt-get install nodejs)")
    cloud = messages_by_topic()[VIBRATION.resolved(NAMESPACE)]
    data = next(m.data for m in Recording(ROOT / "bags" / "outer_ring_defect").messages((VIBRATION,)))
    block = decode_vibration(data)
    plain = re.sub(r"^import .*$|^type .*$|: Input<[^>]*>|: Waveform", "", SCRIPT, flags=re.MULTILINE)
    message = {"data": typestore().deserialize_cdr(data, VIBRATION.type).data.tolist(), "point_step": cloud.point_step}
    call = f"\nconst message = {json.dumps(message)};\nmessage.data = new Uint8Array(message.data);\n"
    (tmp_path / "script.mjs").write_text(plain + call + "console.log(JSON.stringify(script({ message })));\n", encoding="utf-8")
    done = subprocess.run([node, str(tmp_path / "script.mjs")], capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["time"] == pytest.approx(block.offsets_ns * 1e-6)
    assert np.array_equal(np.array([found["ax"], found["ay"]], np.float32).T, block.acceleration)


def test_every_path_of_the_layout_of_a_vehicle_leads_to_a_field() -> None:
    of_boxes = (topic.below(box) for topic in SIMULATED for box in BOXES)
    topics = {topic.resolved(NAMESPACE): topic for topic in (*of_boxes, *VEHICLE, BENCH_DIAGNOSTICS)}
    values = [*(path for path, _ in paths(LAYOUTS["vehicle"])), *rendered(LAYOUTS["vehicle"])]
    assert len(values) > 20
    for path in values:
        name, *steps = re.sub(r"\[[^]]*\]|\{[^}]*\}", "", path).split(".")
        kind = topics[name].type
        for step in steps:
            fields = dict(typestore().get_msgdef(kind).fields)
            assert step in fields, path
            about = fields[step][1]
            while not isinstance(about, str):  # an array has the type of its elements, a plain type its length
                about = about[0][1] if isinstance(about[0], tuple) else about[0]
            kind = about
    assert any(VEHICLE_DIAGNOSIS.name in path for path in values)


def test_the_layout_of_a_vehicle_has_a_verdict_on_every_part_of_the_shipped_bogie() -> None:
    parts = {f"{box}/{part}" for box in BOXES for part in ("bearing", "wheel", "sensor")}
    gears = {f"{axle.name}/gear" for axle in read_vehicle("bogie").axles if axle.gear.teeth}
    assert set(re.findall(r'\{name=="([^"]+)"\}', json.dumps(LAYOUTS["vehicle"]).replace('\\"', '"'))) == {*parts, *gears, "track"}
