"""Where poses come from: odometry, motion capture in meters, or the legacy message in millimeters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from rclpy.subscription import Subscription

from crazychoir_fw.common.errors import StateError, UnknownNameError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import decode_odometry, decode_pose_stamped, decode_vicon_position
from crazychoir_fw.ros.conversions import checked_pose, odometry_to_pose
from crazychoir_fw.ros.names import MOCAP_POSE, ODOM, Topic, qos
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.odometry import bytes_to_pose

HANDLERS = ("pubsub", "pose", "vicon", "vicon_mm")
"""Odometry; PoseStamped under two names; the message of vicon_receiver before its version 1.0."""


def pose_subscribe(
    handler: str | None,
    topic: str | None,
    node: LayerNode,
    dest_pose: Pose | Callable[[Pose], None],
    callback: Callable[[], Any] | None = None,
    callback_group: CallbackGroup | None = None,
    qos_profile: QoSProfile | int | None = None,
) -> Subscription | None:
    """Subscribe to poses.

    An invalid pose (NaN, no quaternion, the zeros of an occluded drone) is dropped. A `callback` with a method
    `set_pose`, such as `crazychoir_fw.mocap.Estimator`, is a filter: `set_pose` gets the pose object once, and the
    filter is called before `dest_pose`. Any other callback is called after `dest_pose`.

    Args:
        handler: ``pubsub`` (nav_msgs/Odometry), ``pose`` or ``vicon`` (geometry_msgs/PoseStamped), ``vicon_mm``
            (vicon_receiver/Position, if that package is installed). None subscribes to nothing.
        topic: Name of the topic.
        node: Node that subscribes. Poses without a stamp get its time.
        dest_pose: A pose that is filled in, or a function that is called with each pose.
        callback: Called without arguments after each pose.
        callback_group: Callback group of rclpy.
        qos_profile: Quality of service, or a depth. By default a depth of 10: reliable for odometry; best effort for
            motion capture, since it matches every publisher, and a late pose has no use.

    Raises:
        UnknownNameError: If there is no such handler.
        StateError: If the handler needs a package that is not there.
    """
    if handler is None or topic is None:
        return None
    who = node.get_fully_qualified_name()
    if handler not in HANDLERS:
        raise UnknownNameError(f"{who}: pose_handler is {handler!r}, allowed: {', '.join(HANDLERS)}")
    line, decode, strict = _source(handler, node)
    is_filter = hasattr(callback, "set_pose")
    kept = dest_pose if isinstance(dest_pose, Pose) else Pose()
    if is_filter:
        callback.set_pose(kept)  # type: ignore[union-attr]

    def accept(pose: Pose) -> None:
        if pose.time is None:
            pose.time = node.now()
        if not is_filter and not isinstance(dest_pose, Pose):
            # the caller's function takes the pose itself: no copy is needed
            if pose.position is not None:
                dest_pose(pose)
            if callback is not None:
                callback()
            return
        for field in fields(Pose):
            setattr(kept, field.name, getattr(pose, field.name))
        if is_filter:
            callback()  # type: ignore[misc]
        if not isinstance(dest_pose, Pose) and kept.position is not None:
            dest_pose(replace(kept))
        if callback is not None and not is_filter:
            callback()

    def take(message: Any) -> None:
        accept(decode(message) if is_filter else strict(message))

    if qos_profile is None and handler != "pubsub":
        qos_profile = qos(line.subscribe_depth)
        qos_profile.reliability = QoSReliabilityPolicy.BEST_EFFORT
    profile = qos(qos_profile) if isinstance(qos_profile, int) else qos_profile
    if line is ODOM and not is_filter:
        return node.listen_to_bytes(
            line, lambda data: accept(bytes_to_pose(data)), topic, profile=profile, callback_group=callback_group
        )
    return node.listen(line, take, topic, profile=profile, callback_group=callback_group, fast=line is ODOM)


def _source(handler: str, node: LayerNode) -> tuple[Topic, Callable[[Any], Pose], Callable[[Any], Pose]]:
    """Return the line of the table, a decoder without checks, and one that raises on bad messages."""
    if handler == "pubsub":
        return ODOM, decode_odometry, odometry_to_pose
    if handler in ("pose", "vicon"):
        return MOCAP_POSE, decode_pose_stamped, lambda message: checked_pose("pose", decode_pose_stamped(message))
    try:
        from vicon_receiver.msg import Position
    except ImportError:
        raise StateError(
            f"{node.get_fully_qualified_name()}: pose_handler 'vicon_mm' needs the messages of vicon_receiver before "
            "1.0, which are not installed: build that package in a workspace and source it, or use 'vicon', which "
            "takes the PoseStamped of version 1.0 and later"
        ) from None
    line = replace(MOCAP_POSE, type=Position)
    # it has no stamp
    return (
        line,
        lambda message: decode_vicon_position(message, node.now()),
        lambda message: checked_pose("vicon", decode_vicon_position(message, node.now())),
    )
