"""Parameter files: plain groups, and the sections of nodes, which mean what they mean to ROS."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.topics import NAMESPACE
from dcrb_ros.nodes.programs import NAMES
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration, read_parameters, validated
from dcrb_ros.settings.sections import BENCH, NODES


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        "operating: {speed: 100.0}\nfaults: {outer_1: {width: 0.002}}",
        "operating.speed: 100.0\nfaults.outer_1.width: 0.002",
        "operating: {speed: 100}\nfaults: {outer_1.width: 0.002}",
        "{operating: {speed: 100.0}, faults.outer_1: {width: 0.002}}",
    ],
)
def test_a_plain_file_is_a_configuration(tmp_path: Path, text: str) -> None:
    configuration = load_configuration(written(tmp_path, text))
    assert (configuration.operating.speed, configuration.faults.outer_1.width) == (100.0, 0.002)


def test_a_plain_file_has_the_parameters_of_the_detector(tmp_path: Path) -> None:
    path = written(tmp_path, "learn: 10.0\nwindow: 5.0")
    found = validated(read_parameters(path, "fault_detector"), DetectorParameters, str(path))
    assert (found.learn, found.window) == (10.0, 5.0)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("bearing: {rows: 1}\nother: {x: 1}", r"unknown parameter 'other.x'"),
        ("operatin: {speed: 100.0}", r"unknown parameter 'operatin.speed'; did you mean 'operating.speed'\?"),
        ("operatin: {}", r"unknown parameter 'operatin'; did you mean 'operating'\?"),
        ("faults: {outer_3: {}}", r"unknown parameter 'faults.outer_3'; did you mean 'faults.outer_[12]'\?"),
        ("faults: {outer_1: {widht: 0.001}}", r"did you mean 'faults.outer_1.width'\?"),
        ("operating:", r"operating is a group of parameters: give them below it, such as operating.speed, or leave it out"),
        ("operating: 100.0", r"operating is a group of parameters"),
        ("{}", "is not a file of parameters"),
        ("- operating.speed", "is not a file of parameters"),
        ("operating: {speed: 100.0}\noperating.speed: 90.0", "operating.speed occurs twice, in its group and with a dotted name"),
        ("/**: {operating: {speed: 100.0}}", "'/\\*\\*' must contain 'ros__parameters:' and nothing else"),
        ("simulator: {operating: {speed: 100.0}}", "'simulator' must contain 'ros__parameters:' and nothing else"),
        ("ros__parameters: {operating: {speed: 100.0}}", "'ros__parameters:' must be below the name of a node, such as '/\\*\\*:'"),
        ("/**: {ros__parameters: {bearing.rows: 1}}\noperating: {speed: 100.0}", r"'operating' is beside the section '/\*\*'"),
        ("operating.speed: 100.0\n/**: {ros__parameters: {bearing.rows: 1}}", r"'operating.speed' is beside the section '/\*\*'"),
        ("/dcrb: {simulator: {ros__parameters: {bearing.rows: 1}}, x: 1}", r"'/dcrb/x' is beside the section '/dcrb/simulator'"),
        ("/**: {ros__parameters: {bearing.rows: 1}, bearing: {rows: 1}}", r"'/\*\*' must contain 'ros__parameters:' and nothing else"),
        ("/**: {ros__parameters: }", r"'/\*\*' has no parameters below 'ros__parameters:'"),
        ("simulatr: {ros__parameters: {bearing.rows: 1}}", r"no node .* reads the section 'simulatr': .*; did you mean 'simulator'\?"),
        ("/**: {ros__parameters: {}}\nother: {ros__parameters: {x: 1}}", r"no node .* reads the section 'other': .*\(simulator, "),
        (
            "/left/simulator: {ros__parameters: {bearing.rows: 1}}",
            r"no node .* the section '/left/simulator': .* namespace /dcrb \(simulator.*\)$",
        ),
        ("/*: {ros__parameters: {bearing.rows: 1}}", r"no node of the bench reads the section '/\*'"),
        ("/**/fault_detector: {ros__parameters: {learn: 1.0}}", "no parameters for the node 'simulator'; its sections are '/.*/fault"),
    ],
)
def test_what_no_node_reads_is_refused_by_name(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_configuration(written(tmp_path, text))


def test_the_sections_of_several_nodes_share_a_file(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "/**: {ros__parameters: {use_sim_time: false}}\n"
        "dcrb:\n"
        "  simulator: {ros__parameters: {operating: {speed: 100.0}}}\n"
        "  fault_detector: {ros__parameters: {learn: 10.0}}\n",
    )
    assert read_parameters(path, "simulator") == {"operating.speed": 100.0}
    assert read_parameters(path, "fault_detector") == {"learn": 10.0}


def test_parameters_that_every_ros_node_has_are_no_part_of_a_configuration(tmp_path: Path) -> None:
    dumped = "/dcrb/simulator: {ros__parameters: {use_sim_time: true, start_type_description_service: true, bearing: {rows: 1}}}"
    assert load_configuration(written(tmp_path, dumped)).bearing.rows == 1
    with pytest.raises(Refusal, match="unknown parameter 'use_sim_time'"):
        load_configuration(written(tmp_path, "use_sim_time: true"))


def test_the_nodes_of_the_bench_are_those_that_run() -> None:
    assert (set(NODES), BENCH) == (set(NAMES), NAMESPACE)


LAYOUTS = [
    "/**: {ros__parameters: {x: 1}}",
    "'**': {ros__parameters: {x: 1}}",
    "/dcrb/simulator: {ros__parameters: {x: 1}}",
    "dcrb/simulator: {ros__parameters: {x: 1}}",
    "dcrb: {simulator: {ros__parameters: {x: 1}}, fault_detector: {ros__parameters: {x: 2}}}",
    "/dcrb: {'**': {ros__parameters: {x: 1}}}",
    "/**: {simulator: {ros__parameters: {x: 1}}}",
    "/*/simulator: {ros__parameters: {x: 1}}",
    "/dcrb/*: {ros__parameters: {x: 1}}",
    "/dcrb/**: {ros__parameters: {x: 1}}",
    "/dcrb/simulator: {ros__parameters: {x: 1}}\n/**: {ros__parameters: {x: 2}}",
    "/**: {ros__parameters: {x: 2}}\n/dcrb/simulator: {ros__parameters: {x: 1}}",
    "/dcrb/simulator: {ros__parameters: {x: 2}}\n/**/simulator: {ros__parameters: {x: 1}}",
    "/**/simulator: {ros__parameters: {x: 1}}\n/dcrb/*: {ros__parameters: {x: 2}}",
    "/**: {ros__parameters: {a: {b.c: 1, d: {e: 2}}, a.d.f: 3}}",
    "/**: {ros__parameters: {}}",
]


def overrides_in_ros(path: Path) -> dict[str, Any]:
    """Return the parameters that rclpy gives to the simulator from a file."""
    rclpy = pytest.importorskip("rclpy", reason="compares with ROS 2; the rest is tested without")
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(path)], context=context)
    try:
        options = {"enable_rosout": False, "start_parameter_services": False, "automatically_declare_parameters_from_overrides": True}
        node = rclpy.create_node("simulator", namespace=NAMESPACE, context=context, **options)
        found = {key: parameter.value for key, parameter in node.get_parameters_by_prefix("").items()}
        node.destroy_node()
    finally:
        context.try_shutdown()
    return {key: value for key, value in found.items() if key not in ("use_sim_time", "start_type_description_service")}


@pytest.mark.parametrize("text", LAYOUTS)
def test_sections_mean_what_they_mean_to_ros(tmp_path: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    path = written(tmp_path, text)
    assert read_parameters(path, "simulator") == overrides_in_ros(path)
