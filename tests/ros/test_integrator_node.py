"""The integrator as a node, alone and in closed loop, in step with simulated time."""

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty
from trajectory_msgs.msg import JointTrajectory

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.control import FlatnessPositionCtrl, FPQRSender, GeometryAttitudeCtrl
from crazychoir_fw.planning import FullStateTraj
from crazychoir_fw.ros.controller import HierarchicalController
from crazychoir_fw.ros.conversions import odometry_to_pose, points_to_joint_trajectory, seconds
from crazychoir_fw.ros.integrator import CrazyflieIntegrator
from crazychoir_fw.ros.trajectory import Polynomial7th
from crazychoir_fw.simulation import integrator as plain


def test_odometry_has_stamp_frames_and_the_state(bench):
    heard = bench.hear(Odometry, "/agent_3/odom")
    node = bench.make(CrazyflieIntegrator, agent_id=3, parameters={"init_pos": [1, 2, 0.5]}, gravity=9.80665)
    commands = bench.speaker(Twist, "/agent_3/cmd_vel")
    bench.at(5.0)
    commands.publish(Twist(linear=Vector3(z=1.1 * 0.038 * 9.80665), angular=Vector3(x=0.5, y=-0.3, z=0.2)))
    bench.until(lambda: node._is_new)
    alone = plain.CrazyflieIntegrator(init_pos=(1.0, 2.0, 0.5), gravity=9.80665)
    alone.command(1.1 * 0.038 * 9.80665, 0.5, -0.3, 0.2)
    for k in range(1, 21):
        bench.at(5.0 + 0.01 * k)
    bench.until(lambda: len(heard) >= 20)
    steps = round(node.integrator.time * 100)
    alone.step(steps)
    pose = odometry_to_pose(heard[-1])
    np.testing.assert_allclose(pose.position, alone.state[:3], atol=1e-12)
    np.testing.assert_allclose(pose.velocity, alone.state[6:9], atol=1e-12)
    np.testing.assert_allclose(pose.angular, [0.5, -0.3, 0.2])
    assert (heard[-1].header.frame_id, heard[-1].child_frame_id) == ("odom", "base_link")
    assert seconds(heard[-1].header.stamp) == pytest.approx(5.2)


def test_without_commands_a_drone_hovers_and_starts_where_the_plain_one_does(bench):
    node = bench.make(CrazyflieIntegrator, agent_id=2)
    for k in range(20):
        bench.at(1.0 + 0.01 * k)
    wanted = plain.CrazyflieIntegrator(agent_id=2).state[:3]
    np.testing.assert_allclose(node.integrator.state[0, :3], wanted, atol=1e-12)


def test_time_that_jumps_forward_is_made_up_for_a_little_only(bench):
    node = bench.make(CrazyflieIntegrator, agent_id=0)
    for now in (1.0, 1.01, 1.02, 1.07, 60.0):
        bench.at(now)
    assert node.integrator.time <= 0.07 + 0.1 + 1e-9
    time = node.integrator.time
    bench.at(60.01)
    assert node.integrator.time == pytest.approx(time + 0.01)


def test_a_command_that_is_no_number_is_left_out(bench):
    node = bench.make(CrazyflieIntegrator, agent_id=0)
    commands = bench.speaker(Twist, "/agent_0/cmd_vel")
    commands.publish(Twist(linear=Vector3(z=float("nan"))))
    bench.drain()
    for k in range(5):
        bench.at(1.0 + 0.01 * k)
    assert np.isfinite(node.integrator.state).all()


def test_stop_is_free_fall_until_resumed(bench):
    node = bench.make(CrazyflieIntegrator, agent_id=0, parameters={"init_pos": [0, 0, 10]})
    stop, resume = bench.speaker(Empty, "/stop"), bench.speaker(Empty, "/resume")
    commands = bench.speaker(Twist, "/agent_0/cmd_vel")
    bench.at(1.0)
    stop.publish(Empty())
    bench.until(lambda: node._is_stopped)
    commands.publish(Twist(linear=Vector3(z=5.0)))
    bench.until(lambda: node._is_new)
    for k in range(1, 6):
        bench.at(1.0 + 0.01 * k)
    assert node.integrator.state[0, 8] < 0.0
    resume.publish(Empty())
    bench.until(lambda: not node._is_stopped)
    for k in range(6, 12):
        bench.at(1.0 + 0.01 * k)
    assert node.integrator.state[0, 8] > 0.0


@pytest.mark.parametrize(
    ("command", "twist", "grows"),
    [
        ("vel", Twist(linear=Vector3(x=1.0)), 6),
        ("frpy", Twist(linear=Vector3(z=0.038 * 9.81), angular=Vector3(y=0.2)), 6),
    ],
)
def test_other_commands(bench, command, twist, grows):
    node = bench.make(CrazyflieIntegrator, agents=[0, 1], command=command)
    commands = bench.speaker(Twist, "/agent_1/cmd_vel")
    commands.publish(twist)
    bench.until(lambda: node._is_new)
    for k in range(30):
        bench.at(1.0 + 0.01 * k)
    assert node.integrator.state[1, grows] > 0.05
    assert abs(node.integrator.state[0, grows]) < 1e-9


def test_it_may_be_the_source_of_the_clock(bench):
    heard, odometry = bench.hear(Clock, "/clock"), bench.hear(Odometry, "/agent_1/odom")
    made = CrazyflieIntegrator(agents=[0, 1], publish_clock=True, speed=20.0, context=bench.context)
    bench.add(made)
    bench.until(lambda: len(heard) >= 20 and len(odometry) >= 20)
    np.testing.assert_allclose([seconds(m.clock) for m in heard[:20]], 0.01 * np.arange(1, 21), atol=1e-9)
    assert seconds(odometry[0].header.stamp) == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"command": "xyz"}, "command is 'xyz'"),
        ({"publish_clock": True, "speed": 0.0}, "speed is 0.0"),
        ({"publish_clock": True}, "publish_clock with use_sim_time"),
        ({"parameters": {"init_pos": [1.0, 2.0]}}, "init_pos"),
    ],
)
def test_what_does_not_fit_is_refused(bench, options, words):
    with pytest.raises(RangeError, match=words):
        bench.make(CrazyflieIntegrator, agent_id=0, **options)


def test_a_flight_through_all_nodes_in_step_with_the_clock(bench):
    """Integrator, controller and trajectory handler: the drone ends where the go-to says."""
    drone = bench.make(CrazyflieIntegrator, agent_id=0, parameters={"init_pos": [0, 0, 0.5]})
    heard, commands = bench.hear(Odometry, "/agent_0/odom"), bench.hear(Twist, "/agent_0/cmd_vel")
    bench.make(
        HierarchicalController,
        agent_id=0,
        pos_strategy=FlatnessPositionCtrl(),
        attitude_strategy=GeometryAttitudeCtrl(),
        command_sender=FPQRSender(),
        traj_handler=FullStateTraj(),
    )
    handler = bench.make(Polynomial7th, agent_id=0)
    points = bench.speaker(JointTrajectory, "/agent_0/traj_params")
    for k in range(110):
        if k == 1:
            # without a pose nothing is planned before the next tick, and there is none while time stands still
            bench.until(lambda: handler.current_pose.position is not None)
            points.publish(points_to_joint_trajectory([TrajectoryPoint(0.7, np.array([0.1, -0.05, 0.6]))], 0))
            bench.until(lambda: handler.handler.trajectory is not None)
        bench.at(1.0 + 0.01 * k)
        bench.until(lambda k=k: len(heard) >= k and len(commands) >= k)
    np.testing.assert_allclose(drone.integrator.state[0, :3], [0.1, -0.05, 0.6], atol=0.02)
