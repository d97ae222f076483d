"""Definitions of the standard ROS 2 messages that a log is exported to, as an MCAP file carries them."""

from __future__ import annotations

_DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "nav_msgs/Odometry": (
        "std_msgs/Header header\nstring child_frame_id\n"
        "geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist"
    ),
    "sensor_msgs/Imu": (
        "std_msgs/Header header\n"
        "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/BatteryState": (
        "std_msgs/Header header\n"
        "float32 voltage\nfloat32 temperature\nfloat32 current\nfloat32 charge\nfloat32 capacity\n"
        "float32 design_capacity\nfloat32 percentage\n"
        "uint8 power_supply_status\nuint8 power_supply_health\nuint8 power_supply_technology\nbool present\n"
        "float32[] cell_voltage\nfloat32[] cell_temperature\nstring location\nstring serial_number"
    ),
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "rcl_interfaces/Log": (
        "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line"
    ),
}
_RULE = "=" * 80


def schema_name(message: str) -> str:
    """Return the name of a message in the form of ROS 2: ``nav_msgs/msg/Odometry``."""
    package, name = message.split("/")
    return f"{package}/msg/{name}"


def schema_text(message: str) -> str:
    """Return a definition with all definitions that it needs, in the encoding ``ros2msg``."""
    needed = _with_needed(message, [])
    parts = [_DEFINITIONS[message], *(f"{_RULE}\nMSG: {name}\n{_DEFINITIONS[name]}" for name in needed[1:])]
    return "\n".join(parts) + "\n"


def _with_needed(message: str, found: list[str]) -> list[str]:
    """Append a message and what it is made of, each once."""
    if message not in found:
        found.append(message)
        for line in _DEFINITIONS[message].splitlines():
            part = line.split()[0].partition("[")[0]
            if "/" in part:
                _with_needed(part, found)
    return found
