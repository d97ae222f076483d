"""Plain data to ROS messages and back. Values that are not finite or of the wrong size raise an error with their name.

One drone at a time: arrays of shape (3,). Times are seconds of the node's clock.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Transform, Vector3
from geometry_msgs.msg import Twist as TwistMessage
from nav_msgs.msg import Odometry
from numpy.typing import ArrayLike, NDArray
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectoryPoint

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint, Twist
from crazychoir_fw.mocap import decode_odometry, decode_pose_stamped
from crazychoir_fw.ros.names import BODY_FRAME, ODOM_FRAME, REFERENCES, WORLD_FRAME

Array = NDArray[np.float64]

_TYPES = get_typestore(Stores.ROS2_JAZZY)
_LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # CDR: first bytes of a message
_TWIST_BYTES = len(_LITTLE_ENDIAN) + 6 * 8
_UInt8MultiArray, _MultiArrayLayout, _MultiArrayDimension = (
    _TYPES.types[f"std_msgs/msg/{name}"] for name in ("UInt8MultiArray", "MultiArrayLayout", "MultiArrayDimension")
)
_MIN_NORM = 0.8  # of a quaternion: less is a lost sample (docs/reference/crazychoir.md#10)
_LARGEST_TIME = 2**31  # [s], of the 32 bits that messages have
_MAX_DIGITS = 18  # of a label


# ---------------------------------------------------------------- bytes, which publishers and raw subscriptions take


@cache
def _name_of(kind: type) -> str:
    return f"{kind.__module__.partition('.')[0]}/msg/{kind.__name__}"


def from_bytes(data: bytes, kind: type) -> Any:
    """Decode a message of a type, with lists of numbers as arrays; rclpy takes 3 times as long."""
    return _TYPES.deserialize_cdr(data, _name_of(kind))


def to_bytes(message: Any, kind: type) -> bytes:
    """Encode an object with the fields of a message type as bytes."""
    return bytes(_TYPES.serialize_cdr(message, _name_of(kind)))


def vectors_to_bytes(**vectors: ArrayLike | None) -> bytes:
    """Return a message that consists of vectors of three numbers; rclpy takes twice as long.

    Raises:
        RangeError: If a number is not finite; the message names the vector.
    """
    return _LITTLE_ENDIAN + b"".join(_vector(*item).astype("<f8").tobytes() for item in vectors.items())


# ---------------------------------------------------------------- numbers


def _vector(name: str, values: ArrayLike | None, length: int = 3) -> Array:
    """Return finite numbers, shape (length,).

    Raises:
        RangeError: If they are none; the message names them.
    """
    if values is None:
        raise RangeError(f"{name} is not given, allowed: {length} finite numbers")
    numbers = np.asarray(values, float)
    if numbers.shape != (length,):
        raise RangeError(f"{name} has shape {numbers.shape}, allowed: ({length},)")
    if not math.isfinite(numbers.sum()) and not np.isfinite(numbers).all():
        raise RangeError(f"{name} is {numbers.tolist()}, allowed: finite numbers")
    return numbers


def _xyz(name: str, message: Any) -> Array:
    return _vector(name, (message.x, message.y, message.z))


def _unit(name: str, values: ArrayLike) -> Array:
    """Return a quaternion (xyzw) of length 1."""
    numbers = np.asarray(values, float)
    norm = math.sqrt(float(numbers @ numbers))
    if not (math.isfinite(norm) and norm >= _MIN_NORM):
        raise RangeError(f"{name} is {numbers.tolist()}, allowed: a quaternion of length 1")
    return numbers / norm


def _number(name: str, value: Any) -> float:
    number = 0.0 if value is None else float(value)
    if not math.isfinite(number):
        raise RangeError(f"{name} is {number}, allowed: a finite number")
    return number


def to_vector3(name: str, values: ArrayLike | None) -> Vector3:
    """Return three finite numbers as a message.

    Raises:
        RangeError: If they are none; the message names them.
    """
    x, y, z = _vector(name, values).tolist()
    return Vector3(x=x, y=y, z=z)


def seconds(stamp: Time | Duration) -> float:
    """Return a stamp or a duration in seconds."""
    return (stamp.sec * 1_000_000_000 + stamp.nanosec) / 1e9  # as the clock of a node is read


def to_stamp(time: float) -> Time:
    """Return a time (s) as a stamp, to the nanosecond.

    Raises:
        RangeError: If it is negative, or does not fit.
    """
    return Time(**_sec_nanosec("time", time))


def to_duration(time: float) -> Duration:
    """Return seconds as a duration; see `to_stamp`."""
    return Duration(**_sec_nanosec("duration", time))


def _sec_nanosec(name: str, time: float) -> dict[str, int]:
    if not (math.isfinite(time) and 0.0 <= time < _LARGEST_TIME - 1):
        raise RangeError(f"{name} is {time}, allowed: 0 to 2^31 s")
    sec, nanosec = divmod(round(time * 1e9), 1_000_000_000)
    return {"sec": sec, "nanosec": nanosec}


# ---------------------------------------------------------------- poses


def _fill_pose(message: Any, place: Any, pose: Pose, frame_id: str) -> None:
    """Fill the header of a message, and the position and attitude of `place`; unknown values keep their defaults."""
    message.header.frame_id = frame_id
    if pose.time is not None:
        message.header.stamp = to_stamp(pose.time)
    x, y, z = _vector("position", pose.position).tolist()
    place.position = Point(x=x, y=y, z=z)
    if pose.orientation is not None:
        x, y, z, w = _vector("orientation", pose.orientation, 4).tolist()
        place.orientation = Quaternion(x=x, y=y, z=z, w=w)


def pose_to_odometry(pose: Pose, frame_id: str = ODOM_FRAME, child_frame_id: str = BODY_FRAME) -> Odometry:
    """Return a pose as odometry; its time becomes the stamp, and unknown values stay zero (identity attitude).

    Raises:
        RangeError: If a number is not finite, or the pose has no position.
    """
    message = Odometry(child_frame_id=child_frame_id)
    _fill_pose(message, message.pose.pose, pose, frame_id)
    if pose.velocity is not None:
        message.twist.twist.linear = to_vector3("velocity", pose.velocity)
    if pose.angular is not None:
        message.twist.twist.angular = to_vector3("angular", pose.angular)
    return message


def odometry_to_pose(message: Odometry) -> Pose:
    """Return odometry as a pose; a stamp of zero is no stamp.

    Raises:
        RangeError: If a number is not finite, or the quaternion is none.
    """
    return checked_pose("odometry", decode_odometry(message))


def pose_to_pose_stamped(pose: Pose, frame_id: str = WORLD_FRAME) -> PoseStamped:
    """Return position and attitude, as motion capture publishes them; see `pose_to_odometry`."""
    message = PoseStamped()
    _fill_pose(message, message.pose, pose, frame_id)
    return message


def pose_stamped_to_pose(message: PoseStamped) -> Pose:
    """Return position and attitude, without velocities; see `odometry_to_pose`."""
    return checked_pose("pose", decode_pose_stamped(message))


def checked_pose(who: str, pose: Pose) -> Pose:
    """Return a pose of whatever source with a quaternion of length 1.

    Raises:
        RangeError: If a number is not finite, or the quaternion is none, as those of lost samples are.
    """
    for name in ("position", "velocity", "angular"):
        if getattr(pose, name) is not None:
            _vector(f"{who}: {name}", getattr(pose, name))
    pose.orientation = _unit(f"{who}: orientation", pose.orientation)
    return pose


# ---------------------------------------------------------------- commands and references


def twist_to_bytes(twist: Twist) -> bytes:
    """Return a command as the bytes of its message.

    Raises:
        RangeError: If a number is not finite.
    """
    return vectors_to_bytes(linear=twist.linear, angular=twist.angular)


def bytes_to_twist(data: bytes) -> Twist:
    """Return a command from the bytes of its message; see `twist_to_bytes`."""
    if data[: len(_LITTLE_ENDIAN)] != _LITTLE_ENDIAN or len(data) != _TWIST_BYTES:
        return message_to_twist(from_bytes(data, TwistMessage))
    numbers = np.frombuffer(data, "<f8", offset=len(_LITTLE_ENDIAN))
    return Twist(_vector("cmd_vel: linear", numbers[:3]), _vector("cmd_vel: angular", numbers[3:]))


def message_to_twist(message: TwistMessage) -> Twist:
    """Return the message of a command; see `twist_to_bytes`."""
    return Twist(_xyz("cmd_vel: linear", message.linear), _xyz("cmd_vel: angular", message.angular))


def reference_to_message(reference: Reference, kind: str) -> Vector3 | MultiDOFJointTrajectoryPoint:
    """Return a reference as the message of its kind: "position", "acceleration" or "fullstate".

    Raises:
        RangeError: If a number is not finite, or the reference lacks a value that the kind needs.
        UnknownNameError: If there is no such kind.
    """
    _check_kind(kind)
    if kind != "fullstate":
        return to_vector3(kind, getattr(reference, kind))
    yaw = _number("yaw", reference.yaw)
    rotation = Quaternion(z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))
    message = MultiDOFJointTrajectoryPoint(
        transforms=[Transform(translation=to_vector3("position", reference.position), rotation=rotation)]
    )
    if reference.velocity is not None or reference.yaw_rate is not None:
        speed = np.zeros(3) if reference.velocity is None else reference.velocity
        turn = Vector3(z=_number("yaw_rate", reference.yaw_rate))
        message.velocities = [TwistMessage(linear=to_vector3("velocity", speed), angular=turn)]
    if reference.acceleration is not None:
        message.accelerations = [TwistMessage(linear=to_vector3("acceleration", reference.acceleration))]
    return message


def reference_to_bytes(reference: Reference, kind: str) -> bytes:
    """Return a reference as the bytes of its message; see `reference_to_message`."""
    if kind in ("position", "acceleration"):
        return vectors_to_bytes(**{kind: getattr(reference, kind)})
    return to_bytes(reference_to_message(reference, kind), MultiDOFJointTrajectoryPoint)


def message_to_reference(message: Vector3 | MultiDOFJointTrajectoryPoint, kind: str) -> Reference:
    """Return the message of a reference; lists of velocities or accelerations may be empty.

    Raises:
        RangeError: If a number is not finite, or there is not just one transform.
        UnknownNameError: If there is no such kind.
    """
    _check_kind(kind)
    if kind != "fullstate":
        return Reference(**{kind: _xyz(f"reference: {kind}", message)})
    counts = {"transforms": "one", "velocities": "none or one", "accelerations": "none or one"}
    for name, allowed in counts.items():
        if len(getattr(message, name)) not in ((1,) if allowed == "one" else (0, 1)):
            raise RangeError(f"fullstate: {len(getattr(message, name))} {name}, allowed: {allowed}")
    place, turn = message.transforms[0].translation, message.transforms[0].rotation
    x, y, z, w = _unit("fullstate: orientation", (turn.x, turn.y, turn.z, turn.w))
    parts: dict[str, Any] = {"yaw": math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))}
    for twist in message.velocities:
        parts["velocity"] = _xyz("fullstate: velocity", twist.linear)
        parts["yaw_rate"] = _number("fullstate: yaw rate", twist.angular.z)
    for twist in message.accelerations:
        parts["acceleration"] = _xyz("fullstate: acceleration", twist.linear)
    return Reference(_xyz("fullstate: position", place), **parts)


def _check_kind(kind: str) -> None:
    if kind not in REFERENCES:
        raise UnknownNameError(f"kind of reference is {kind!r}, allowed: {', '.join(REFERENCES)}")


# ---------------------------------------------------------------- trajectories

_FIELDS = {"positions": "position", "velocities": "velocity", "accelerations": "acceleration", "effort": "jerk"}
"""Of a `JointTrajectoryPoint`, by what is in them: the jerk travels in the field effort."""


def points_to_joint_trajectory(points: list[TrajectoryPoint], agent_id: int) -> JointTrajectory:
    """Return points for the topic ``traj_params``.

    Raises:
        RangeError: If a number is not finite, or a time is negative.
    """
    message = JointTrajectory(joint_names=[f"Agent_{agent_id}"])
    for point in points:
        fields = {field: _vector(name, getattr(point, name)).tolist() for field, name in _FIELDS.items()}
        message.points.append(JointTrajectoryPoint(time_from_start=to_duration(point.time_s), **fields))
    return message


def joint_trajectory_to_points(message: JointTrajectory) -> list[TrajectoryPoint]:
    """Return the points of a trajectory; velocity, acceleration and jerk may be left out.

    Raises:
        RangeError: If there is no point, a number is not finite, or a vector is not of three.
    """
    if not message.points:
        raise RangeError("traj_params has no point, allowed: one or more")
    points = []
    for index, point in enumerate(message.points):
        who, time = f"traj_params: point {index}", seconds(point.time_from_start)
        if time < 0.0:
            raise RangeError(f"{who}: time is {time} s, allowed: 0 s or more")
        vectors = {}
        for field, name in _FIELDS.items():
            values = getattr(point, field)
            is_left_out = name != "position" and not len(values)
            vectors[name] = np.zeros(3) if is_left_out else _vector(f"{who}: {name}", values)
        points.append(TrajectoryPoint(time_s=time, **vectors))
    return points


# ---------------------------------------------------------------- labeled bytes


def labeled_bytes(label: int, data: bytes) -> bytes:
    """Wrap bytes in an encoded `UInt8MultiArray` of one dimension, with a decimal number as label."""
    layout = _MultiArrayLayout([_MultiArrayDimension(str(label), len(data), len(data))], 0)
    return to_bytes(_UInt8MultiArray(layout, np.frombuffer(data, np.uint8)), UInt8MultiArray)


def message_to_bytes(message: UInt8MultiArray) -> tuple[int, bytes]:
    """Return label and bytes of an array.

    Raises:
        RangeError: If it has not just one dimension, or its label is no number.
    """
    dimensions = message.layout.dim
    if len(dimensions) != 1 or not (dimensions[0].label.isdecimal() and len(dimensions[0].label) <= _MAX_DIGITS):
        raise RangeError(f"{len(message.data)} bytes without label, allowed: one labeled dimension")
    return int(dimensions[0].label), bytes(message.data)
