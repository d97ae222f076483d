"""What the layers of one drone share in one process: a subscription of its odometry, the time, references."""

from pathlib import Path

import numpy as np
import pytest
from nav_msgs.msg import Odometry

from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.mission import load_mission
from crazychoir_fw.ros.conversions import message_to_reference, pose_to_odometry, reference_to_bytes
from crazychoir_fw.ros.names import REFERENCES
from crazychoir_fw.ros.parts import parts_of, reference_answers
from crazychoir_fw.ros.process import make_nodes

EXAMPLE = Path(__file__).parents[2] / "examples" / "bearing_formation.yaml"
LEADER, FOLLOWER = 0, 2


@pytest.fixture
def mission():
    return load_mission(EXAMPLE)


@pytest.fixture
def process(bench, mission):
    """Return the nodes of a drone, those of all its layers, in the order guidance, planning if any, control."""

    def make(drone):
        part = parts_of(mission, "per-drone")[drone]
        return [bench.add(node) for node in make_nodes(mission, part, True, None, bench.context)]

    return make


@pytest.mark.parametrize("drone", [LEADER, FOLLOWER])
def test_odometry_is_heard_once_and_tells_the_time(bench, process, drone):
    nodes = process(drone)
    heard = [one.topic_name for node in nodes for one in node.subscriptions]
    assert heard.count(f"/agent_{drone}/odom") == 1
    assert "/clock" not in heard
    pose = Pose(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3), 3.25)
    bench.speaker(Odometry, f"/agent_{drone}/odom").publish(pose_to_odometry(pose))
    bench.until(lambda: all(node.now() == 3.25 for node in nodes))


@pytest.mark.parametrize(("drone", "source"), [(LEADER, 1), (FOLLOWER, 0)])
def test_a_reference_is_handed_over_and_published(bench, process, drone, source):
    nodes = process(drone)
    controller = nodes[-1].controller
    kind = controller.traj_handler.kind
    topic = f"/agent_{drone}/{kind}"
    assert topic not in [one.topic_name for one in nodes[-1].subscriptions]
    others = bench.hear(REFERENCES[kind].type, topic)
    publisher = nodes[source].reference_publisher
    bench.until(bench.is_connected)
    sent = Reference(np.array([0.0, 0.0, 1.0]), np.zeros(3), np.array([0.1, 0.2, 0.3]), yaw=0.0)
    publisher.publish(reference_to_bytes(sent, kind))
    np.testing.assert_array_equal(controller.desired_reference.acceleration, [0.1, 0.2, 0.3])
    bench.until(lambda: others)
    np.testing.assert_array_equal(message_to_reference(others[0], kind).acceleration, [0.1, 0.2, 0.3])


def test_references_answer_steps_only_where_guidance_gives_one_a_step(mission):
    assert [reference_answers(mission, i) for i in range(4)] == [False, False, True, True]
    lossy = load_mission(EXAMPLE, changes=["layers.communication.loss=0.1"])
    assert not any(reference_answers(lossy, i) for i in range(4))
