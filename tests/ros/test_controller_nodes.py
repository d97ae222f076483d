"""Controllers as nodes: what they send, when, and when they give up."""

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from crazychoir_fw import control
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import (
    FlatnessAccelerationCtrl,
    FlatnessPositionCtrl,
    FPQRSender,
    GeometryAttitudeCtrl,
    VelocityCtrlStrategy,
    VelSender,
)
from crazychoir_fw.planning import AccelerationTraj, FullStateTraj, PositionTraj
from crazychoir_fw.ros.controller import CrazyflieController, HierarchicalController, VelocityController
from crazychoir_fw.ros.conversions import pose_to_odometry, reference_to_message

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
HOVER = 0.038 * 9.80665


def odometry(time, position=(0.0, 0.0, 1.0), velocity=(0.0, 0.0, 0.0), orientation=LEVEL):
    return pose_to_odometry(Pose(np.array(position), np.array(orientation), np.array(velocity), np.zeros(3), time))


def parts(law=FlatnessPositionCtrl, traj=FullStateTraj):
    return {
        "pos_strategy": law(),
        "attitude_strategy": GeometryAttitudeCtrl(),
        "command_sender": FPQRSender(),
        "traj_handler": traj(),
    }


class Desk:
    """A controller with everything connected."""

    def __init__(self, bench, kind, reference=None, **options):
        self.bench = bench
        self.commands = bench.hear(Twist, "/agent_0/cmd_vel")
        self.node = bench.make(kind, agent_id=0, **options)
        self.odom = bench.speaker(Odometry, "/agent_0/odom")
        self.reference = bench.speaker(*reference) if reference else None

    def pose(self, time, *args, **options):
        """Tell a pose, and wait until it is there."""
        self.odom.publish(odometry(time, *args, **options))
        self.bench.until(lambda: self.node.current_pose.time == pytest.approx(time))

    def refer(self, message):
        """Tell a reference, and wait until it is there."""
        before = self.node.controller.desired_reference
        self.reference.publish(message)
        self.bench.until(lambda: self.node.controller.desired_reference is not before)

    def commanded(self, count):
        """Wait for so many commands, and return the last one."""
        self.bench.until(lambda: len(self.commands) >= count)
        self.bench.drain()
        assert len(self.commands) == count
        return self.commands[-1]


def test_nothing_is_sent_before_there_is_a_pose(bench):
    desk = Desk(bench, HierarchicalController, **parts())
    for k in range(5):
        bench.at(0.01 * k + 1.0)
    assert desk.commands == []
    desk.pose(1.05)
    bench.at(1.05)
    assert desk.commanded(1).linear.z == pytest.approx(HOVER)


def test_the_command_is_that_of_the_plain_controller(bench):
    topic = (MultiDOFJointTrajectoryPoint, "/agent_0/fullstate")
    desk = Desk(bench, HierarchicalController, topic, **parts())
    plain = control.HierarchicalController(**parts())
    reference = Reference(np.array([0.0, 0.0, 1.0]), np.array([0.1, 0, 0]), np.array([0.2, -0.1, 0.3]), yaw=0.25)
    bench.at(1.0)
    desk.refer(reference_to_message(reference, "fullstate"))
    q = [0.064071348, -0.091157549, 0.153439302, 0.981856173]
    desk.pose(1.01, (0.1, -0.2, 0.9), (0.05, 0.1, -0.02), q)
    bench.at(1.01)
    plain.set_pose(desk.node.current_pose)
    plain.set_reference(reference)
    twist, message = plain.step(1.01), desk.commanded(1)
    assert message.linear.z == pytest.approx(twist.linear[2], rel=1e-9)
    # the number of docs/reference/crazychoir.md#23
    assert message.linear.z == pytest.approx(0.4991406701, abs=1e-6)
    got = [message.angular.x, message.angular.y, message.angular.z]
    np.testing.assert_allclose(got, twist.angular, rtol=1e-6)


def test_every_pose_is_answered_whatever_comes_first(bench):
    desk = Desk(bench, HierarchicalController, **parts())
    bench.at(1.0)
    for k in range(1, 21):
        now = 1.0 + 0.01 * k
        if k % 2:
            desk.pose(now)
            bench.at(now)
        else:
            bench.at(now)
            desk.pose(now)
        assert desk.commanded(k).linear.z == pytest.approx(HOVER)


def test_with_slow_poses_the_clock_leads(bench):
    desk = Desk(bench, HierarchicalController, **parts())
    bench.at(1.0)
    for k in range(1, 41):
        now = 1.0 + 0.01 * k
        if k % 20 == 1:
            desk.pose(now)
        bench.at(now)
    assert desk.commanded(40).linear.z == pytest.approx(HOVER)


def test_the_last_reference_is_held(bench):
    desk = Desk(
        bench,
        HierarchicalController,
        (Vector3, "/agent_0/acceleration"),
        **parts(FlatnessAccelerationCtrl, AccelerationTraj),
    )
    bench.at(1.0)
    desk.refer(Vector3(z=2.0))
    for k in range(1, 30):
        desk.pose(1.0 + 0.01 * k)
        bench.at(1.0 + 0.01 * k)
    assert desk.commanded(29).linear.z == pytest.approx(0.038 * (9.80665 + 2.0))


def test_when_accelerations_cease_the_drone_is_held_in_place(bench, monkeypatch):
    desk = Desk(
        bench,
        HierarchicalController,
        (Vector3, "/agent_0/acceleration"),
        parameters={"reference_timeout": 0.2},
        **parts(FlatnessAccelerationCtrl, AccelerationTraj),
    )
    warned = []
    monkeypatch.setattr(type(desk.node.get_logger()), "warning", lambda _, text, **options: warned.append(text))
    bench.at(1.0)
    desk.refer(Vector3(z=2.0))
    for k in range(1, 41):
        desk.pose(1.0 + 0.01 * k, (0.0, 0.0, 1.0 + 0.01 * k), (0.0, 0.0, 0.5))
        bench.at(1.0 + 0.01 * k)
    desk.commanded(40)
    thrust = [command.linear.z for command in desk.commands]
    assert thrust[:21] == pytest.approx([0.038 * (9.80665 + 2.0)] * 21)
    assert max(thrust[21:]) < HOVER, "it brakes"
    assert min(thrust[-5:]) < 0.038 * (9.80665 - 2.8 * 0.5), "and goes back"
    assert len(warned) == 1 and "no reference for 0.2 s" in warned[0]
    desk.refer(Vector3(z=1.0))
    desk.pose(1.41)
    bench.at(1.41)
    assert desk.commanded(41).linear.z == pytest.approx(0.038 * (9.80665 + 1.0)), "until the next one comes"


@pytest.mark.parametrize(("velocity", "held"), [(0.0, True), (0.5, False)])
def test_when_full_states_cease_one_at_rest_is_held(bench, velocity, held):
    topic = (MultiDOFJointTrajectoryPoint, "/agent_0/fullstate")
    desk = Desk(bench, HierarchicalController, topic, parameters={"reference_timeout": 0.1}, **parts())
    bench.at(1.0)
    reference = Reference(np.array([0.0, 0.0, 2.0]), np.array([velocity, 0.0, 0.0]), np.zeros(3), yaw=0.0)
    desk.refer(reference_to_message(reference, "fullstate"))
    for k in range(1, 21):
        desk.pose(1.0 + 0.01 * k)
        bench.at(1.0 + 0.01 * k)
    desk.commanded(20)
    assert (desk.node.controller.desired_reference is not None) == held
    assert (desk.commands[-1].linear.z > 1.1 * HOVER) == held


def test_a_bad_reference_changes_nothing(bench):
    desk = Desk(
        bench,
        HierarchicalController,
        (Vector3, "/agent_0/acceleration"),
        **parts(FlatnessAccelerationCtrl, AccelerationTraj),
    )
    bench.at(1.0)
    desk.refer(Vector3(z=1.0))
    desk.reference.publish(Vector3(z=float("nan")))
    bench.drain()
    desk.pose(1.01)
    bench.at(1.01)
    assert desk.commanded(1).linear.z == pytest.approx(0.038 * (9.80665 + 1.0))


def test_old_poses_end_the_commands_until_new_ones_come(bench):
    desk = Desk(bench, HierarchicalController, parameters={"pose_timeout": 0.1}, **parts())
    bench.at(1.0)
    for now in (1.01, 1.02):
        desk.pose(now)
        bench.at(now)
    for k in range(3, 40):
        bench.at(1.0 + 0.01 * k)
    count = len(desk.commands)
    assert 2 <= count <= 12, "went on for the patience at most"
    desk.pose(1.40)
    bench.at(1.40)
    desk.commanded(count + 1)


def test_a_reset_of_the_simulation_starts_anew(bench):
    topic = (MultiDOFJointTrajectoryPoint, "/agent_0/fullstate")
    desk = Desk(bench, HierarchicalController, topic, **parts())
    bench.at(30.0)
    desk.refer(reference_to_message(Reference(np.array([0.0, 0.0, 3.0])), "fullstate"))
    desk.pose(30.01)
    bench.at(30.01)
    assert desk.commanded(1).linear.z > 1.2 * HOVER
    bench.at(0.5)
    bench.at(0.51)
    assert len(desk.commands) == 1, "the pose is that of the flight before"
    desk.pose(0.52)
    bench.at(0.52)
    assert desk.commanded(2).linear.z == pytest.approx(HOVER), "the reference, too"


def test_the_velocity_controller_sends_velocities(bench):
    desk = Desk(
        bench,
        VelocityController,
        (Vector3, "/agent_0/position"),
        velocity_strategy=VelocityCtrlStrategy(),
        command_sender=VelSender(),
        traj_handler=PositionTraj(),
    )
    bench.at(1.0)
    desk.refer(Vector3(x=1.0, z=1.0))
    desk.pose(1.01)
    bench.at(1.01)
    message = desk.commanded(1)
    assert (message.linear.x, message.linear.z) == (pytest.approx(0.4), pytest.approx(0.0))


def test_a_plain_controller_may_be_handed_over(bench):
    plain = control.HierarchicalController(**parts())
    desk = Desk(bench, CrazyflieController, controller=plain)
    assert desk.node.controller is plain
    bench.at(1.0)
    desk.pose(1.01)
    bench.at(1.01)
    desk.commanded(1)


def test_subclasses_may_send_otherwise(bench):
    class Doubled(HierarchicalController):
        def send_input(self, twist):
            twist.linear[...] *= 2.0
            super().send_input(twist)

    desk = Desk(bench, Doubled, **parts())
    bench.at(1.0)
    desk.pose(1.01)
    bench.at(1.01)
    assert desk.commanded(1).linear.z == pytest.approx(2.0 * HOVER)


def test_parts_that_are_missing_leave_no_node_behind(bench):
    with pytest.raises(RangeError, match="command_sender"):
        bench.make(HierarchicalController, agent_id=0, pos_strategy=FlatnessPositionCtrl())
    with pytest.raises(NotImplementedError, match="make_controller"):
        bench.make(CrazyflieController, agent_id=0, command_sender=FPQRSender())
    assert ("controller", "/agent_0") not in bench.user.get_node_names_and_namespaces()


def test_introspection_shows_the_topics_of_the_table(bench):
    node = bench.make(HierarchicalController, agent_id=0, **parts(FlatnessAccelerationCtrl, AccelerationTraj))
    subscribed = dict(bench.user.get_subscriber_names_and_types_by_node("controller", "/agent_0"))
    published = dict(bench.user.get_publisher_names_and_types_by_node("controller", "/agent_0"))
    assert subscribed["/agent_0/odom"] == ["nav_msgs/msg/Odometry"]
    assert subscribed["/agent_0/acceleration"] == ["geometry_msgs/msg/Vector3"]
    assert subscribed["/clock"] == ["rosgraph_msgs/msg/Clock"]
    assert published["/agent_0/cmd_vel"] == ["geometry_msgs/msg/Twist"]
    (info,) = bench.user.get_publishers_info_by_topic("/agent_0/cmd_vel")
    assert info.qos_profile.reliability.name == "RELIABLE" and info.qos_profile.durability.name == "VOLATILE"
    assert node.describe_parameter("pose_timeout").description
