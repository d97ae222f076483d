"""The table of topics (docs/reference/crazychoir.md#2.2): names, message types and queue depths, in one place.

Names without a leading slash are relative to the namespace of a drone, ``agent_{i}``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from geometry_msgs.msg import Point, PoseStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty, UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory, MultiDOFJointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

NAMESPACE_PATTERN = "agent_{i}"
"""Default namespace of drone i."""

WORLD_FRAME = "world"
"""Frame of markers and mocap poses, and fixed frame of the rviz configuration; it needs no broadcast."""
ODOM_FRAME = "odom"
BODY_FRAME = "base_link"


@dataclass(frozen=True)
class Topic:
    """One line of the table."""

    name: str
    """Relative names are in the namespace of the node."""
    type: type
    """Message class."""
    publish_depth: int
    """How many messages a publisher keeps; Fast DDS has each of them acknowledged where that is one."""
    subscribe_depth: int
    """How many messages a subscriber keeps."""
    meaning: str
    """Content, with units and frame."""

    @property
    def publish_qos(self) -> QoSProfile:
        """Keep-last, reliable, volatile."""
        return qos(self.publish_depth)

    @property
    def subscribe_qos(self) -> QoSProfile:
        """Keep-last, reliable, volatile."""
        return qos(self.subscribe_depth)


def qos(depth: int) -> QoSProfile:
    """Return the default profile of ROS at a depth."""
    return QoSProfile(
        depth=depth,
        history=QoSHistoryPolicy.KEEP_LAST,
        reliability=QoSReliabilityPolicy.RELIABLE,
        durability=QoSDurabilityPolicy.VOLATILE,
    )


LATEST = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Latched: a subscriber that joins late receives the latest message."""

LAST_BUTTON = "last_button"
"""Topic (`std_msgs/String`, latched) with the latest button of a flight, of all drones or of one."""

FAILURE = "failure"
"""Topic (`std_msgs/String`, latched) with the failure of a layer of a drone, see `crazychoir_fw.ros.layer_failure`."""

ODOM = Topic(
    "odom", Odometry, 10, 10, "pose and velocity (m, m/s, world), attitude (xyzw), angular velocity (rad/s, body)"
)
CF_ODOM = Topic("cf_odom", Odometry, 10, 10, "pose that a real drone estimates itself")
MOCAP_POSE = Topic(
    "/vicon/cf{d}/cf{d}", PoseStamped, 10, 10, "pose of motion capture (m, world); d: last digit of the URI"
)
CMD_VEL = Topic(
    "cmd_vel", Twist, 10, 1, "command of a controller, by its sender: thrust and rates, angles, or velocity"
)
CMD_VEL_DES = Topic("cmd_vel_des", Twist, 10, 1, "velocity before a safety filter (m/s, world)")
ACCELERATION = Topic("acceleration", Vector3, 10, 1, "desired acceleration (m/s^2, world)")
POSITION = Topic("position", Vector3, 10, 1, "desired position (m, world)")
FULLSTATE = Topic(
    "fullstate", MultiDOFJointTrajectoryPoint, 10, 1, "desired position, yaw, velocity and acceleration (world)"
)
TRAJ_PARAMS = Topic("traj_params", JointTrajectory, 1, 10, "one point: a go-to; many: a drawn trajectory (m, s, world)")
CLOSEST_ROBOTS = Topic("closest_robots", UInt8MultiArray, 10, 10, "poses of the drones nearby")
COMMUNICATOR = Topic("communicator", UInt8MultiArray, 10, 10, "what agents tell their neighbors; label in the layout")
GOAL = Topic("goal", Point, 10, 10, "point to fly to (m, world)")
MARKER = Topic("/visualization_marker", Marker, 1, 1, "a sphere per drone, for RViz")
MARKERS = Topic("/visualization_marker_array", MarkerArray, 1, 1, "drones, trails, references and edges, for RViz")
CLOCK = Topic("/clock", Clock, 10, 1, "simulated time")

TAKEOFF = Topic("/takeoff", Empty, 10, 10, "button: all take off")
LAND = Topic("/land", Empty, 10, 10, "button: all land")
STOP = Topic("/stop", Empty, 10, 10, "button: motors off")
START = Topic("/experiment_trigger", Empty, 10, 10, "button: the experiment starts")

BUTTONS: Mapping[str, Topic] = MappingProxyType({"takeoff": TAKEOFF, "land": LAND, "stop": STOP, "start": START})
"""Swarm-wide buttons by their names in Python."""

REFERENCES: Mapping[str, Topic] = MappingProxyType(
    {"position": POSITION, "acceleration": ACCELERATION, "fullstate": FULLSTATE}
)
"""Topics of references by their kind."""

TOPICS: tuple[Topic, ...] = (
    *(ODOM, CF_ODOM, MOCAP_POSE, CMD_VEL, CMD_VEL_DES, ACCELERATION, POSITION, FULLSTATE, TRAJ_PARAMS),
    *(CLOSEST_ROBOTS, COMMUNICATOR, GOAL, MARKER, MARKERS, CLOCK, TAKEOFF, LAND, STOP, START),
)
"""The whole table."""
