"""MCAP files, read back by two libraries, one of which wrote nothing of them."""

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.recording import mcap_file
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.mcap_file import write_mcap
from crazychoir_fw.recording.mcap_topics import quat_xyzw
from crazychoir_fw.simulation import DroneConfig, FlightRecorder, World

rosbags = pytest.importorskip("rosbags.highlevel")
mcap_ros2 = pytest.importorskip("mcap_ros2.reader")

MESSAGES = {
    "odom": "nav_msgs/Odometry",
    "estimate": "nav_msgs/Odometry",
    "imu": "sensor_msgs/Imu",
    "battery": "sensor_msgs/BatteryState",
    "setpoint": "geometry_msgs/PoseStamped",
    "motors": "sensor_msgs/JointState",
}


@pytest.fixture(scope="module")
def log():
    world = World([DroneConfig("cf1"), DroneConfig("left_one", (0.5, 0.0), yaw_deg=90)], seed=2)
    world.wait_until_ready()
    recorder = FlightRecorder(world)
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    recorder.run(1.0)
    world.note("fault", "cf1", motor=2, efficiency=0.5)
    world.drones[1].high_level_commander.go_to(0.7, 0.2, 0.6, 2.0, 1.0)
    recorder.run(1.5)
    world.note("done")
    return recorder.finish({"mission": 'odd "names"'})


@pytest.fixture(scope="module")
def path(log, tmp_path_factory):
    path = tmp_path_factory.mktemp("mcap") / "flight.mcap"
    write_mcap(log, path)
    return path


@pytest.fixture(scope="module")
def messages(path):
    """All messages by topic, with their times (ns), read by rosbags."""
    found = {}
    with rosbags.AnyReader([Path(path)]) as reader:
        for connection, time, raw in reader.messages():
            found.setdefault(connection.topic, []).append((time, reader.deserialize(raw, connection.msgtype)))
    return found


def xyz(vector):
    return [vector.x, vector.y, vector.z]


def test_topics_types_and_times(log, path, messages):
    with rosbags.AnyReader([Path(path)]) as reader:
        types = {connection.topic: connection.msgtype for connection in reader.connections}
    expected = {
        f"/{drone}/{name}": message.replace("/", "/msg/")
        for drone in log.drone_ids
        for name, message in MESSAGES.items()
    }
    assert types == {**expected, "/tf": "tf2_msgs/msg/TFMessage", "/events": "rcl_interfaces/msg/Log"}
    times = np.rint(log.time * 1e9).astype(int).tolist()
    for topic in expected:
        assert [time for time, _ in messages[topic]] == times
        stamps = [message.header.stamp for _, message in messages[topic]]
        assert [stamp.sec * 10**9 + stamp.nanosec for stamp in stamps] == times
    assert len(messages["/tf"]) == 2 * len(times)


def test_numbers_are_those_of_the_log(log, messages):
    def signals(column, *names):
        return np.stack([log.signals[name][:, column].astype(float) for name in names], axis=-1)

    for column, drone in enumerate(log.drone_ids):
        odom = [message for _, message in messages[f"/{drone}/odom"]]
        np.testing.assert_array_equal(
            [xyz(m.pose.pose.position) for m in odom], signals(column, "sim.x", "sim.y", "sim.z")
        )
        np.testing.assert_array_equal(
            [xyz(m.twist.twist.linear) for m in odom], signals(column, "sim.vx", "sim.vy", "sim.vz")
        )
        np.testing.assert_array_equal(
            [xyz(m.twist.twist.angular) for m in odom], signals(column, "sim.wx", "sim.wy", "sim.wz")
        )
        assert {(m.header.frame_id, m.child_frame_id) for m in odom} == {("world", drone)}

        estimate = [message for _, message in messages[f"/{drone}/estimate"]]
        names = [f"stateEstimate.{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz", "qw")]
        poses = [
            [*xyz(m.pose.pose.position), *xyz(m.pose.pose.orientation), m.pose.pose.orientation.w] for m in estimate
        ]
        np.testing.assert_array_equal(poses, signals(column, *names))
        variances = [m.pose.covariance.reshape(6, 6).diagonal()[:3] for m in estimate]
        np.testing.assert_array_equal(variances, signals(column, "kalman.varX", "kalman.varY", "kalman.varZ"))

        imu = [message for _, message in messages[f"/{drone}/imu"]]
        gyro = np.radians(signals(column, "gyro.x", "gyro.y", "gyro.z"))
        np.testing.assert_array_equal([xyz(m.angular_velocity) for m in imu], gyro)
        acc = 9.81 * signals(column, "acc.x", "acc.y", "acc.z")
        np.testing.assert_array_equal([xyz(m.linear_acceleration) for m in imu], acc)
        assert {m.orientation_covariance[0] for m in imu} == {-1.0}

        battery = [message for _, message in messages[f"/{drone}/battery"]]
        np.testing.assert_array_equal([m.voltage for m in battery], log.signals["pm.vbat"][:, column])
        np.testing.assert_array_equal([m.current for m in battery], -log.signals["sim.current"][:, column])
        np.testing.assert_array_equal([m.percentage for m in battery], log.signals["sim.charge"][:, column])
        assert all(m.present and np.isnan(m.temperature) for m in battery)

        setpoint = [message for _, message in messages[f"/{drone}/setpoint"]]
        target = signals(column, "ctrltarget.x", "ctrltarget.y", "ctrltarget.z")
        np.testing.assert_array_equal([xyz(m.pose.position) for m in setpoint], target)
        yaw = [2 * np.arctan2(m.pose.orientation.z, m.pose.orientation.w) for m in setpoint]
        np.testing.assert_allclose(yaw, np.radians(log.signals["ctrltarget.yaw"][:, column]), atol=1e-12)

        motors = [message for _, message in messages[f"/{drone}/motors"]]
        assert motors[0].name == ["m1", "m2", "m3", "m4"]
        duty = signals(column, *(f"motor.m{k}" for k in range(1, 5))) / 65535
        np.testing.assert_array_equal([m.effort for m in motors], duty)
        rpm = signals(column, *(f"sim.rpm{k}" for k in range(1, 5)))
        np.testing.assert_allclose([m.velocity for m in motors], rpm * np.pi / 30, rtol=1e-15)


def test_transforms_follow_the_drones(log, messages):
    transforms = [message.transforms[0] for _, message in messages["/tf"]]
    assert [t.child_frame_id for t in transforms] == log.drone_ids * len(log.time)
    last = transforms[-1].transform
    assert last.translation.x == log.signals["sim.x"][-1, 1]
    yaw = 2 * np.degrees(np.arctan2(last.rotation.z, last.rotation.w))
    assert yaw == pytest.approx(log.signals["sim.yaw"][-1, 1], abs=2.0)
    assert yaw > 90


def test_events_are_log_messages(messages):
    (first_time, first), (_, last) = messages["/events"]
    assert (first.name, first.msg, first.level) == ("cf1", "fault motor=2 efficiency=0.5", 30)
    assert first.stamp.sec * 10**9 + first.stamp.nanosec == first_time
    assert (last.name, last.msg) == ("world", "done")


def test_the_other_library_reads_the_same(path, messages):
    count = Counter()
    for found in mcap_ros2.read_ros2_messages(str(path)):
        topic = found.channel.topic
        if topic == "/left_one/odom":
            time, message = messages[topic][count[topic]]
            assert found.log_time_ns == time
            assert xyz(found.ros_msg.pose.pose.position) == xyz(message.pose.pose.position)
            assert found.ros_msg.twist.twist.angular.z == message.twist.twist.angular.z
        if topic == "/cf1/motors":
            assert list(found.ros_msg.effort) == messages[topic][count[topic]][1].effort.tolist()
        count[topic] += 1
    assert count == {topic: len(found) for topic, found in messages.items()}


@pytest.mark.parametrize(
    ("angles", "expected"),
    [
        ((0, 0, 0), (0, 0, 0, 1)),
        ((90, 0, 0), (0.5**0.5, 0, 0, 0.5**0.5)),
        ((0, 90, 0), (0, -(0.5**0.5), 0, 0.5**0.5)),  # the firmware's pitch lifts the nose
        ((0, 0, 90), (0, 0, 0.5**0.5, 0.5**0.5)),
    ],
)
def test_quaternions_of_angles(angles, expected):
    arrays = [np.array([float(angle)]) for angle in angles]
    np.testing.assert_allclose(quat_xyzw(*arrays)[0], expected, atol=1e-15)


def test_topics_without_signals_are_left_out(log, tmp_path):
    names = ("sim.x", "sim.y", "sim.z", "sim.roll", "sim.pitch", "sim.yaw", "pm.vbat")
    signals = {name: log.signals[name].copy() for name in names}
    signals["pm.vbat"][:, 0] = np.nan  # another provider, which has no such variable
    write_mcap(FlightLog(log.time, log.drone_ids, signals), tmp_path / "few.mcap")
    with rosbags.AnyReader([tmp_path / "few.mcap"]) as reader:
        topics = {connection.topic for connection in reader.connections}
        battery = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages() if "battery" in c.topic]
    assert topics == {"/cf1/odom", "/left_one/odom", "/left_one/battery", "/tf"}
    assert np.isnan(battery[0].current)


def test_an_empty_log_is_an_empty_file(tmp_path):
    write_mcap(FlightLog(np.empty(0), ["cf1"], {}), tmp_path / "empty.mcap")
    assert list(mcap_ros2.read_ros2_messages(str(tmp_path / "empty.mcap"))) == []


@pytest.mark.parametrize("library", ["mcap.writer", "rosbags.typesys"])
def test_a_missing_library_is_one_sentence(library, log, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(CrazychoirError, match=r"pip install 'crazychoir-fw\[mcap\]'"):
        write_mcap(log, tmp_path / "flight.mcap")
    with pytest.raises(CrazychoirError, match="mcap"):
        mcap_file.require_mcap()
    assert list(tmp_path.iterdir()) == []


def test_files_are_the_same_every_time(log, path, tmp_path):
    write_mcap(log, tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == path.read_bytes()
