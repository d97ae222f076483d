"""Where nodes get poses from."""

import sys
from types import ModuleType

import numpy as np
import pytest
from geometry_msgs.msg import PointStamped, PoseStamped
from nav_msgs.msg import Odometry

from crazychoir_fw.common.errors import StateError, UnknownNameError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import Estimator
from crazychoir_fw.ros.conversions import pose_to_odometry, pose_to_pose_stamped
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.pose_sources import pose_subscribe
from crazychoir_fw.ros.topic_poses import TopicPoses

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def pose_at(k):
    return Pose(np.array([0.01 * k, 0.0, 1.0]), LEVEL, np.zeros(3), np.zeros(3), 1.0 + 0.01 * k)


def test_odometry_fills_a_pose_and_then_calls_back(bench):
    node, pose, seen = bench.make(LayerNode, "controller", agent_id=0), Pose(), []
    pose_subscribe("pubsub", "odom", node, pose, lambda: seen.append(pose.position[0]))
    publisher = bench.speaker(Odometry, "/agent_0/odom")
    for k in (1, 2):
        publisher.publish(pose_to_odometry(pose_at(k)))
        bench.until(lambda k=k: len(seen) == k)
    assert seen == [0.01, 0.02] and pose.time == 1.02
    np.testing.assert_array_equal(pose.velocity, 0.0)


@pytest.mark.parametrize("handler", ["pose", "vicon"])
def test_motion_capture_goes_through_an_estimator(bench, handler):
    node, seen = bench.make(LayerNode, "controller", agent_id=0), []
    pose_subscribe(handler, "/vicon/cf1/cf1", node, seen.append, Estimator())
    publisher = bench.speaker(PoseStamped, "/vicon/cf1/cf1")
    for k in range(6):
        publisher.publish(pose_to_pose_stamped(pose_at(k)))
        bench.until(lambda k=k: len(seen) == k + 1)
    assert [pose.velocity[0] for pose in seen] == pytest.approx([0.0, 0.4, 0.64, 0.784, 0.8704, 0.92224])
    # an occluded drone: the estimate stays, with its time
    publisher.publish(lost())
    bench.until(lambda: len(seen) == 7)
    assert seen[-1].time == seen[-2].time and seen[-1].position[0] == pytest.approx(0.05)


def lost():
    message = PoseStamped()
    message.header.stamp.sec = 2
    message.pose.orientation.w = 0.0
    return message


def test_without_a_filter_lost_samples_are_left_out_and_stamps_filled_in(bench):
    node, seen = bench.make(LayerNode, "controller", agent_id=0), []
    pose_subscribe("pose", "pose", node, seen.append)
    publisher = bench.speaker(PoseStamped, "/agent_0/pose")
    bench.at(4.0)
    publisher.publish(lost())
    bench.drain()
    publisher.publish(pose_to_pose_stamped(Pose(np.ones(3), LEVEL)))
    bench.until(lambda: seen)
    assert len(seen) == 1 and seen[0].time == 4.0 and seen[0].velocity is None


def test_nothing_and_the_unknown(ros_context):
    node = LayerNode("controller", agent_id=0, context=ros_context)
    assert pose_subscribe(None, None, node, Pose()) is None
    with pytest.raises(UnknownNameError, match="'tf2', allowed: pubsub, pose, vicon, vicon_mm"):
        pose_subscribe("tf2", "odom", node, Pose())
    node.destroy_node()


def test_the_legacy_message_needs_its_package(ros_context):
    node = LayerNode("controller", agent_id=0, context=ros_context)
    with pytest.raises(StateError, match=r"vicon_mm.*vicon_receiver before 1.0.*use 'vicon'"):
        pose_subscribe("vicon_mm", "/vicon/cf1/cf1", node, Pose())
    node.destroy_node()


def test_the_legacy_message_is_taken_where_its_package_is(bench, monkeypatch):
    """A message with a type of its own, which stands in for one that is not on any registry."""
    package, messages = ModuleType("vicon_receiver"), ModuleType("vicon_receiver.msg")
    messages.Position = PointStamped
    monkeypatch.setitem(sys.modules, "vicon_receiver", package)
    monkeypatch.setitem(sys.modules, "vicon_receiver.msg", messages)
    monkeypatch.setattr(
        "crazychoir_fw.ros.pose_sources.decode_vicon_position",
        lambda message, now: Pose(1e-3 * np.array([message.point.x, 0.0, 0.0]), LEVEL, time=now),
    )
    node, seen = bench.make(LayerNode, "controller", agent_id=0), []
    pose_subscribe("vicon_mm", "/vicon/cf1/cf1", node, seen.append)
    publisher = bench.speaker(PointStamped, "/vicon/cf1/cf1")
    bench.at(2.0)
    message = PointStamped()
    message.point.x = 1500.0
    publisher.publish(message)
    bench.until(lambda: seen)
    assert seen[0].position[0] == 1.5 and seen[0].time == 2.0


def test_experiments_that_are_no_nodes_get_poses_too(bench):
    source = TopicPoses(["/vicon/cf1/cf1"], clock=lambda: 7.0, context=bench.context)
    try:
        publisher = bench.speaker(PoseStamped, "/vicon/cf1/cf1")
        publisher.publish(lost())  # occluded: left out
        publisher.publish(pose_to_pose_stamped(pose_at(3)))
        bench.until(source.latest)
        pose = source.latest()["/vicon/cf1/cf1"]
        np.testing.assert_allclose(pose.position, [0.03, 0.0, 1.0])
        assert pose.time == 7.0  # when it came, and not its stamp
    finally:
        source.close()
