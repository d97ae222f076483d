"""Plain data to ROS messages and back. What is no finite number or of the wrong size is refused by name.

One drone at a time: arrays of shape (3,). Times are seconds of the node's clock.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Transform, Vector3
from geometry_msgs.msg import Twist as TwistMessage
from nav_msgs.msg import Odometry
from numpy.typing import ArrayLike, NDArray
from std_msgs.msg import MultiArrayDimension, MultiArrayLayout, UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint, MultiDOFJointTrajectoryPoint

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint, Twist
from crazychoir_fw.mocap import decode_odometry, decode_pose_stamped
from crazychoir_fw.ros.names import BODY_FRAME, ODOM_FRAME, REFERENCES, WORLD_FRAME

Array = NDArray[np.float64]

_MIN_NORM = 0.8  # of a quaternion: less is a lost sample (docs/reference/crazychoir.md#10)
_LARGEST_TIME = 2**31  # [s], of the 32 bits that messages have
_MAX_DIGITS = 18  # of a label


# ---------------------------------------------------------------- times


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
    """Return seconds as a duration, to the nanosecond.

    Raises:
        RangeError: If they are negative, or do not fit.
    """
    return Duration(**_sec_nanosec("duration", time))


def _sec_nanosec(name: str, time: float) -> dict[str, int]:
    if not (math.isfinite(time) and 0.0 <= time < _LARGEST_TIME - 1):
        raise RangeError(f"{name} is {time}, allowed: 0 to 2^31 s")
    sec, nanosec = divmod(round(time * 1e9), 1_000_000_000)
    return {"sec": sec, "nanosec": nanosec}


# ---------------------------------------------------------------- poses


def pose_to_odometry(pose: Pose, frame_id: str = ODOM_FRAME, child_frame_id: str = BODY_FRAME) -> Odometry:
    """Return a pose as odometry; its time becomes the stamp, and what is not known stays zero (identity attitude).

    Raises:
        RangeError: If a number is not finite, or the pose has no position.
    """
    message = Odometry(child_frame_id=child_frame_id)
    message.header.frame_id = frame_id
    if pose.time is not None:
        message.header.stamp = to_stamp(pose.time)
    message.pose.pose.position = _point("position", pose.position)
    message.pose.pose.orientation = _quaternion("orientation", pose.orientation)
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
    """Return position and attitude, as motion capture publishes them.

    Raises:
        RangeError: If a number is not finite, or the pose has no position.
    """
    message = PoseStamped()
    message.header.frame_id = frame_id
    if pose.time is not None:
        message.header.stamp = to_stamp(pose.time)
    message.pose.position = _point("position", pose.position)
    message.pose.orientation = _quaternion("orientation", pose.orientation)
    return message


def pose_stamped_to_pose(message: PoseStamped) -> Pose:
    """Return position and attitude, without velocities.

    Raises:
        RangeError: If a number is not finite, or the quaternion is none.
    """
    return checked_pose("pose", decode_pose_stamped(message))


def checked_pose(who: str, pose: Pose) -> Pose:
    """Return a pose of whatever source with a quaternion of length 1.

    Raises:
        RangeError: If a number is not finite, or the quaternion is none, as those of lost samples are.
    """
    for name in ("position", "velocity", "angular"):
        values = getattr(pose, name)
        if values is not None and not math.isfinite(values.sum()):
            _finite(who, name, values)
    pose.orientation = _unit(who, pose.orientation)
    return pose


# ---------------------------------------------------------------- commands


def twist_to_message(twist: Twist) -> TwistMessage:
    """Return a command as a message.

    Raises:
        RangeError: If a number is not finite.
    """
    return TwistMessage(linear=to_vector3("linear", twist.linear), angular=to_vector3("angular", twist.angular))


def message_to_twist(message: TwistMessage) -> Twist:
    """Return the message of a command.

    Raises:
        RangeError: If a number is not finite.
    """
    return Twist(
        linear=_finite("cmd_vel", "linear", _xyz(message.linear)),
        angular=_finite("cmd_vel", "angular", _xyz(message.angular)),
    )


# ---------------------------------------------------------------- references


def reference_to_message(reference: Reference, kind: str) -> Vector3 | MultiDOFJointTrajectoryPoint:
    """Return a reference as the message of its kind: "position", "acceleration" or "fullstate".

    Raises:
        RangeError: If a number is not finite, or the reference lacks what the kind needs.
        UnknownNameError: If there is no such kind.
    """
    _check_kind(kind)
    if kind == "position":
        return to_vector3("position", reference.position)
    if kind == "acceleration":
        return to_vector3("acceleration", reference.acceleration)
    yaw = 0.0 if reference.yaw is None else _number("yaw", reference.yaw)
    rotation = Quaternion(z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))
    message = MultiDOFJointTrajectoryPoint(
        transforms=[Transform(translation=to_vector3("position", reference.position), rotation=rotation)]
    )
    if reference.velocity is not None or reference.yaw_rate is not None:
        twist = TwistMessage()
        if reference.velocity is not None:
            twist.linear = to_vector3("velocity", reference.velocity)
        if reference.yaw_rate is not None:
            twist.angular.z = _number("yaw_rate", reference.yaw_rate)
        message.velocities = [twist]
    if reference.acceleration is not None:
        message.accelerations = [TwistMessage(linear=to_vector3("acceleration", reference.acceleration))]
    return message


def message_to_reference(message: Vector3 | MultiDOFJointTrajectoryPoint, kind: str) -> Reference:
    """Return the message of a reference; lists of velocities or accelerations may be empty.

    Raises:
        RangeError: If a number is not finite, or there is not just one transform.
        UnknownNameError: If there is no such kind.
    """
    _check_kind(kind)
    if kind == "position":
        return Reference(position=_finite("reference", "position", _xyz(message)))
    if kind == "acceleration":
        return Reference(acceleration=_finite("reference", "acceleration", _xyz(message)))
    transform = _only("transforms", message.transforms, 1)
    twist = _only("velocities", message.velocities, 0)
    acceleration = _only("accelerations", message.accelerations, 0)
    x, y, z, w = _attitude("fullstate", transform.rotation)
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return Reference(
        position=_finite("fullstate", "position", _xyz(transform.translation)),
        velocity=None if twist is None else _finite("fullstate", "velocity", _xyz(twist.linear)),
        acceleration=None if acceleration is None else _finite("fullstate", "acceleration", _xyz(acceleration.linear)),
        yaw=yaw,
        yaw_rate=None if twist is None else _number("fullstate: yaw rate", twist.angular.z),
    )


def _check_kind(kind: str) -> None:
    if kind not in REFERENCES:
        raise UnknownNameError(f"kind of reference is {kind!r}, allowed: {', '.join(REFERENCES)}")


def _only(name: str, items: Sequence[Any], least: int) -> Any:
    if not least <= len(items) <= 1:
        allowed = "one" if least else "none or one"
        raise RangeError(f"fullstate: {len(items)} {name}, allowed: {allowed}")
    return items[0] if items else None


# ---------------------------------------------------------------- trajectories


def points_to_joint_trajectory(points: Sequence[TrajectoryPoint], agent_id: int) -> JointTrajectory:
    """Return points for the topic ``traj_params``; the jerk travels in the field effort.

    Raises:
        RangeError: If a number is not finite, or a time is negative.
    """
    message = JointTrajectory(joint_names=[f"Agent_{agent_id}"])
    for point in points:
        message.points.append(
            JointTrajectoryPoint(
                positions=_three("position", point.position).tolist(),
                velocities=_three("velocity", point.velocity).tolist(),
                accelerations=_three("acceleration", point.acceleration).tolist(),
                effort=_three("jerk", point.jerk).tolist(),
                time_from_start=to_duration(point.time_s),
            )
        )
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
        who = f"traj_params: point {index}"
        if point.time_from_start.sec < 0:
            raise RangeError(f"{who}: time is {seconds(point.time_from_start)} s, allowed: 0 s or more")
        vectors = {}
        for name, values in (
            ("velocity", point.velocities),
            ("acceleration", point.accelerations),
            ("jerk", point.effort),
        ):
            vectors[name] = _sized(who, name, values) if len(values) else np.zeros(3)
        points.append(
            TrajectoryPoint(
                time_s=seconds(point.time_from_start), position=_sized(who, "position", point.positions), **vectors
            )
        )
    return points


# ---------------------------------------------------------------- labeled bytes


def bytes_to_message(label: int, data: bytes) -> UInt8MultiArray:
    """Return bytes as an array of one dimension, whose label is a number in words."""
    dimension = MultiArrayDimension(label=str(label), size=len(data), stride=len(data))
    return UInt8MultiArray(layout=MultiArrayLayout(dim=[dimension]), data=data)


def message_to_bytes(message: UInt8MultiArray) -> tuple[int, bytes]:
    """Return label and bytes of an array.

    Raises:
        RangeError: If it has not just one dimension, or its label is no number.
    """
    dimensions = message.layout.dim
    if len(dimensions) != 1 or not (dimensions[0].label.isdecimal() and len(dimensions[0].label) <= _MAX_DIGITS):
        raise RangeError(f"{len(message.data)} bytes without label, allowed: one labeled dimension")
    return int(dimensions[0].label), bytes(message.data)


# ---------------------------------------------------------------- vectors


def to_vector3(name: str, values: ArrayLike | None) -> Vector3:
    """Return three finite numbers as a message.

    Raises:
        RangeError: If they are none; the message names them.
    """
    x, y, z = _three(name, values).tolist()
    return Vector3(x=x, y=y, z=z)


def _point(name: str, values: ArrayLike | None) -> Point:
    x, y, z = _three(name, values).tolist()
    return Point(x=x, y=y, z=z)


def _quaternion(name: str, values: ArrayLike | None) -> Quaternion:
    if values is None:
        return Quaternion()
    x, y, z, w = _shaped("", name, values, 4).tolist()
    return Quaternion(x=x, y=y, z=z, w=w)


def _three(name: str, values: ArrayLike | None) -> Array:
    if values is None:
        raise RangeError(f"{name} is not given, allowed: three finite numbers")
    return _shaped("", name, values, 3)


def _sized(who: str, name: str, values: ArrayLike) -> Array:
    return _shaped(f"{who}: ", name, values, 3)


def _shaped(who: str, name: str, values: ArrayLike, length: int) -> Array:
    numbers = np.asarray(values, float)
    if numbers.shape != (length,):
        raise RangeError(f"{who}{name} has shape {numbers.shape}, allowed: ({length},)")
    if not np.all(np.isfinite(numbers)):
        raise RangeError(f"{who}{name} is {numbers.tolist()}, allowed: finite numbers")
    return numbers


def _xyz(message: Any) -> Array:
    return np.array((message.x, message.y, message.z))


def _finite(who: str, name: str, numbers: Array) -> Array:
    if not np.all(np.isfinite(numbers)):
        raise RangeError(f"{who}: {name} is {numbers.tolist()}, allowed: finite numbers")
    return numbers


def _attitude(who: str, message: Quaternion) -> Array:
    return _unit(who, np.array((message.x, message.y, message.z, message.w)))


def _unit(who: str, values: Array) -> Array:
    norm = math.sqrt(float(values @ values))
    if not (math.isfinite(norm) and norm >= _MIN_NORM):
        raise RangeError(f"{who}: orientation is {values.tolist()}, allowed: a quaternion of length 1")
    return values / norm


def _number(name: str, value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise RangeError(f"{name} is {number}, allowed: a finite number")
    return number
