"""Parameters of a running node: which changes it accepts, and how it refuses the others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from node_arguments import parameters
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import GetParameters
from ros_bench import GraphClient, domain, environment, graph_client, node

from dcrb_ros.messages.plain import decode_text
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, SENSOR, VIBRATION
from dcrb_ros.settings.files import load_configuration, nest, parameter_fields
from dcrb_ros.settings.parameters import COMMANDED
from dcrb_ros.settings.shipped import shipped
from dcrb_ros.stream.block import Truth
from dcrb_ros.stream.events import ParameterChange

pytestmark = [pytest.mark.node, pytest.mark.slow]


def truths(client: GraphClient) -> list[Truth]:
    return [decode_truth(data) for data in client.received[GROUND_TRUTH]]


def test_changes_of_parameters_take_effect_or_are_refused_together(tmp_path: Path) -> None:
    number = domain()
    with (
        graph_client(number) as client,
        node("simulator", parameters(cage__joint="revolute"), environment(number), tmp_path / "log") as bench,
    ):
        client.until(lambda: len(client.received[VIBRATION]) > 5, "blocks")
        refusals: list[tuple[dict[str, Any], str]] = [
            ({"faults__outer_1__width": 0.5}, "faults.outer_1.width = 0.5 m is outside 0 .. 0.05 m"),
            ({"faults__outer_1__width": float("nan")}, "faults.outer_1.width = nan m is not a finite number"),
            ({"faults__outer_1__width": 1}, "faults.outer_1.width = 1.0 m is outside 0 .. 0.05 m"),
            ({"faults__outer_1__width": 0.002, "faults__outer_2__width": 0.002}, "faults.outer_2 overlaps faults.outer_1"),
            ({"faults__broken_bars": "bar 3"}, "'bar' is not a bar; write row1/bar15"),
            ({"bearing__roller_radius": 0.01}, "bearing.roller_radius is fixed while the bench runs"),
            ({"operating__speed": 100.0, "faults__outer_1__width": 0.002}, "operating.speed changes by"),
            ({"sensor__fault": "stuk"}, "did you mean 'stuck'?"),
            ({"sensor__preset": "mems"}, "sensor.preset is fixed while the bench runs"),
            ({"faults__outer_1__with": 0.1}, "did you mean 'faults.outer_1.width'?"),
            ({"time_scale": -1.0}, "time_scale = -1.0 is outside 0 .. 1000"),
        ]
        for values, reason in refusals:
            done, said = client.set(**values)
            assert not done
            assert reason in said
        assert client.set(faults__outer_1__width=0.002, faults__outer_1__row=1, faults__broken_bars="row2/bar7") == (True, "")
        client.until(lambda: len(truths(client)[-1].faults) == 2, "the faults in the ground truth")
        change = next(truth for truth in truths(client) if isinstance(truth.event, ParameterChange))
        assert change.event == ParameterChange({"faults.outer_1.width": 0.002, "faults.outer_1.row": 1, "faults.broken_bars": "row2/bar7"})
        assert change.faults["outer_1"]["onset"] == pytest.approx(change.time_ns * 1e-9, abs=1e-9)
        assert "broken_bars.row2/bar7" in change.faults
        done, said = client.set(faults__broken_bars="")
        assert (done, "does not heal" in said) == (False, True)
        assert client.set(faults__outer_1__width=0.0) == (True, "")
        client.until(lambda: set(truths(client)[-1].faults) == {"broken_bars.row2/bar7"}, "the defect gone")
        assert client.set(sensor__fault="stuck", background__hum_level=2.0) == (True, "")
        client.until(lambda: "sensor.stuck" in truths(client)[-1].faults, "the sensor's fault")
        assert truths(client)[-1].background == {"hum_level": 2.0}
        assert client.set(sensor__fault="none") == (True, "")
        client.until(lambda: "sensor.stuck" not in truths(client)[-1].faults, "a sound sensor")
        blocks = len(client.received[VIBRATION])
        client.until(lambda: len(client.received[VIBRATION]) > blocks + 20, "blocks")
        client.until(lambda: client.status["rejected_parameters"] == str(len(refusals) + 1), "the count of refusals")
        assert bench.output.count("[WARN]") <= 2
        assert "Traceback" not in bench.output


def test_a_width_alone_is_logged_to_be_a_notch(tmp_path: Path) -> None:
    number, bench = domain(), shipped("configuration")["healthy"]
    with (
        graph_client(number) as client,
        node("simulator", ["--ros-args", "--params-file", str(bench)], environment(number), tmp_path / "log") as simulator,
    ):
        client.until(lambda: client.received[VIBRATION], "a block")
        spall = {"faults__outer_1__kind": "spall", "faults__outer_1__width": 0.002, "faults__outer_1__depth": 6e-5}
        assert client.set(**spall) == (True, "")
        assert client.set(faults__inner_1__width=0.002) == (True, "")
        client.until(lambda: "faults.inner_1.kind = notch is a groove 0.3 mm deep" in simulator.output, "the remark")
        assert "faults.outer_1.kind = notch" not in simulator.output


def test_parameters_follow_the_scenario_and_a_reset(tmp_path: Path) -> None:
    from std_srvs.srv import Trigger

    story, number = tmp_path / "story.yaml", domain()
    events = "timeline: [{at: 0.1, set: {faults.outer_1.width: 0.002, sensor.range: 1000.0}}]"
    story.write_text(f"start: {{operating.speed: 100.0, sensor.fault: dead}}\n{events}")
    given = ["--scenario", str(story), *parameters(sensor__preset="mems", sensor__range=5000.0)]
    with graph_client(number) as client, node("simulator", given, environment(number), tmp_path / "log"):

        def value(*names: str) -> list[float]:
            return [found.double_value for found in client.ask(GetParameters, "simulator/get_parameters", names=list(names)).values]

        def width() -> float:
            return value("faults.outer_1.width")[0]

        client.until(lambda: client.received[VIBRATION] and truths(client), "a block and its truth")
        assert value("operating.speed", "sensor.white_noise_ug") == [100.0, 30.0]  # the scenario's start, the preset
        assert "sensor.dead" in truths(client)[0].faults  # the first one received; earlier ones may have been missed
        client.until(lambda: width() == 0.002, "what the scenario has set")

        def ranges() -> list[float]:
            return [json.loads(decode_text(data))["range"] for data in client.received[SENSOR]]

        client.until(lambda: ranges()[-1] == 1000.0, "the range that the scenario has set")
        assert client.set(faults__outer_1__width=0.001, time_scale=0.01) == (True, "")
        assert width() == 0.001  # even before it takes effect
        assert client.ask(Trigger, "reset").success
        client.until(lambda: width() == 0.0, "the width of the start")
        client.until(lambda: ranges()[-1] == 5000.0, "the range of the start")  # published again with every change
        assert ranges()[-2:] == [1000.0, 5000.0]


def test_every_parameter_is_declared_from_the_schema(tmp_path: Path) -> None:
    from rcl_interfaces.srv import DescribeParameters, ListParameters

    number = domain()
    with graph_client(number) as client, node("simulator", parameters(), environment(number), tmp_path / "log"):
        client.until(lambda: client.received[VIBRATION], "a block")
        names = set(client.ask(ListParameters, "simulator/list_parameters").result.names)
        fields = {field.key: field for field in parameter_fields()}
        overrides = {name for name in names if name.startswith("qos_overrides./")}
        assert "qos_overrides./dcrb/outer_ring/vibration.publisher.depth" in overrides
        assert names - overrides - {"use_sim_time", "start_type_description_service"} == set(fields)
        described = client.ask(DescribeParameters, "simulator/describe_parameters", names=sorted(fields)).descriptors
        kinds = {bool: 1, int: 2, float: 3, str: 4}
        for about in described:
            field = fields[about.name]
            assert about.description.startswith(field.description)
            assert about.type == kinds[field.kind]
            assert about.read_only == (not field.run_time or field.key in COMMANDED)
            ranges = [*about.floating_point_range, *about.integer_range]
            assert [(r.from_value, r.to_value) for r in ranges] == ([] if field.low is None else [(field.low, field.high)])


def test_several_bearings_in_one_graph(tmp_path: Path) -> None:
    from sensor_msgs.msg import PointCloud2

    number, heard_of = domain(), dict[str, list[PointCloud2]]()
    seen = {f"/wagon/box{box}": ["--ros-args", "-r", f"__ns:=/wagon/box{box}", "-r", "__node:=bearing"] for box in (1, 2)}
    with graph_client(number) as client:
        for box, name in enumerate(seen, 1):
            heard_of[name] = []
            client.node.create_subscription(PointCloud2, f"{name}/outer_ring/vibration", heard_of[name].append, 200)
            seen[name] += [
                "-p",
                f"simulation.seed:={box}",
                "-p",
                f"publishing.frame:=box{box}/outer_ring",
                "-p",
                "publishing.block_size:=4096",
            ]
        first, second = seen.items()
        with (
            node("simulator", first[1], environment(number), tmp_path / "log1"),
            node("simulator", second[1], environment(number), tmp_path / "log2"),
        ):
            client.until(lambda: all(len(blocks) > 2 for blocks in heard_of.values()), "blocks of both")
            assert {name: blocks[0].header.frame_id for name, blocks in heard_of.items()} == {
                "/wagon/box1": "box1/outer_ring",
                "/wagon/box2": "box2/outer_ring",
            }
            assert bytes(heard_of["/wagon/box1"][0].data) != bytes(heard_of["/wagon/box2"][0].data)  # different noise
            client.until(
                lambda: (
                    {"/wagon/box1/bearing", "/wagon/box2/bearing"}
                    <= {ns + "/" + n for n, ns in client.node.get_node_names_and_namespaces()}
                ),
                "both nodes",
            )


def test_what_is_dumped_can_be_loaded_again(tmp_path: Path) -> None:
    from rcl_interfaces.srv import ListParameters, SetParameters
    from rclpy.parameter import Parameter, parameter_dict_from_yaml_file

    number = domain()
    given = parameters(faults__outer_1__width=0.001, operating__speed_kmh=60.0, sensor__preset="mems")
    with graph_client(number) as client, node("simulator", given, environment(number), tmp_path / "log"):
        client.until(lambda: client.received[VIBRATION], "a block")
        names = list(client.ask(ListParameters, "simulator/list_parameters").result.names)
        values = client.ask(GetParameters, "simulator/get_parameters", names=names).values
        dumped = [Parameter.from_parameter_msg(ParameterMessage(name=name, value=value)) for name, value in zip(names, values, strict=True)]
        # The shape that `ros2 param dump` writes, and the function of rclpy by which `ros2 param load` reads it.
        tree = {"/dcrb/simulator": {"ros__parameters": nest({one.name: one.value for one in dumped})}}
        (tmp_path / "dump.yaml").write_text(yaml.dump(tree, default_flow_style=False), encoding="utf-8")
        loaded = list(parameter_dict_from_yaml_file(str(tmp_path / "dump.yaml")).values())
        results = client.ask(SetParameters, "simulator/set_parameters", parameters=loaded).results
        assert [(given.name, result.reason) for given, result in zip(loaded, results, strict=True) if not result.successful] == []
        assert len(results) == len(names) > 100
    asked = ["faults.outer_1.width=0.001", "operating.speed_kmh=60", "sensor.preset=mems"]
    assert load_configuration(tmp_path / "dump.yaml") == load_configuration("dry", asked)
