"""Neighbor search and filters, as nodes: what they send, when, and what they do when a node is silent."""

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from std_msgs.msg import UInt8MultiArray

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.control import FPQRSender, GeometryAttitudeCtrl, SafeFlatnessPositionCtrl
from crazychoir_fw.control.safety import DoubleIntegratorCBF, SingleIntegratorCBF
from crazychoir_fw.planning import PositionTraj
from crazychoir_fw.ros.conversions import from_bytes, labeled_bytes, pose_to_odometry
from crazychoir_fw.ros.neighbor_sensing import ClosestRobotGetter, closest_to_message, message_to_closest
from crazychoir_fw.ros.safety import (
    CollisionAvoidance,
    EveryRound,
    Gathering,
    SafeHierarchicalController,
    SingleIntegratorCollisionAvoidance,
)

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def odometry(time, position, velocity=(0.0, 0.0, 0.0)):
    return pose_to_odometry(Pose(np.array(position, float), LEVEL, np.array(velocity, float), np.zeros(3), time))


# ---------------------------------------------------------------- the message


def read(data):
    return message_to_closest(from_bytes(data, UInt8MultiArray))


@given(st.integers(0, 6), st.integers(0, 10**12))
def test_closest_robots_survive_the_way(count, nanoseconds):
    dice = np.random.default_rng(count)
    position, velocity = dice.uniform(-9, 9, (2, count, 3))
    time, numbers, poses = read(closest_to_message(nanoseconds / 1e9, range(count), position, velocity))
    assert time == pytest.approx(nanoseconds / 1e9)
    assert numbers.tolist() == list(range(count))
    np.testing.assert_array_equal(poses.position, position)
    np.testing.assert_array_equal(poses.velocity, velocity)


@given(st.binary(max_size=80))
def test_anything_else_is_refused(data):
    with pytest.raises(CrazychoirError):
        read(labeled_bytes(1, data))


@pytest.mark.parametrize(
    ("position", "velocity"), [(np.full((1, 3), np.nan), np.zeros((1, 3))), (np.zeros((2, 3)), np.zeros((1, 3)))]
)
def test_numbers_that_are_none_are_refused(position, velocity):
    with pytest.raises(RangeError, match="closest_robots"):
        read(closest_to_message(1.0, [3], position, velocity))


# ---------------------------------------------------------------- what belongs to one time


def test_a_pose_waits_for_what_belongs_to_it():
    done = []
    gathering = Gathering(done.append, wants_desired=True)
    gathering.took_pose(1.0)
    gathering.took_closest(1.0)
    assert done == []
    gathering.took_desired()
    assert done == [1.0]
    gathering.took_desired()  # the desired input comes before the pose
    gathering.took_closest(1.01)
    gathering.took_pose(1.01)
    assert done == [1.0, 1.01]


def test_who_is_silent_is_waited_for_once():
    done = []
    gathering = Gathering(done.append, wants_desired=False)
    gathering.took_pose(1.0)
    gathering.took_pose(1.01)
    assert done == [1.01]
    gathering.took_pose(1.02)
    assert done == [1.01, 1.02]
    gathering.took_closest(1.03)
    gathering.took_pose(1.03)
    gathering.took_pose(1.04)
    assert done == [1.01, 1.02, 1.03]  # its messages arrive again, so that the node waits again


def test_a_command_is_repeated_in_rounds_without_one():
    class Rare:
        def step(self, now):
            return "command" if now == 0.0 else None

    controller = EveryRound(Rare(), 50.0)
    assert [controller.step(0.0), controller.step(0.02)] == ["command", "command"]
    assert controller.periods == (0.02,)


# ---------------------------------------------------------------- nodes


def test_everybody_is_told_who_is_near(bench):
    node = bench.make(ClosestRobotGetter, 2.0, agents=[0, 1, 2], freq=100.0)
    heard = [bench.hear(UInt8MultiArray, f"/agent_{i}/closest_robots") for i in range(3)]
    speakers = [bench.speaker(Odometry, f"/agent_{i}/odom") for i in range(3)]
    for now in (1.0, 1.01):  # the first round only makes the drones known
        bench.at(now)
        for row, place in enumerate(([0, 0, 1], [1.5, 0, 1], [1, 0, 0.02])):
            speakers[row].publish(odometry(now, place, (0.1, 0.0, 0.0)))
            bench.until(lambda row=row, now=now: node._stamp[row] == pytest.approx(now))
    bench.until(lambda: all(len(one) >= 2 for one in heard))
    time, numbers, poses = message_to_closest(heard[0][-1])
    assert time == pytest.approx(1.01)
    assert numbers.tolist() == [1]  # the other one lies on the floor
    np.testing.assert_allclose(poses.position, [[1.5, 0.0, 1.0]])
    assert message_to_closest(heard[2][-1])[1].tolist() == [1, 0]
    # silent ones stand, and are gone at last
    speakers[0].publish(odometry(1.7, [0, 0, 1]))
    bench.until(lambda: node._stamp[0] > 1.6)
    bench.at(1.7)
    bench.until(lambda: message_to_closest(heard[0][-1])[0] > 1.6)
    assert not message_to_closest(heard[0][-1])[2].velocity.any()


def test_a_filter_between_controller_and_drone(bench):
    node = bench.make(
        SingleIntegratorCollisionAvoidance, node_frequency=50.0, safety_filter=SingleIntegratorCBF(), agent_id=0
    )
    commands = bench.hear(Twist, "/agent_0/cmd_vel")
    desired = bench.speaker(Twist, "/agent_0/cmd_vel_des")
    odom = bench.speaker(Odometry, "/agent_0/odom")
    closest = bench.speaker(UInt8MultiArray, "/agent_0/closest_robots")
    wish = Twist()
    wish.linear.x, wish.linear.z = 0.1, 0.3
    bench.at(1.0)
    odom.publish(odometry(1.0, [0, 0, 1]))
    desired.publish(wish)
    bench.until(lambda: node.avoidance._desired is not None and node.avoidance.is_ready)
    bench.at(1.02)
    assert commands == []  # no message about neighbors yet
    closest.publish(closest_to_message(1.02, [1], np.array([[0.6, 0.0, 1.0]]), np.zeros((1, 3))))
    bench.until(lambda: node._sight.has_seen)
    bench.at(1.04)
    bench.until(lambda: len(commands) >= 1)
    assert commands[-1].linear.x == pytest.approx(5.0 * 0.2**3 / 1.2)
    assert commands[-1].linear.z == pytest.approx(0.3)
    # blind
    bench.at(1.9)
    odom.publish(odometry(1.9, [0, 0, 1]))
    desired.publish(wish)
    bench.until(lambda: node._pose_time == 1.9)
    count = len(commands)
    bench.at(1.92)
    bench.until(lambda: len(commands) > count)
    assert commands[-1].linear.x == 0.0
    assert commands[-1].linear.z == 0.0


def test_a_safe_controller_stays_where_it_is_when_it_is_blind(bench):
    law = SafeFlatnessPositionCtrl(0, 100.0, DoubleIntegratorCBF(max_acceleration=1.0))
    node = bench.make(
        SafeHierarchicalController,
        pos_strategy=law,
        attitude_strategy=GeometryAttitudeCtrl(),
        command_sender=FPQRSender(),
        traj_handler=PositionTraj(),
        agent_id=0,
        parameters={"reference_timeout": 0.0},
    )
    commands = bench.hear(Twist, "/agent_0/cmd_vel")
    odom = bench.speaker(Odometry, "/agent_0/odom")
    goal = bench.speaker(Vector3, "/agent_0/position")
    closest = bench.speaker(UInt8MultiArray, "/agent_0/closest_robots")
    goal.publish(Vector3(x=1.0, y=0.0, z=1.0))
    bench.until(lambda: node.controller.desired_reference is not None)
    bench.at(1.0)
    odom.publish(odometry(1.0, [0, 0, 1]))
    bench.until(lambda: node.current_pose.time == 1.0)
    assert commands == []
    nobody = np.zeros((0, 3))
    closest.publish(closest_to_message(1.0, [], nobody, nobody))
    bench.until(lambda: node._sight.has_seen)
    bench.at(1.01)
    bench.until(lambda: len(commands) >= 1)
    assert commands[-1].angular.y > 0.1  # forward
    bench.at(1.8)
    odom.publish(odometry(1.8, [0, 0, 1]))
    bench.until(lambda: node.current_pose.time == 1.8)
    count = len(commands)
    bench.at(1.81)
    bench.until(lambda: len(commands) > count)
    assert commands[-1].angular.y == pytest.approx(0.0, abs=1e-9)


def test_parts_are_needed(ros_context):
    with pytest.raises(RangeError, match="avoidance is None"):
        CollisionAvoidance(agent_id=0, context=ros_context)
    with pytest.raises(RangeError, match="safety_filter is NoneType, allowed: SingleIntegratorCBF"):
        SingleIntegratorCollisionAvoidance(agent_id=0, context=ros_context)
