"""Nodes of target surveillance: classes of the original over topics."""

import numpy as np
from geometry_msgs.msg import Vector3
from nav_msgs.msg import Odometry
from std_msgs.msg import Empty

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros import AggregativeGuidanceCrazyflie, AggregativeGuidanceCrazyflieMovingIntruder
from crazychoir_fw.ros.conversions import pose_to_odometry, to_stamp

STARTS = [(0.4, 0.0, 1.0), (-0.4, 0.0, 1.0)]


def odometry(position, now):
    message = pose_to_odometry(
        Pose(np.array(position, float), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))
    )
    message.header.stamp = to_stamp(now)
    return message


def parameters(i, **more):
    return {"N": 2, "in_neigh": [1 - i], "weights": [0.5, 0.5], "target": [0.0, 0.0, 1.0], **more}


def test_two_nodes_find_places_half_way_to_their_intruders(bench):
    intruders = [[1.0, 1.0], [-1.0, 1.0]]
    nodes = [
        bench.make(
            AggregativeGuidanceCrazyflie,
            agent_id=i,
            stepsize=0.05,
            takeoff_time=0.02,
            parameters=parameters(i, intruder=intruders[i]),
        )
        for i in range(2)
    ]
    heard = bench.hear(Vector3, "/agent_0/position")
    fly(bench, nodes, {0: STARTS[0], 1: STARTS[1]}, 120)
    assert nodes[0].guidance.algorithm.rounds >= 100
    np.testing.assert_allclose([heard[-1].x, heard[-1].y, heard[-1].z], [0.5, 0.5, 1.0], atol=0.02)


def test_an_intruder_is_another_drone_on_odom(bench):
    nodes = [
        bench.make(
            AggregativeGuidanceCrazyflieMovingIntruder,
            agent_id=i,
            stepsize=0.05,
            takeoff_time=0.02,
            parameters=parameters(i),
        )
        for i in range(2)
    ]
    assert [node.guidance.watched for node in nodes] == [(2,), (3,)]
    heard = bench.hear(Vector3, "/agent_1/position")
    fly(bench, nodes, {0: STARTS[0], 1: STARTS[1], 2: (1.0, 0.0, 1.0), 3: (-1.0, 0.4, 1.0)}, 120)
    np.testing.assert_allclose([heard[-1].x, heard[-1].y], [-0.5, 0.2], atol=0.02)


def fly(bench, nodes, places, rounds):
    """Press start and let time pass, with all drones standing still."""
    speakers = {i: bench.speaker(Odometry, f"/agent_{i}/odom") for i in places}
    press = bench.speaker(Empty, "/experiment_trigger", len(nodes))
    bench.until(lambda: all(node.is_connected for node in nodes))
    for k in range(rounds):
        now = 1.0 + 0.01 * k
        for i, place in places.items():
            speakers[i].publish(odometry(place, now))
        bench.at(now)
        if k == 1:
            press.publish(Empty())
            bench.until(lambda: all(node.guidance.phase.value == "flight" for node in nodes))
