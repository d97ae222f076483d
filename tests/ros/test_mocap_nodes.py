"""Motion capture as nodes: simulated poses out of odometry, and odometry out of poses."""

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import SimulatedMocap
from crazychoir_fw.ros.conversions import odometry_to_pose, pose_stamped_to_pose, pose_to_odometry, pose_to_pose_stamped
from crazychoir_fw.ros.mocap import MocapOdometry, MocapSimulator

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def truth(k):
    return Pose(np.array([0.01 * k, 0.0, 1.0]), LEVEL, np.array([1.0, 0, 0]), np.zeros(3), 1.0 + 0.01 * k)


def test_poses_are_those_of_the_plain_system_late_and_noisy(bench):
    bench.make(MocapSimulator, parameters={"N": 2, "seed": 4, "latency": 0.02})
    heard = [bench.hear(PoseStamped, f"/vicon/cf{i}/cf{i}") for i in (0, 1)]
    odom = [bench.speaker(Odometry, f"/agent_{i}/odom") for i in (0, 1)]
    for k in range(30):
        for publisher in odom:
            publisher.publish(pose_to_odometry(truth(k)))
        bench.until(lambda k=k: all(len(poses) >= k - 1 for poses in heard))
    group, wanted = SimulatedMocap(seed=4), []
    for k in range(30):
        both = truth(k)
        wanted += group.step(both.time, Pose(np.tile(both.position, (2, 1)), np.tile(LEVEL, (2, 1))))
    assert heard[0][0].header.frame_id == "world"
    for i in (0, 1):
        assert len(heard[i]) == 28
        for message, sample in zip(heard[i], wanted, strict=False):
            pose = pose_stamped_to_pose(message)
            assert pose.time == pytest.approx(sample.time)
            np.testing.assert_allclose(pose.position, sample.position[i], atol=1e-12)


def test_occluded_drones_are_not_published(bench):
    node = bench.make(MocapSimulator, parameters={"latency": 0.0})
    heard, odom = bench.hear(PoseStamped, "/vicon/cf0/cf0"), bench.speaker(Odometry, "/agent_0/odom")
    for k in range(10):
        if k == 3:
            node.systems[0].occlude([0])
        if k == 7:
            node.systems[0].reveal([0])
        odom.publish(pose_to_odometry(truth(k)))
        seen = k + 1 if k < 3 else 3 + max(0, k - 6)
        bench.until(lambda seen=seen: len(heard) >= seen)
        bench.drain()
    stamps = [round(100 * pose_stamped_to_pose(message).time) - 100 for message in heard]
    assert stamps == [0, 1, 2, 7, 8, 9]


def test_odometry_comes_out_of_poses_and_stops_when_the_drone_is_lost(bench):
    node = bench.make(MocapOdometry, agent_id=5, parameters={"pose_timeout": 0.1})
    heard, poses = bench.hear(Odometry, "/agent_5/odom"), bench.speaker(PoseStamped, "/vicon/cf5/cf5")
    for k in range(20):
        bench.at(1.0 + 0.01 * k)
        poses.publish(pose_to_pose_stamped(truth(k)))
        bench.until(lambda k=k: len(heard) >= k + 1)
    estimate = odometry_to_pose(heard[-1])
    assert estimate.velocity[0] == pytest.approx(1.0, abs=1e-3) and estimate.time == pytest.approx(1.19)
    for k in range(20, 40):
        bench.at(1.0 + 0.01 * k)
        lost = PoseStamped()
        lost.header.stamp.sec = 2
        lost.pose.orientation.w = 0.0
        poses.publish(lost)
        bench.drain()
    assert len(heard) == 20
    assert not node._watch.is_fresh(1.39)
    bench.at(1.40)
    poses.publish(pose_to_pose_stamped(truth(40)))
    bench.until(lambda: len(heard) == 21)


def test_a_bad_system_is_refused(bench):
    with pytest.raises(RangeError, match="dropout is 2.0"):
        bench.make(MocapSimulator, parameters={"dropout": 2.0})
