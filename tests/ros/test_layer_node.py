"""What all nodes have in common: names, parameters, work on the clock of ROS."""

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import Vector3
from std_msgs.msg import Empty

from crazychoir_fw import ros
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.ros.conversions import message_to_reference
from crazychoir_fw.ros.names import ACCELERATION, TOPICS
from crazychoir_fw.ros.node import LayerNode


def named(args, **options):
    """Return the full name of a node, and its drone, given arguments of the command line."""
    context = rclpy.Context()
    rclpy.init(context=context, args=["program", "--ros-args", *args] if args else [])
    try:
        node = LayerNode("controller", context=context, **options)
        try:
            return node.get_fully_qualified_name(), node.agent_id
        finally:
            node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


@pytest.mark.parametrize(
    ("args", "options", "name", "agent"),
    [
        ([], {}, "/agent_0/controller", 0),
        ([], {"agent_id": 12}, "/agent_12/controller", 12),
        (["-p", "agent_id:=3"], {}, "/agent_3/controller", 3),
        (["-r", "__ns:=/agent_5"], {}, "/agent_5/controller", 5),
        (["-r", "__ns:=/room/agent_5", "-p", "agent_id:=5"], {}, "/room/agent_5/controller", 5),
        (["-p", "agent_id:=2", "-p", "namespace_pattern:=cf_{i}"], {}, "/cf_2/controller", 2),
        (["-r", "__ns:=/cf{4}".replace("{4}", "4")], {"namespace_pattern": "cf{i}"}, "/cf4/controller", 4),
        ([], {"swarm_wide": True}, "/controller", -1),
    ],
)
def test_a_node_lives_in_the_namespace_of_its_drone(args, options, name, agent):
    assert named(args, **options) == (name, agent)


@pytest.mark.parametrize("pattern", ["agent", "agent_{i}_{i}", "agent_{j}", "{i}{}", 7])
def test_a_pattern_without_the_number_is_refused(pattern, ros_context):
    with pytest.raises(RangeError, match="namespace_pattern"):
        LayerNode("controller", agent_id=0, namespace_pattern=pattern, context=ros_context)


def test_parameters_have_types_and_descriptions(ros_context):
    node = LayerNode(
        "guidance",
        agent_id=1,
        parameters={"height": 2, "init_pos": [0, 1, 2.5], "matrix": np.eye(2), "name": "a"},
        context=ros_context,
    )
    assert node.declare("height", 1.0, "height (m)", low=0.0) == 2.0
    assert node.declare("init_pos", None, "start (m)", list[float], length=3) == [0.0, 1.0, 2.5]
    assert node.declare("matrix", None, "matrix", list[float]) == [1.0, 0.0, 0.0, 1.0]
    assert node.declare("name", "b", "name") == "a"
    assert node.declare("weights", None, "weights", list[float]) is None
    assert node.declare("in_neigh", [], "neighbors", list[int]) == []
    described = node.describe_parameter("height")
    assert described.description == "height (m)" and described.read_only
    assert described.type == 3, "a double, although a whole number was given"
    assert described.floating_point_range[0].from_value == 0.0
    assert all(node.describe_parameter(name).description for name in ("agent_id", "namespace_pattern"))
    node.destroy_node()


@pytest.mark.parametrize(
    ("value", "kind", "limits"),
    [
        (-1.0, float, {"low": 0.0}),
        (float("nan"), float, {"low": 0.0}),
        ("high", float, {}),
        (1.5, int, {}),
        (True, int, {}),
        (1, bool, {}),
        ([1.0, 2.0], list[float], {"length": 3}),
        ([1.0, 2.0], list[int], {}),
        ([0, 9], list[int], {"high": 3}),
        ("x", list[str], {}),
    ],
)
def test_a_parameter_that_does_not_fit_is_refused_with_node_name_and_range(value, kind, limits, ros_context):
    node = LayerNode("guidance", agent_id=2, parameters={"given": value}, context=ros_context)
    with pytest.raises(RangeError, match=r"/agent_2/guidance: parameter given is .*, allowed: "):
        node.declare("given", None, "something", kind, **limits)
    node.destroy_node()


def test_work_happens_on_a_grid_of_simulated_time(bench):
    node = bench.make(LayerNode, "guidance", agent_id=0)
    bench.at(1.0)
    times = []
    node.every(50.0, times.append)
    for k in range(1, 101):
        bench.at(1.0 + 0.01 * k)
    np.testing.assert_allclose(times, 1.0 + 0.02 * np.arange(1, 51), atol=1e-9)


def test_a_pause_makes_no_burst_and_the_grid_stays(bench):
    node = bench.make(LayerNode, "guidance", agent_id=0)
    bench.at(1.0)
    times = []
    node.every(100.0, times.append)
    for now in (1.01, 1.02, 7.013, 7.015, 7.02, 7.03):
        bench.at(now)
    np.testing.assert_allclose(times, [1.01, 1.02, 7.013, 7.02, 7.03])


def test_where_time_jumps_back_work_begins_anew(bench):
    node = bench.make(LayerNode, "guidance", agent_id=0)
    bench.at(50.0)
    times, jumps = [], []
    node.every(100.0, times.append)
    node.when_time_jumps_back(jumps.append)
    for now in (50.01, 2.0, 2.005, 2.01, 2.02):
        bench.at(now)
    np.testing.assert_allclose(times, [50.01, 2.01, 2.02])
    assert jumps == [2.0]


def test_frequencies_are_checked(ros_context):
    node = LayerNode("guidance", agent_id=0, context=ros_context)
    for frequency in (0.0, -1.0, float("nan"), 1e9):
        with pytest.raises(RangeError, match="frequency"):
            node.every(frequency, print)
    node.destroy_node()


def test_a_message_that_is_refused_does_not_end_the_node(bench):
    node, good = bench.make(LayerNode, "controller", agent_id=0), []
    node.listen(ACCELERATION, lambda message: good.append(message_to_reference(message, "acceleration")))
    publisher = bench.speaker(Vector3, "/agent_0/acceleration")
    publisher.publish(Vector3(x=float("nan")))
    bench.drain()
    publisher.publish(Vector3(x=1.0))
    bench.until(lambda: good)
    assert [reference.acceleration[0] for reference in good] == [1.0]


def test_buttons_call_with_the_time(bench):
    node, pressed = bench.make(LayerNode, "guidance", agent_id=0), []
    node.on_buttons(
        takeoff=lambda now: pressed.append(("takeoff", now)), start=lambda now: pressed.append(("start", now))
    )
    bench.at(3.5)
    bench.speaker(Empty, "/takeoff").publish(Empty())
    bench.until(lambda: len(pressed) == 1)
    bench.speaker(Empty, "/experiment_trigger").publish(Empty())
    bench.until(lambda: len(pressed) == 2)
    assert pressed == [("takeoff", 3.5), ("start", 3.5)]
    with pytest.raises(RangeError, match="takeoff, land, stop, start"):
        node.on_buttons(explode=print)


def test_the_table_is_that_of_the_original():
    depths = {topic.name: (topic.publish_depth, topic.subscribe_depth) for topic in TOPICS}
    assert len(depths) == len(TOPICS)
    assert depths["odom"] == (10, 10) and depths["cmd_vel"] == (10, 1) and depths["acceleration"] == (10, 1)
    assert depths["traj_params"] == (1, 10) and depths["/takeoff"] == (10, 10)
    assert depths["/visualization_marker"] == (1, 1)


def test_every_name_of_the_package_is_there():
    assert {name for name in ros.__all__ if not hasattr(ros, name)} == set()
