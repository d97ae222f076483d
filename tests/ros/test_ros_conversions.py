"""Plain data to messages and back, and what is refused."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, Transform, Vector3
from geometry_msgs.msg import Twist as TwistMessage
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectoryPoint

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint, Twist
from crazychoir_fw.ros import conversions as to
from crazychoir_fw.ros.odometry import OdometryTopics, bytes_to_pose

numbers = st.floats(-1e6, 1e6)
threes = st.lists(numbers, min_size=3, max_size=3).map(np.array)
times = st.floats(0.0, 1e6)
angles = st.floats(-3.1, 3.1)
quaternions = st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1)
attitudes = quaternions.map(lambda q: np.array(q) / np.linalg.norm(q))
few = settings(max_examples=30)


def over_the_wire(message):
    return deserialize_message(serialize_message(message), type(message))


@few
@given(threes, attitudes, threes, threes, times)
def test_a_pose_survives_odometry(position, attitude, velocity, angular, time):
    pose = to.odometry_to_pose(over_the_wire(to.pose_to_odometry(Pose(position, attitude, velocity, angular, time))))
    np.testing.assert_array_equal(pose.position, position)
    np.testing.assert_allclose(pose.orientation, attitude, atol=1e-12)
    np.testing.assert_array_equal(pose.velocity, velocity)
    np.testing.assert_array_equal(pose.angular, angular)
    assert pose.time == pytest.approx(time, abs=1e-9) or (pose.time is None and time < 1e-9)


@few
@given(threes, attitudes)
def test_a_pose_survives_motion_capture(position, attitude):
    pose = to.pose_stamped_to_pose(over_the_wire(to.pose_to_pose_stamped(Pose(position, attitude))))
    np.testing.assert_array_equal(pose.position, position)
    np.testing.assert_allclose(pose.orientation, attitude, atol=1e-12)
    assert pose.velocity is None and pose.time is None


@few
@given(threes, threes)
def test_a_command_survives(linear, angular):
    twist = to.message_to_twist(to.from_bytes(to.twist_to_bytes(Twist(linear, angular)), TwistMessage))
    np.testing.assert_array_equal(twist.linear, linear)
    np.testing.assert_array_equal(twist.angular, angular)


@few
@given(threes, st.none() | threes, st.none() | threes, angles, st.none() | numbers)
def test_a_full_state_survives(position, velocity, acceleration, yaw, yaw_rate):
    reference = Reference(position, velocity, acceleration, None, yaw, yaw_rate)
    back = to.message_to_reference(over_the_wire(to.reference_to_message(reference, "fullstate")), "fullstate")
    np.testing.assert_array_equal(back.position, position)
    # one message holds both: where one is known the other is zero
    if velocity is None and yaw_rate is None:
        assert back.velocity is None and back.yaw_rate is None
    else:
        np.testing.assert_array_equal(back.velocity, np.zeros(3) if velocity is None else velocity)
        assert back.yaw_rate == (0.0 if yaw_rate is None else yaw_rate)
    if acceleration is None:
        assert back.acceleration is None
    else:
        np.testing.assert_array_equal(back.acceleration, acceleration)
    assert back.yaw == pytest.approx(yaw, abs=1e-9)


@few
@given(threes)
def test_vectors_survive_as_what_they_are(vector):
    position = to.message_to_reference(to.reference_to_message(Reference(position=vector), "position"), "position")
    np.testing.assert_array_equal(position.position, vector)
    assert position.acceleration is None
    message = to.reference_to_message(Reference(acceleration=vector), "acceleration")
    np.testing.assert_array_equal(to.message_to_reference(message, "acceleration").acceleration, vector)


@few
@given(st.lists(st.tuples(st.floats(0.0, 1000.0), threes, threes, threes, threes), min_size=1, max_size=5))
def test_a_trajectory_survives(rows):
    points = [TrajectoryPoint(*row) for row in rows]
    message = over_the_wire(to.points_to_joint_trajectory(points, 7))
    assert message.joint_names == ["Agent_7"]
    for point, back in zip(points, to.joint_trajectory_to_points(message), strict=True):
        assert back.time_s == pytest.approx(point.time_s, abs=1e-9)
        for name in ("position", "velocity", "acceleration", "jerk"):
            np.testing.assert_array_equal(getattr(back, name), getattr(point, name))


def test_the_jerk_travels_as_effort_and_zeros_may_be_left_out():
    message = to.points_to_joint_trajectory([TrajectoryPoint(1.5, np.ones(3), jerk=np.array([1.0, 2.0, 3.0]))], 0)
    assert list(message.points[0].effort) == [1.0, 2.0, 3.0]
    assert (message.points[0].time_from_start.sec, message.points[0].time_from_start.nanosec) == (1, 500_000_000)
    bare = JointTrajectory(points=[JointTrajectoryPoint(positions=[1.0, 2.0, 3.0])])
    np.testing.assert_array_equal(to.joint_trajectory_to_points(bare)[0].velocity, 0.0)


@few
@given(times)
def test_times_are_kept_to_the_nanosecond(time):
    assert to.seconds(to.to_stamp(time)) == pytest.approx(time, abs=1e-9)
    assert to.to_stamp(time).nanosec < 1_000_000_000


def bad_odometry(**changes):
    message = to.pose_to_odometry(Pose(np.ones(3), np.array([0.0, 0.0, 0.0, 1.0])))
    message.pose.pose.position.x = changes.get("x", 1.0)
    message.pose.pose.orientation.w = changes.get("w", 1.0)
    message.twist.twist.linear.z = changes.get("vz", 0.0)
    message.twist.twist.angular.y = changes.get("q", 0.0)
    return message


def trajectory(**point):
    return JointTrajectory(points=[JointTrajectoryPoint(**{"positions": [0.0, 0.0, 1.0], **point})])


@pytest.mark.parametrize(
    ("work", "words"),
    [
        (lambda: to.odometry_to_pose(bad_odometry(x=math.nan)), "odometry: position is .nan"),
        (lambda: to.odometry_to_pose(bad_odometry(w=0.5)), "odometry: orientation .* length 1"),
        (lambda: to.odometry_to_pose(bad_odometry(w=math.nan)), "odometry: orientation"),
        (lambda: to.odometry_to_pose(bad_odometry(vz=math.inf)), "odometry: velocity"),
        (lambda: to.odometry_to_pose(bad_odometry(q=math.nan)), "odometry: angular"),
        (lambda: to.pose_stamped_to_pose(PoseStamped()), None),
        (lambda: to.pose_to_odometry(Pose()), "position is not given"),
        (lambda: to.pose_to_odometry(Pose(np.zeros(2))), r"position has shape \(2,\), allowed: \(3,\)"),
        (lambda: to.pose_to_odometry(Pose(np.zeros(3), np.zeros(3))), r"orientation has shape \(3,\)"),
        (lambda: to.pose_to_odometry(Pose(np.zeros(3), time=-1.0)), "time is -1.0"),
        (lambda: to.to_duration(math.nan), "duration is nan"),
        (lambda: to.message_to_twist(TwistMessage(angular=Vector3(y=math.nan))), "cmd_vel: angular"),
        (lambda: to.twist_to_bytes(Twist(np.full(3, np.inf), np.zeros(3))), "linear is"),
        (lambda: to.twist_to_bytes(Twist(np.zeros((2, 3)), np.zeros((2, 3)))), r"linear has shape \(2, 3\)"),
        (lambda: to.reference_to_message(Reference(), "acceleration"), "acceleration is not given"),
        (lambda: to.reference_to_message(Reference(np.zeros(3), yaw=math.nan), "fullstate"), "yaw is nan"),
        (lambda: to.message_to_reference(Vector3(x=math.nan), "position"), "reference: position"),
        (lambda: to.message_to_reference(MultiDOFJointTrajectoryPoint(), "fullstate"), "0 transforms, allowed: one"),
        (
            lambda: to.message_to_reference(MultiDOFJointTrajectoryPoint(transforms=[Transform()] * 2), "fullstate"),
            "2 transforms",
        ),
        (lambda: to.joint_trajectory_to_points(JointTrajectory()), "no point"),
        (lambda: to.joint_trajectory_to_points(trajectory(positions=[1.0])), "point 0: position has shape"),
        (lambda: to.joint_trajectory_to_points(trajectory(velocities=[1.0] * 4)), "point 0: velocity has shape"),
        (lambda: to.joint_trajectory_to_points(trajectory(effort=[math.nan] * 3)), "point 0: jerk is"),
        (lambda: to.points_to_joint_trajectory([TrajectoryPoint(-1.0, np.zeros(3))], 0), "duration is -1.0"),
    ],
)
def test_what_is_no_number_or_of_the_wrong_size_is_refused_by_name(work, words):
    if words is None:  # an identity attitude is what messages begin with
        work()
        return
    with pytest.raises(RangeError, match=words):
        work()


def test_unknown_kinds_are_refused():
    with pytest.raises(UnknownNameError, match="position, acceleration, fullstate"):
        to.reference_to_message(Reference(np.zeros(3)), "velocity")
    with pytest.raises(UnknownNameError, match="'jerk'"):
        to.message_to_reference(Vector3(), "jerk")


def test_frames_are_those_of_the_table():
    message = to.pose_to_odometry(Pose(np.zeros(3)))
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
    assert isinstance(message, Odometry) and message.pose.pose.orientation.w == 1.0
    assert to.pose_to_pose_stamped(Pose(np.zeros(3))).header.frame_id == "world"


@given(st.integers(0, 10**18 - 1), st.binary(max_size=50))
def test_labeled_bytes_survive(label, data):
    message = deserialize_message(to.labeled_bytes(label, data), UInt8MultiArray)
    assert to.message_to_bytes(message) == (label, data)
    message.layout.dim[0].label = "-1"
    with pytest.raises(RangeError, match="without label"):
        to.message_to_bytes(message)


@pytest.mark.parametrize("kind", ["position", "acceleration", "fullstate"])
def test_bytes_are_those_of_messages(kind):
    vectors = np.arange(9.0).reshape(3, 3)
    reference = Reference(*vectors, yaw=0.3, yaw_rate=0.4)
    message = to.reference_to_message(reference, kind)
    assert deserialize_message(to.reference_to_bytes(reference, kind), type(message)) == message


def test_odometry_is_published_as_rclpy_reads_it():
    turn = np.array([0.0, 0.6, 0.0, 0.8])
    pose, heard = Pose(np.arange(3.0), turn, np.ones(3), np.full(3, 2.0), 1.5), []
    publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=heard.append)
    topics = OdometryTopics(SimpleNamespace(announce=lambda *_: publisher), ["odom"])
    rows = (pose.position, pose.orientation, pose.velocity, pose.angular)
    topics.publish(1.5, Pose(*(row[np.newaxis] for row in rows)))
    # bytes that align numbers may be anything
    assert deserialize_message(heard[0], Odometry) == over_the_wire(to.pose_to_odometry(pose))


def published(pose, time):
    """Return the bytes that the odometry of one drone consists of."""
    heard = []
    publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=heard.append)
    topics = OdometryTopics(SimpleNamespace(announce=lambda *_: publisher), ["odom"])
    parts = (pose.position, pose.orientation, pose.velocity, pose.angular)
    topics.publish(time, Pose(*(part[np.newaxis] for part in parts)))
    return heard[0]


@few
@given(threes, attitudes, threes, threes, times)
def test_odometry_of_ours_and_of_others_is_read_alike(position, attitude, velocity, angular, time):
    ours = published(Pose(position, attitude, velocity, angular), time)
    message = deserialize_message(ours, Odometry)
    expected = to.odometry_to_pose(message)
    message.header.frame_id = "somewhere"  # not written by us
    for data in (ours, serialize_message(message)):
        pose = bytes_to_pose(data)
        for name in ("position", "orientation", "velocity", "angular"):
            np.testing.assert_array_equal(getattr(pose, name), getattr(expected, name))
        assert pose.time == expected.time


@pytest.mark.parametrize("bad", [{"position": [0.0, math.nan, 0.0]}, {"orientation": [0.0, 0.0, 0.0, 0.5]}])
def test_bad_odometry_of_ours_is_refused(bad):
    good = {"position": np.zeros(3), "orientation": np.array([0.0, 0.0, 0.0, 1.0])}
    data = published(
        Pose(**{**good, **{k: np.array(v) for k, v in bad.items()}}, velocity=np.zeros(3), angular=np.zeros(3)), 1.0
    )
    with pytest.raises(RangeError, match=next(iter(bad))):
        bytes_to_pose(data)


@few
@given(threes, threes)
def test_a_command_is_read_from_its_bytes(linear, angular):
    sent = to.twist_to_bytes(Twist(linear, angular))
    for data in (sent, b"\x00\x01\x00\x00" + sent[4:] + b"\x00"):  # the second is of an odd length
        twist = to.bytes_to_twist(data)
        np.testing.assert_array_equal(twist.linear, linear)
        np.testing.assert_array_equal(twist.angular, angular)


def test_a_command_that_is_no_number_is_refused():
    with pytest.raises(RangeError, match="cmd_vel: angular"):
        to.bytes_to_twist(b"\x00\x01\x00\x00" + np.array([0, 0, 1, 0, math.inf, 0], "<f8").tobytes())
