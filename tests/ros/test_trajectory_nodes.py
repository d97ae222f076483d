"""Trajectory handlers as nodes: points in, references out."""

import numpy as np
import pytest
from geometry_msgs.msg import Vector3
from nav_msgs.msg import Odometry
from trajectory_msgs.msg import JointTrajectory, MultiDOFJointTrajectoryPoint

from crazychoir_fw import planning
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.ros import trajectory
from crazychoir_fw.ros.conversions import message_to_reference, points_to_joint_trajectory, pose_to_odometry

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
START = np.array([0.0, 0.0, 1.0])
GO_TO = [TrajectoryPoint(0.2, np.array([0.1, 0.2, 1.0]))]


def here(time, position=START):
    return pose_to_odometry(Pose(position, LEVEL, np.zeros(3), np.zeros(3), time))


def connected(bench, node):
    odom, points = bench.speaker(Odometry, "/agent_0/odom"), bench.speaker(JointTrajectory, "/agent_0/traj_params")
    bench.at(1.0)
    odom.publish(here(1.0))
    bench.until(lambda: node.current_pose.position is not None)
    return odom, points


def plan(bench, node, publisher, points):
    before = node.handler.trajectory
    publisher.publish(points_to_joint_trajectory(points, 0))
    bench.until(lambda: node.handler.trajectory is not before)


@pytest.mark.parametrize("name", ["Polynomial7th", "Spline", "MinimumSnap"])
def test_full_states_are_those_of_the_plain_handler(bench, name):
    node = bench.make(getattr(trajectory, name), agent_id=0)
    heard = bench.hear(MultiDOFJointTrajectoryPoint, "/agent_0/fullstate")
    _, points = connected(bench, node)
    plan(bench, node, points, GO_TO)
    plain = getattr(planning, name)()
    plain.set_trajectory(GO_TO, Pose(START, LEVEL, np.zeros(3)), 1.0)
    for k in range(1, 31):
        bench.at(1.0 + 0.01 * k)
    # one more behind the end, and then no more
    bench.until(lambda: len(heard) >= 20)
    bench.drain()
    assert 20 <= len(heard) <= 21
    for k, message in enumerate(heard[:20], start=1):
        wanted, got = plain.evaluate(1.0 + 0.01 * k), message_to_reference(message, "fullstate")
        np.testing.assert_allclose(got.position, wanted.position, atol=1e-7)
        np.testing.assert_allclose(got.velocity, wanted.velocity, atol=1e-6)
    np.testing.assert_allclose(message_to_reference(heard[-1], "fullstate").velocity, 0.0, atol=1e-6)
    np.testing.assert_allclose(message_to_reference(heard[-1], "fullstate").position, GO_TO[0].position, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "topic"), [("SplinePosition", "/agent_0/position"), ("AccelerationTrajHandler", "/agent_0/acceleration")]
)
def test_others_send_vectors(bench, name, topic):
    node, heard = bench.make(getattr(trajectory, name), agent_id=0), bench.hear(Vector3, topic)
    _, points = connected(bench, node)
    plan(bench, node, points, GO_TO)
    for k in range(1, 25):
        bench.at(1.0 + 0.01 * k)
    bench.until(lambda: len(heard) >= 20)
    last = [heard[-1].x, heard[-1].y, heard[-1].z]
    np.testing.assert_allclose(last, GO_TO[0].position if name == "SplinePosition" else 0.0, atol=1e-6)


def test_points_that_come_before_the_pose_wait_for_it(bench):
    node, heard = (
        bench.make(trajectory.Spline, agent_id=0),
        bench.hear(MultiDOFJointTrajectoryPoint, "/agent_0/fullstate"),
    )
    points, odom = bench.speaker(JointTrajectory, "/agent_0/traj_params"), bench.speaker(Odometry, "/agent_0/odom")
    bench.at(1.0)
    points.publish(points_to_joint_trajectory(GO_TO, 0))
    bench.drain()
    bench.at(1.5)
    assert heard == [] and node.handler.trajectory is None
    odom.publish(here(1.5, START + 0.5))
    bench.until(lambda: node.current_pose.position is not None)
    bench.at(1.51)
    bench.until(lambda: heard)
    np.testing.assert_allclose(message_to_reference(heard[0], "fullstate").position, START + 0.5, atol=1e-3)


def test_a_trajectory_that_makes_no_sense_leaves_the_present_one(bench):
    node, heard = (
        bench.make(trajectory.Spline, agent_id=0),
        bench.hear(MultiDOFJointTrajectoryPoint, "/agent_0/fullstate"),
    )
    _, points = connected(bench, node)
    plan(bench, node, points, GO_TO)
    flown = node.handler.trajectory
    backwards = [TrajectoryPoint(2.0, np.ones(3)), TrajectoryPoint(1.0, np.ones(3))]
    points.publish(points_to_joint_trajectory(backwards, 0))
    points.publish(JointTrajectory())
    bench.drain()
    bench.at(1.01)
    bench.until(lambda: heard)
    assert node.handler.trajectory is flown


def test_a_trajectory_may_be_a_parameter(bench):
    # times, positions, velocities, accelerations, jerks of begin and end
    flat = [0.0, 0.5, 0, 0, 0, 1, 2, 3, *[0.0] * 18]
    node = bench.make(trajectory.Polynomial7th, agent_id=0, parameters={"traj_params": flat})
    connected(bench, node)
    bench.at(1.01)
    bench.until(lambda: node.handler.trajectory is not None)
    np.testing.assert_allclose(node.handler.evaluate(9.0).position, [1.0, 2.0, 3.0])


def test_options_of_the_plain_handler_and_other_topics(bench):
    node = bench.make(trajectory.Spline, 50.0, input_topic="elsewhere", agent_id=0, relative=True)
    heard = bench.hear(MultiDOFJointTrajectoryPoint, "/agent_0/elsewhere")
    _, points = connected(bench, node)
    plan(bench, node, points, GO_TO)
    for k in range(1, 11):
        bench.at(1.0 + 0.01 * k)
    bench.until(lambda: len(heard) >= 5)
    bench.drain()
    assert len(heard) == 5
    np.testing.assert_allclose(node.handler.evaluate(2.0).position, START + GO_TO[0].position)


def test_a_reset_of_the_simulation_forgets_the_trajectory(bench):
    node, heard = (
        bench.make(trajectory.Spline, agent_id=0),
        bench.hear(MultiDOFJointTrajectoryPoint, "/agent_0/fullstate"),
    )
    odom, points = connected(bench, node)
    plan(bench, node, points, [TrajectoryPoint(5.0, np.ones(3))])
    bench.at(1.01)
    bench.until(lambda: heard)
    bench.at(0.2)
    odom.publish(here(0.2))
    bench.at(0.3)
    count = len(heard)
    assert node.handler.trajectory is None
    for k in range(4, 8):
        bench.at(0.1 * k)
    assert len(heard) == count
