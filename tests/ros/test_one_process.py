"""`--processes one`: the engine of a flight without ROS, which others see and steer by topics."""

import json

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from ros_flights import PATIENCE, Flight
from std_msgs.msg import Bool, Empty, String
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.flight import fly
from crazychoir_fw.mission import load_mission
from crazychoir_fw.ros.conversions import points_to_joint_trajectory
from crazychoir_fw.ros.names import LATEST, TRAJ_PARAMS, qos

MISSION = """
name: seen
backend: sim
seed: 3
drones:
  - {id: leader, position: [0.0, 0.0]}
  - {id: follower, position: [0.8, 0.1]}
layers:
  communication: {graph: complete}
  guidance:
    class: BearingFormation
    leaders: [leader, follower]
    formation: [[0.0, 0.0], [0.8, 0.0]]
    height: 0.5
    gains: mujoco
  planning: {class: Spline}
  control: {gains: mujoco}
flight:
  - takeoff: {duration: 2.0}
  - start: {duration: 1.0}
  - land: {duration: 2.0}
criteria: {landed: false}
"""


def logged(path):
    with np.load(path) as log:
        return {name: log[name] for name in log.files if name.startswith("signal/") or name == "time"}


def test_it_has_the_bits_of_a_flight_without_ros_and_is_heard(tmp_path):
    flight = Flight(tmp_path, MISSION, "--processes", "one")
    heard = {}
    topics = {
        "/agent_1/odom": Odometry,
        "/agent_1/cmd_vel": Twist,
        "/agent_1/fullstate": MultiDOFJointTrajectoryPoint,
        "/takeoff": Empty,
        "/experiment_trigger": Empty,
        "/land": Empty,
        "/communication_statistics": String,
        "/events": String,
    }
    try:
        for topic, kind in topics.items():
            heard[topic] = []
            flight.node.create_subscription(kind, topic, heard[topic].append, qos(1000))
        idle = []
        flight.node.create_subscription(Bool, "/agent_1/idle", lambda message: idle.append(message.data), LATEST)
        flight.until(lambda: flight.time > 1.0, "it flies")
        while flight.process.poll() is None:
            flight.executor.spin_once(timeout_sec=0.05)
        assert flight.process.wait(PATIENCE) == 0, flight.log.read_text()[-3000:]
    finally:
        flight.close()
    alone = fly(load_mission(flight.file), visuals=False)
    alone.log.save(tmp_path / "alone.npz")
    ours, theirs = logged(flight.out / "log.npz"), logged(tmp_path / "alone.npz")
    assert ours.keys() == theirs.keys()
    for name in ours:
        np.testing.assert_array_equal(ours[name], theirs[name], err_msg=name)
    assert json.loads((flight.out / "processes.json").read_text()).keys() == {"host"}
    assert {topic: bool(messages) for topic, messages in heard.items()} == dict.fromkeys(topics, True)
    assert len(heard["/takeoff"]) == len(heard["/experiment_trigger"]) == len(heard["/land"]) == 1
    assert idle == [False, True]
    assert json.loads(heard["/communication_statistics"][-1].data)["rounds"] > 0
    assert max(message.linear.z for message in heard["/agent_1/cmd_vel"]) == pytest.approx(0.37, abs=0.15)


STEERED = """
name: steered
backend: integrator
drones:
  - {id: agent_0, position: [0.0, 0.0]}
  - {id: agent_1, position: [1.0, 0.0]}
layers:
  guidance: {class: SimpleGuidance, height: 0.5}
  planning: {class: Spline}
  control: {gains: mujoco}
flight:
  - takeoff: {duration: 1.5}
  - start: {duration: 3000.0}
"""


def test_trajectories_and_buttons_of_others_are_carried_out(tmp_path):
    flight = Flight(tmp_path, STEERED, "--processes", "one", "--pace", "10")
    try:
        place = {}

        def taker(i):
            def take(message):
                point = message.pose.pose.position
                place[i] = np.array((point.x, point.y, point.z))

            return take

        for i in range(2):
            flight.node.create_subscription(Odometry, f"/agent_{i}/odom", taker(i), qos(10))
        nothing = []
        flight.node.create_subscription(Vector3, "/agent_0/position", nothing.append, qos(10))
        speak = flight.node.create_publisher(TRAJ_PARAMS.type, "/agent_0/traj_params", 10)
        land = flight.node.create_publisher(Empty, "/agent_1/land", 10)
        flight.see(lambda: speak.get_subscription_count() and land.get_subscription_count(), "both are heard")
        flight._said = flight.node.create_publisher(String, "/ready", LATEST)
        flight._said.publish(String(data="onlooker"))
        flight.see(lambda: flight.time > 3.0 and place[0][2] > 0.45, "it is up")
        goal = np.array((-0.5, 0.4, 0.7))
        speak.publish(points_to_joint_trajectory([TrajectoryPoint(1.0, goal)], 0))
        land.publish(Empty())
        flight.see(lambda: np.linalg.norm(place[0] - goal) < 0.05, "it flies where it was sent")
        flight.see(lambda: place[1][2] < 0.05, "the other one has landed")
        assert not nothing
    finally:
        flight.close()
