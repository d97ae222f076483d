"""What of a flight log goes into which ROS 2 message.

Units and frames are those of ROS (m, rad, V, A; world ``world``, body ``{id}``), except that the linear velocity of an
odometry is in the world frame, as CrazyChoir's nodes have it (docs/reference/crazychoir.md#2.2).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys.stores import ros2_jazzy as ros

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.motor_logs import FULL_DUTY

WORLD = "world"
GRAVITY = 9.81  # [m/s^2], what the firmware's accelerations are counted in
_RAD_PER_S_PER_RPM = np.pi / 30
_MOTORS = ["m1", "m2", "m3", "m4"]
_DIAGONAL = np.arange(0, 36, 7)[:3]  # of x, y, z in a covariance of 6 x 6
_NONE, _NO_COVARIANCE = np.zeros(0), np.zeros(9)

Array = NDArray[np.float64]
Samples = Callable[[str], Array]
"""Returns a signal of one drone, shape (T,); NaN where the log has none."""


@dataclass(frozen=True)
class Topic:
    """One topic of every drone."""

    name: str
    """Behind the name of the drone."""
    type: type
    """Of its messages."""
    needs: tuple[str, ...]
    """Signals without which there is no such topic."""
    messages: Callable[[list[int], str, Samples], Iterator[Any]]
    """From time stamps (ns, T of them), the name of the drone and its samples: T messages."""


def _time(nanoseconds: int) -> Any:
    return ros.builtin_interfaces__msg__Time(*divmod(nanoseconds, 1_000_000_000))


def _headers(stamps: list[int], frame: str) -> Iterator[Any]:
    return (ros.std_msgs__msg__Header(_time(stamp), frame) for stamp in stamps)


def _vectors(of: Samples, prefix: str, *names: str, factor: float = 1.0) -> Iterator[Any]:
    return (ros.geometry_msgs__msg__Vector3(*row) for row in (factor * _columns(of, prefix, *names)).tolist())


def _points(of: Samples, prefix: str) -> Iterator[Any]:
    return (ros.geometry_msgs__msg__Point(*row) for row in _columns(of, prefix, "x", "y", "z").tolist())


def _quaternions(quat_xyzw: Array) -> Iterator[Any]:
    return (ros.geometry_msgs__msg__Quaternion(*row) for row in quat_xyzw.tolist())


def _true_attitudes(of: Samples) -> Iterator[Any]:
    return _quaternions(quat_xyzw(of("sim.roll"), of("sim.pitch"), of("sim.yaw")))


def _odometry(
    stamps: list[int], drone: str, pose: tuple[Iterable[Any], ...], twist: tuple[Iterable[Any], ...]
) -> Iterator[Any]:
    """Return odometry from (positions, attitudes, covariances) and (linear, angular)."""
    positions, attitudes, covariances = pose
    unknown = np.zeros(36)
    return (
        ros.nav_msgs__msg__Odometry(
            header,
            drone,
            ros.geometry_msgs__msg__PoseWithCovariance(ros.geometry_msgs__msg__Pose(position, attitude), covariance),
            ros.geometry_msgs__msg__TwistWithCovariance(ros.geometry_msgs__msg__Twist(linear, angular), unknown),
        )
        for header, position, attitude, covariance, linear, angular in zip(
            _headers(stamps, WORLD), positions, attitudes, covariances, *twist, strict=True
        )
    )


def _truth(stamps: list[int], drone: str, of: Samples) -> Iterator[Any]:
    pose = (_points(of, "sim."), _true_attitudes(of), repeat(np.zeros(36), len(stamps)))
    return _odometry(
        stamps, drone, pose, (_vectors(of, "sim.", "vx", "vy", "vz"), _vectors(of, "sim.", "wx", "wy", "wz"))
    )


def _estimate(stamps: list[int], drone: str, of: Samples) -> Iterator[Any]:
    covariances = np.zeros((len(stamps), 36))
    # 0 means unknown, as without a Kalman filter
    covariances[:, _DIAGONAL] = np.nan_to_num(_columns(of, "kalman.", "varX", "varY", "varZ"))
    attitudes = _quaternions(_columns(of, "stateEstimate.", "qx", "qy", "qz", "qw"))
    pose = (_points(of, "stateEstimate."), attitudes, covariances)
    return _odometry(stamps, drone, pose, (_vectors(of, "stateEstimate.", "vx", "vy", "vz"), _rates(of)))


def _rates(of: Samples) -> Iterator[Any]:
    rates = np.radians(_columns(of, "gyro.", "x", "y", "z"))
    return (ros.geometry_msgs__msg__Vector3(*row) for row in rates.tolist())


def _imu(stamps: list[int], drone: str, of: Samples) -> Iterator[Any]:
    # -1 says that an inertial sensor knows no attitude
    attitude, unknown = ros.geometry_msgs__msg__Quaternion(0.0, 0.0, 0.0, 1.0), np.array([-1.0, *[0.0] * 8])
    accelerations = _vectors(of, "acc.", "x", "y", "z", factor=GRAVITY)
    return (
        ros.sensor_msgs__msg__Imu(header, attitude, unknown, rates, _NO_COVARIANCE, acceleration, _NO_COVARIANCE)
        for header, rates, acceleration in zip(_headers(stamps, drone), _rates(of), accelerations, strict=True)
    )


def _battery(stamps: list[int], drone: str, of: Samples) -> Iterator[Any]:
    kind, nan, no_cells = ros.sensor_msgs__msg__BatteryState, float("nan"), np.zeros(0, np.float32)
    return (
        kind(
            *(header, voltage, nan, current, nan, nan, nan, charge),
            power_supply_status=kind.POWER_SUPPLY_STATUS_DISCHARGING,
            power_supply_health=kind.POWER_SUPPLY_HEALTH_UNKNOWN,
            power_supply_technology=kind.POWER_SUPPLY_TECHNOLOGY_LIPO,
            present=True,
            cell_voltage=no_cells,
            cell_temperature=no_cells,
            location="",
            serial_number="",
        )
        for header, voltage, current, charge in zip(
            _headers(stamps, drone),
            of("pm.vbat").tolist(),
            (-of("sim.current")).tolist(),  # negative when it discharges
            of("sim.charge").tolist(),
            strict=True,
        )
    )


def _setpoint(stamps: list[int], drone: str, of: Samples) -> Iterator[Any]:
    del drone
    yaw = of("ctrltarget.yaw")
    level = np.zeros_like(yaw)
    poses = zip(_points(of, "ctrltarget."), _quaternions(quat_xyzw(level, level, yaw)), strict=True)
    return (
        ros.geometry_msgs__msg__PoseStamped(header, ros.geometry_msgs__msg__Pose(*pose))
        for header, pose in zip(_headers(stamps, WORLD), poses, strict=True)
    )


def _motors(stamps: list[int], drone: str, of: Samples) -> Iterator[Any]:
    speeds = _RAD_PER_S_PER_RPM * _columns(of, "sim.rpm", "1", "2", "3", "4")
    duties = _columns(of, "motor.", *_MOTORS) / FULL_DUTY
    return (
        ros.sensor_msgs__msg__JointState(header, _MOTORS, _NONE, speed, duty)
        for header, speed, duty in zip(_headers(stamps, drone), speeds, duties, strict=True)
    )


def _transform(stamps: list[int], drone: str, of: Samples) -> Iterator[Any]:
    poses = zip(_vectors(of, "sim.", "x", "y", "z"), _true_attitudes(of), strict=True)
    transforms = (ros.geometry_msgs__msg__Transform(*pose) for pose in poses)
    return (
        ros.tf2_msgs__msg__TFMessage([ros.geometry_msgs__msg__TransformStamped(header, drone, transform)])
        for header, transform in zip(_headers(stamps, WORLD), transforms, strict=True)
    )


_POSE = ("sim.x", "sim.y", "sim.z", "sim.roll", "sim.pitch", "sim.yaw")

TOPICS = (
    Topic("odom", ros.nav_msgs__msg__Odometry, _POSE, _truth),
    Topic("estimate", ros.nav_msgs__msg__Odometry, ("stateEstimate.x", "stateEstimate.qw"), _estimate),
    Topic("imu", ros.sensor_msgs__msg__Imu, ("gyro.x", "acc.x"), _imu),
    Topic("battery", ros.sensor_msgs__msg__BatteryState, ("pm.vbat",), _battery),
    Topic("setpoint", ros.geometry_msgs__msg__PoseStamped, ("ctrltarget.x",), _setpoint),
    Topic("motors", ros.sensor_msgs__msg__JointState, ("motor.m1",), _motors),
)
"""Topics of every drone, named ``/{id}/{name}``."""

TRANSFORM = Topic("/tf", ros.tf2_msgs__msg__TFMessage, _POSE, _transform)
"""One topic that all drones share."""

Log = ros.rcl_interfaces__msg__Log
_LEVELS = {"collision": Log.WARN, "fault": Log.WARN, "crash": Log.ERROR, "failure": Log.ERROR}


def event_message(event: Mapping[str, Any], nanoseconds: int) -> Any:
    """Return an event as ``rcl_interfaces/Log``."""
    details = " ".join(f"{key}={value}" for key, value in (event.get("details") or {}).items())
    text = f"{event['kind']} {details}".strip()
    level = _LEVELS.get(event["kind"], Log.INFO)
    return Log(_time(nanoseconds), level, event.get("drone") or WORLD, text, file="", function="", line=0)


def quat_xyzw(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Return quaternions, shape (T, 4), from angles (deg); pitch with the firmware's sign, positive lifts the nose."""
    return quaternion_xyzw(np.radians(np.stack([roll, -pitch, yaw], axis=-1)))


def _columns(of: Samples, prefix: str, *names: str) -> Array:
    return np.stack([of(prefix + name) for name in names], axis=-1)
