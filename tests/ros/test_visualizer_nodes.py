"""Markers for RViz."""

import numpy as np
import pytest
import yaml
from geometry_msgs.msg import Vector3
from nav_msgs.msg import Odometry
from visualization_msgs.msg import Marker, MarkerArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros.conversions import pose_to_odometry
from crazychoir_fw.ros.names import MARKER, MARKERS, WORLD_FRAME
from crazychoir_fw.ros.visualizer import SimpleVisualizer, Visualizer, rviz_config


def at(x, time=1.0):
    quaternion = np.array([0.0, 0.0, np.sin(0.5), np.cos(0.5)])
    return pose_to_odometry(Pose(np.array([x, 0.0, 1.0]), quaternion, np.zeros(3), np.zeros(3), time))


def test_a_red_sphere_twenty_five_times_a_second(bench):
    node = bench.make(SimpleVisualizer, agent_id=4)
    heard, odom = bench.hear(Marker, "/visualization_marker"), bench.speaker(Odometry, "/agent_4/odom")
    for k in range(20):
        bench.at(1.0 + 0.01 * k)
    assert heard == []
    odom.publish(at(2.0))
    bench.until(lambda: node.current_pose.position is not None)
    for k in range(20, 60):
        bench.at(1.0 + 0.01 * k)
    bench.until(lambda: len(heard) >= 10)
    bench.drain()
    assert len(heard) == 10
    marker = heard[-1]
    assert (marker.ns, marker.id, marker.type) == ("robots", 4, Marker.SPHERE)
    assert (marker.color.r, marker.color.g, marker.color.a) == (1.0, 0.0, 1.0)
    assert (marker.scale.x, marker.pose.position.x) == (0.2, 2.0)
    assert marker.header.frame_id == WORLD_FRAME


def test_the_swarm_with_trails_references_edges_and_names(bench):
    node = bench.make(Visualizer, edges=[(0, 1)], trail=0.5, parameters={"N": 2})
    heard = bench.hear(MarkerArray, "/visualization_marker_array")
    odom = [bench.speaker(Odometry, f"/agent_{i}/odom") for i in (0, 1)]
    wanted = bench.speaker(Vector3, "/agent_1/position")
    bench.at(1.0)
    wanted.publish(Vector3(x=3.0))
    for k in range(1, 31):
        odom[0].publish(at(0.05 * k))
        odom[1].publish(at(1.0))
        bench.until(lambda k=k: node._poses[0].position is not None and node._poses[0].position[0] == 0.05 * k)
        bench.at(1.0 + 0.04 * k)
    bench.until(lambda: len(heard) >= 30)
    markers = {(marker.ns, marker.id): marker for marker in heard[-1].markers}
    kinds = {"robots", "names", "trails"}
    assert set(markers) == {(kind, i) for kind in kinds for i in (0, 1)} | {("references", 0), ("edges", 0)}
    assert markers["robots", 0].type == Marker.ARROW and markers["robots", 0].pose.orientation.z == pytest.approx(
        np.sin(0.5)
    )
    assert markers["names", 1].text == "agent_1"
    assert [point.x for point in markers["edges", 0].points] == [1.5, 1.0]
    assert [point.x for point in markers["references", 0].points] == [3.0]
    # half a second of it, at 1.25 m/s; a drone at rest leaves no trail
    trail = [point.x for point in markers["trails", 0].points]
    assert trail[-1] == 1.5 and min(trail) == pytest.approx(1.5 - 1.25 * 0.5, abs=0.06)
    assert len(markers["trails", 1].points) <= 3
    assert {marker.header.frame_id for marker in heard[-1].markers} == {WORLD_FRAME}


def test_what_cannot_be_shown_is_refused(bench):
    with pytest.raises(RangeError, match="shape is 'cube', allowed: sphere, arrow"):
        bench.make(Visualizer, shape="cube")
    with pytest.raises(RangeError, match="pairs of drones"):
        bench.make(Visualizer, edges=[(0, 7)], parameters={"N": 2})


def test_the_configuration_shows_these_topics_in_this_frame():
    config = yaml.safe_load(rviz_config().read_text())["Visualization Manager"]
    assert config["Global Options"]["Fixed Frame"] == WORLD_FRAME
    topics = {display["Topic"]["Value"] for display in config["Displays"] if "Topic" in display}
    assert topics == {MARKER.name, MARKERS.name}
