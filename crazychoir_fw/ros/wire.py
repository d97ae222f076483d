"""Messages as they travel, bytes of CDR: what goes around a hundred times a second per drone is not worth objects.

Filling and encoding an odometry message takes 36 µs, writing its numbers into bytes that are ready takes 3 µs; decoding
one takes 120 µs (its covariances are 72 numbers), reading what is wanted 2 µs. Publishers of rclpy take such bytes as
they are, and subscriptions with ``raw=True`` hand them out.

What is not little-endian CDR of version 1, which everything here sends, is decoded by rclpy.
"""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import UInt8MultiArray
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.recording.cdr import CdrLayout
from crazychoir_fw.ros.conversions import message_to_reference, odometry_to_pose, reference_to_message
from crazychoir_fw.ros.names import BODY_FRAME, ODOM_FRAME, WORLD_FRAME

Array = NDArray[np.float64]

EMPTY = b"\x00\x01\x00\x00\x00"
"""A ``std_msgs/Empty``."""

_PLAIN_CDR = b"\x00\x01"
_BODY = 4  # bytes of the encapsulation, which alignment does not count
_STAMP = struct.Struct("<iI")
_LENGTH = struct.Struct("<I")
_POSE = struct.Struct("<7d")
_SIX = struct.Struct("<6d")
_THREE = struct.Struct("<3d")
_COVARIANCE = 36 * 8
# one transform, one velocity, one acceleration, and a duration, each list with its length and what aligns it
_FULLSTATE = struct.Struct("<2s2xI4x7dI4x6dI4x6diI")
MIN_NORM = 0.8  # of a quaternion: less is a lost sample (docs/reference/crazychoir.md#10)


def odometry_layout(frame_id: str = ODOM_FRAME, child_frame_id: str = BODY_FRAME) -> CdrLayout:
    """Return where the numbers of a ``nav_msgs/Odometry`` stand."""
    layout = CdrLayout().stamp(frame_id).text(child_frame_id)
    layout.number("position", "f8", 3).number("orientation", "f8", 4).constant("f8", *[0.0] * 36)
    return layout.number("velocity", "f8", 3).number("angular", "f8", 3).constant("f8", *[0.0] * 36)


def pose_stamped_layout(frame_id: str = WORLD_FRAME) -> CdrLayout:
    """Return where the numbers of a ``geometry_msgs/PoseStamped`` stand."""
    return CdrLayout().stamp(frame_id).number("position", "f8", 3).number("orientation", "f8", 4)


def clock_layout() -> CdrLayout:
    """Return where the numbers of a ``rosgraph_msgs/Clock`` stand."""
    return CdrLayout().stamp()


def imu_layout(frame_id: str = BODY_FRAME) -> CdrLayout:
    """Return where the numbers of a ``sensor_msgs/Imu`` without attitude stand."""
    layout = CdrLayout().stamp(frame_id).constant("f8", 0.0, 0.0, 0.0, 1.0).constant("f8", -1.0, *[0.0] * 8)
    layout.number("angular", "f8", 3).constant("f8", *[0.0] * 9)
    return layout.number("acceleration", "f8", 3).constant("f8", *[0.0] * 9)


class Rows:
    """Messages of one topic for each of several drones, filled in by the column, taken by the row."""

    def __init__(self, layout: CdrLayout, count: int) -> None:
        """Make `count` messages."""
        self.columns = layout.rows(count)
        """Structured array, shape (count,), one field per number or vector."""

    def stamp(self, nanoseconds: int) -> None:
        """Give all of them one time stamp."""
        sec, nanosec = divmod(nanoseconds, 1_000_000_000)
        self.columns["sec"] = sec
        self.columns["nanosec"] = nanosec

    def row(self, index: int) -> bytes:
        """Return one of them, ready to be published."""
        return self.columns[index].tobytes()


def twist_numbers(data: bytes) -> tuple[float, ...]:
    """Return linear and angular of a ``geometry_msgs/Twist``, six numbers."""
    if data[:2] == _PLAIN_CDR and len(data) >= _BODY + _SIX.size:
        return _SIX.unpack_from(data, _BODY)
    message: Any = deserialize_message(data, Twist)
    linear, angular = message.linear, message.angular
    return linear.x, linear.y, linear.z, angular.x, angular.y, angular.z


def vector3_numbers(data: bytes) -> tuple[float, ...]:
    """Return the numbers of a ``geometry_msgs/Vector3``."""
    if data[:2] == _PLAIN_CDR and len(data) >= _BODY + _THREE.size:
        return _THREE.unpack_from(data, _BODY)
    message: Any = deserialize_message(data, Vector3)
    return message.x, message.y, message.z


def vector3_bytes(x: float, y: float, z: float) -> bytes:
    """Return a ``geometry_msgs/Vector3`` ready to be published."""
    return b"\x00\x01\x00\x00" + _THREE.pack(x, y, z)


def reference_bytes(reference: Reference, kind: str) -> bytes:
    """Return a reference as the message of its kind, ready to be published.

    Raises:
        RangeError: If a number is not finite, or the reference lacks what the kind needs.
    """
    if kind == "fullstate":
        vectors = (reference.position, reference.velocity, reference.acceleration)
        if all(type(vector) is np.ndarray and vector.shape == (3,) for vector in vectors):
            half = 0.5 * (0.0 if reference.yaw is None else float(reference.yaw))
            turn = 0.0 if reference.yaw_rate is None else float(reference.yaw_rate)
            place, speed, push = (vector.tolist() for vector in vectors)
            if math.isfinite(sum(place) + sum(speed) + sum(push) + half + turn):
                rotation = (0.0, 0.0, math.sin(half), math.cos(half))
                return _FULLSTATE.pack(
                    *(_PLAIN_CDR, 1, *place, *rotation, 1, *speed, 0.0, 0.0, turn, 1, *push, 0.0, 0.0, 0.0, 0, 0)
                )
    else:
        vector = getattr(reference, kind)
        if vector is not None and vector.shape == (3,):
            x, y, z = vector.tolist()
            if math.isfinite(x + y + z):
                return vector3_bytes(x, y, z)
    return bytes(serialize_message(reference_to_message(reference, kind)))  # which says what is wrong


def bytes_to_reference(data: bytes, kind: str) -> Reference:
    """Return the message of a reference.

    Raises:
        RangeError: If a number is not finite, or it is no such message.
    """
    if kind == "fullstate":
        if len(data) == _FULLSTATE.size and data[:2] == _PLAIN_CDR:
            _, n, *pose, m, vx, vy, vz, _, _, turn, k, ax, ay, az, _, _, _, _, _ = _FULLSTATE.unpack(data)
            z, w = pose[5:]
            # turned about z only, as here; whatever else there is, is decoded with care
            if n == m == k == 1 and pose[3] == pose[4] == 0.0 and abs(z * z + w * w - 1.0) < 1e-9:
                vectors = (np.array(pose[:3]), np.array((vx, vy, vz)), np.array((ax, ay, az)))
                if math.isfinite(sum(pose) + vx + vy + vz + turn + ax + ay + az):
                    return Reference(*vectors, yaw=math.atan2(2.0 * w * z, 1.0 - 2.0 * z * z), yaw_rate=turn)
        return message_to_reference(deserialize_message(data, MultiDOFJointTrajectoryPoint), kind)
    numbers = vector3_numbers(data)
    if not math.isfinite(sum(numbers)):
        raise RangeError(f"reference: {kind} is {list(numbers)}, allowed: finite numbers")
    return Reference(**{kind: np.array(numbers)})


def twist_bytes(linear: Array, angular: Array) -> bytes:
    """Return a ``geometry_msgs/Twist`` ready to be published."""
    return b"\x00\x01\x00\x00" + _SIX.pack(*linear, *angular)


def odometry_pose(data: bytes) -> Pose:
    """Return the pose of a ``nav_msgs/Odometry``; a stamp of zero is no stamp.

    Raises:
        RangeError: If a number is not finite, or the quaternion is none.
    """
    if data[:2] != _PLAIN_CDR:
        return odometry_to_pose(deserialize_message(data, Odometry))
    try:
        sec, nanosec = _STAMP.unpack_from(data, _BODY)
        place = _after_text(data, _after_text(data, _BODY + _STAMP.size))
        place += -(place - _BODY) % 8
        pose = np.array(_POSE.unpack_from(data, place))
        motion = np.array(_SIX.unpack_from(data, place + _POSE.size + _COVARIANCE))
    except struct.error:
        raise RangeError(f"odometry: a message of {len(data)} bytes is too short") from None
    quaternion = pose[3:]
    norm = float(quaternion @ quaternion) ** 0.5
    # one look at the sum finds what is not finite in any of the numbers
    if not (np.isfinite(pose.sum() + motion.sum()) and norm >= MIN_NORM):
        return odometry_to_pose(deserialize_message(data, Odometry))  # which says what is wrong
    time = sec + nanosec / 1e9 if sec or nanosec else None
    return Pose(pose[:3], quaternion / norm, motion[:3], motion[3:], time)


def _after_text(data: bytes, place: int) -> int:
    place += -(place - _BODY) % 4
    (length,) = _LENGTH.unpack_from(data, place)
    return int(place + _LENGTH.size + length)


def labeled_bytes(label: int, data: bytes) -> bytes:
    """Return a ``std_msgs/UInt8MultiArray`` ready to be published: one dimension, whose label is a number in words."""
    text = b"%d\0" % label
    head = b"\x00\x01\x00\x00" + _LENGTH.pack(1) + _LENGTH.pack(len(text)) + text + bytes(-len(text) % 4)
    size = _LENGTH.pack(len(data))
    return head + size + size + _LENGTH.pack(0) + size + data


def label_and_data(data: bytes) -> tuple[int, bytes]:
    """Return label and data of a ``std_msgs/UInt8MultiArray``.

    Raises:
        RangeError: If its layout has not just one dimension, or its label is no number.
    """
    if data[:2] == _PLAIN_CDR:
        try:
            (dimensions,) = _LENGTH.unpack_from(data, _BODY)
            (length,) = _LENGTH.unpack_from(data, _BODY + 4)
            text = data[_BODY + 8 : _BODY + 7 + length]
            place = _after_text(data, _BODY + 4)
            place += -(place - _BODY) % 4
            (size,) = _LENGTH.unpack_from(data, place + 12)
            content = data[place + 16 : place + 16 + size]
            if dimensions == 1 and len(content) == size and text.isdigit() and len(text) <= 18:
                return int(text), content
        except struct.error:
            pass
        raise RangeError(f"communicator: a message of {len(data)} bytes without label, allowed: one labeled dimension")
    message: Any = deserialize_message(data, UInt8MultiArray)
    if len(message.layout.dim) != 1 or not message.layout.dim[0].label.isdecimal():
        raise RangeError("communicator: a message without label, allowed: one labeled dimension")
    return int(message.layout.dim[0].label), bytes(message.data)
