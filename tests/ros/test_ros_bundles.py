"""What nodes of one process share: clock, short cuts, bundles; and that whoever is outside notices nothing of it."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Twist as TwistMessage
from geometry_msgs.msg import Vector3
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import (
    FlatnessAccelerationCtrl,
    FPQRSender,
    GeometryAttitudeCtrl,
)
from crazychoir_fw.control import HierarchicalController as PlainController
from crazychoir_fw.planning import AccelerationTraj
from crazychoir_fw.ros import bundles
from crazychoir_fw.ros.controller import CrazyflieController
from crazychoir_fw.ros.conversions import message_to_reference, reference_to_message, to_stamp
from crazychoir_fw.ros.hub import Hub
from crazychoir_fw.ros.names import ACCELERATION
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.simulation import PaceSettings, SimulationNode
from crazychoir_fw.ros.teams import ControlTeam, has_no_memory
from crazychoir_fw.ros.wire import bytes_to_reference, labeled_bytes, reference_bytes, vector3_bytes

NUMBER = st.floats(-1e6, 1e6)
VECTOR = st.lists(NUMBER, min_size=3, max_size=3).map(np.array)


# ---------------------------------------------------------------- bytes


@given(VECTOR, VECTOR, VECTOR, st.floats(-math.pi, math.pi), NUMBER)
def test_full_states_are_what_rclpy_encodes(position, velocity, acceleration, yaw, turn):
    reference = Reference(position, velocity, acceleration, yaw=yaw, yaw_rate=turn)
    ours = deserialize_message(reference_bytes(reference, "fullstate"), MultiDOFJointTrajectoryPoint)
    assert ours == reference_to_message(reference, "fullstate")
    read = bytes_to_reference(bytes(serialize_message(ours)), "fullstate")
    decoded = message_to_reference(ours, "fullstate")
    for name in ("position", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(read, name), getattr(decoded, name))
    assert read.yaw == pytest.approx(decoded.yaw, abs=1e-9)
    assert read.yaw_rate == decoded.yaw_rate


def test_full_states_of_another_form_are_decoded_too():
    reference = Reference(np.array([1.0, 2.0, 3.0]))
    read = bytes_to_reference(reference_bytes(reference, "fullstate"), "fullstate")
    np.testing.assert_array_equal(read.position, reference.position)
    assert read.velocity is None and read.acceleration is None


@pytest.mark.parametrize("kind", ["acceleration", "position", "fullstate"])
def test_references_that_are_not_finite_are_refused_both_ways(kind):
    bad = np.array([0.0, math.nan, 0.0])
    with pytest.raises(RangeError, match="finite"):
        reference_bytes(Reference(bad, bad, bad), kind)
    if kind != "fullstate":
        with pytest.raises(RangeError, match=f"{kind}.*finite"):
            bytes_to_reference(vector3_bytes(*bad), kind)


def test_bundles_and_cards_come_back():
    rows = np.arange(26.0).reshape(2, 13)
    time, read = bundles.unpack_odometry(bundles.pack_odometry(7, rows))
    assert time == 7
    np.testing.assert_array_equal(read, rows)
    said = [("/agent_0/cmd_vel", b"abc"), ("/agent_1/answered", b"")]
    time, member, heard = bundles.unpack_answers(bundles.pack_answers(8, "layers#1", said))
    assert (time, member, [tuple(one) for one in heard]) == (8, "layers#1", said)
    host = bundles.HostCard(["/agent_0/odom"], {"/agent_0/cmd_vel": 1})
    assert bundles.HostCard.read(host.text()) == host
    card = bundles.MemberCard("layers#1", {"/agent_0/odom": 2})
    assert bundles.MemberCard.read(card.text()) == card


@given(st.binary(max_size=60))
def test_what_is_no_bundle_is_refused(data):
    # 0xc1 is nothing in msgpack, and no number of drones has so few bytes
    message = labeled_bytes(1, b"\xc1" + data)
    for unpack in (bundles.unpack_odometry, bundles.unpack_answers):
        with pytest.raises(RangeError):
            unpack(message)


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", '{"odometry": 3, "hears": []}', '{"member": "a", "served": {"b": "c"}}']
)
def test_what_is_no_card_is_refused(text):
    for card in (bundles.HostCard, bundles.MemberCard):
        with pytest.raises(RangeError):
            card.read(text)


# ---------------------------------------------------------------- nodes of one process


def controller_of(bench, hub, i):
    plain = PlainController(
        FlatnessAccelerationCtrl(), GeometryAttitudeCtrl(), command_sender=FPQRSender(), traj_handler=AccelerationTraj()
    )
    return bench.add(CrazyflieController(controller=plain, agent_id=i, hub=hub, context=bench.context))


class Drones:
    """Two drones that stand where they are told."""

    names = ("agent_0", "agent_1")

    def __init__(self):
        self.time = 0.0
        self.sent = []
        self.attitudes = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))

    def poses(self):
        flat = np.zeros((2, 3))
        return Pose(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]), self.attitudes, flat, flat)

    def send(self, indices, twist, kind):
        self.sent.append((list(indices), twist.linear[:, 2].copy()))

    def advance(self, seconds):
        self.time += seconds

    def stop(self, indices):
        pass


@pytest.fixture
def swarm(bench):
    """A host, and two controllers of one hub that know it."""
    hub = Hub("layers", lockstep=True)
    controllers = [controller_of(bench, hub, i) for i in range(2)]
    node = bench.add(SimulationNode(Drones(), pace=PaceSettings(None, True, unattended=True), context=bench.context))
    node.members.invite()
    bench.until(lambda: node.members._served)
    return hub, controllers, node


def rounds(bench, node, count):
    for _ in range(count):
        before = node.answers.heard.copy()
        node.answers.heard.clear()
        node.step()
        bench.until(lambda: len(node.answers.heard) == 2)
        node.answers.heard |= before


def test_a_process_answers_with_one_message_and_nothing_goes_one_by_one(bench, swarm):
    _, controllers, node = swarm
    published = []
    for publisher in node._odom:
        publisher.publish = published.append
    rounds(bench, node, 4)
    assert not published
    # no references: each controller holds its drone where it is
    assert node.host.sent[-1][0] == [0, 1]
    np.testing.assert_allclose(node.host.sent[-1][1], 0.038 * 9.80665, rtol=1e-6)
    assert all(one.now() == pytest.approx(node.host.time) for one in controllers)
    assert controllers[0].get_clock() is controllers[1].get_clock()
    assert controllers[1].get_clock().now().nanoseconds == round(node.host.time * 1e9)


def test_who_is_outside_hears_all_there_is_and_nobody_hears_it_twice(bench, swarm):
    _, controllers, node = swarm
    rounds(bench, node, 2)
    heard = {
        "odom": bench.hear(Odometry, "/agent_1/odom"),
        "cmd_vel": bench.hear(TwistMessage, "/agent_1/cmd_vel"),
        "clock": bench.hear(Clock, "/clock"),
    }
    taken = []
    take = controllers[1].controller.set_pose
    controllers[1].controller.set_pose = lambda pose: (taken.append(pose.time), take(pose))
    bench.until(lambda: node._odom[1].get_subscription_count() == 2)
    # whether somebody listens is looked at now and then
    while not all(heard.values()):
        rounds(bench, node, 1)
        bench.drain()
    for messages in heard.values():
        messages.clear()
    rounds(bench, node, 5)
    bench.until(lambda: all(len(messages) >= 5 for messages in heard.values()))
    bench.drain()
    assert [len(messages) for messages in heard.values()] == [5, 5, 5]
    assert taken == sorted(set(taken))


def test_a_reference_from_outside_reaches_a_controller_of_a_hub(bench, swarm):
    _, controllers, node = swarm
    bench.speaker(Vector3, "/agent_0/acceleration").publish(Vector3(x=0.0, y=0.0, z=1.0))
    bench.until(lambda: controllers[0].controller.desired_reference is not None)
    rounds(bench, node, 3)
    thrust = node.host.sent[-1][1]
    assert thrust[0] == pytest.approx(0.038 * 10.80665, rel=1e-6)
    assert thrust[1] == pytest.approx(0.038 * 9.80665, rel=1e-6)


def test_a_member_that_is_silent_is_served_one_by_one(bench, swarm, monkeypatch):
    _, _, node = swarm
    monkeypatch.setattr("crazychoir_fw.ros.peer_registry.FRESH_S", 0.0)
    published = []
    for publisher in node._odom:
        publisher.publish = published.append
    node.step()
    assert not published
    node.step()  # the first one has not been answered: nobody worked in between
    assert len(published) == 2


def test_what_is_said_inside_is_heard_at_once_and_only_once(bench):
    hub = Hub("two")
    speaker = bench.add(LayerNode("speaker", agent_id=0, hub=hub, context=bench.context))
    listener = bench.add(LayerNode("listener", agent_id=0, hub=hub, context=bench.context))
    inside, copies = [], []
    listener.listen(ACCELERATION, copies.append, raw=True, direct=inside.append)
    outlet = speaker.outlet(ACCELERATION)
    bench.until(lambda: outlet.listeners == 1)
    outlet.say((1.0, 2.0, 3.0), lambda numbers: vector3_bytes(*numbers))
    assert inside == [(1.0, 2.0, 3.0)]
    heard = bench.hear(Vector3, "/agent_0/acceleration")
    bench.until(lambda: outlet.is_heard_outside)
    outlet.say((4.0, 5.0, 6.0), lambda numbers: vector3_bytes(*numbers))
    bench.until(lambda: heard)
    bench.drain()
    assert len(inside) == 2 and not copies
    assert (heard[0].x, heard[0].z) == (4.0, 6.0)


def test_without_bundles_the_clock_of_ros_drives_a_hub(bench):
    hub, times = Hub("clock"), []
    node = bench.add(LayerNode("node", agent_id=0, hub=hub, context=bench.context))
    node.every(10.0, times.append)
    assert node.is_simulated_time and node.get_parameter("use_sim_time").value
    bench.until(bench.clock.get_subscription_count)
    for now in (1.0, 1.05, 1.1, 1.5, 1.6):
        bench.clock.publish(Clock(clock=to_stamp(now)))
        bench.until(lambda now=now: hub.now == now)
    assert times == [1.0, 1.1, 1.5, 1.6]


def test_a_team_of_controllers_says_what_each_would_say(bench, swarm):
    _, controllers, node = swarm
    assert all(has_no_memory(one.controller) for one in controllers)
    together = PlainController(
        FlatnessAccelerationCtrl(mass=np.full(2, 0.038)),
        GeometryAttitudeCtrl(),
        command_sender=FPQRSender(),
        traj_handler=AccelerationTraj(),
    )
    wanted = np.array([[0.3, 0.1, 1.0], [0.0, -0.2, -1.0]])
    sent = []
    for team in (False, True):
        if team:
            ControlTeam(controllers, together)
        thrusts = []
        for roll in (0.0, 0.3):
            node.host.attitudes = np.array([[math.sin(roll), 0.0, 0.0, math.cos(roll)], [0.0, 0.0, 0.0, 1.0]])
            for one, acceleration in zip(controllers, wanted, strict=True):
                one._follow(Reference(acceleration=acceleration))
            rounds(bench, node, 3)
            thrusts.append(node.host.sent[-1][1])
        sent.append(thrusts)
    np.testing.assert_allclose(sent[1], sent[0], rtol=1e-12)
    assert sent[0][0][0] > 1.1 * sent[0][1][0], "less of the thrust is along the body of a drone that leans"
