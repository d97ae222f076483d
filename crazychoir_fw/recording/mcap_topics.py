"""What of a flight log goes into which ROS 2 message.

Units and frames are those of ROS (m, rad, V, A; world ``world``, body ``{id}``), except that the linear velocity of an
odometry is in the world frame, as CrazyChoir's nodes have it (docs/reference/crazychoir.md#2.2).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.cdr import CdrLayout

WORLD = "world"
GRAVITY = 9.81  # [m/s^2], what the firmware's accelerations are counted in
_FULL_DUTY = 65535.0
_RAD_PER_S_PER_RPM = np.pi / 30
_MOTORS = ("m1", "m2", "m3", "m4")
_DIAGONAL = np.arange(0, 36, 7)[:3]  # of x, y, z in a covariance of 6 x 6
_UNKNOWN = 0

Samples = Callable[[str], NDArray[np.float64]]
"""Returns a signal of one drone, shape (T,); NaN where the log has none."""


@dataclass(frozen=True)
class Topic:
    """One topic of every drone."""

    name: str
    """Behind the name of the drone."""
    message: str
    """Such as ``nav_msgs/Odometry``."""
    needs: tuple[str, ...]
    """Signals without which there is no such topic."""
    layout: Callable[[str], CdrLayout]
    """From the name of the drone."""
    fill: Callable[[NDArray[Any], Samples], None]
    """Fills the messages in."""


def _odometry(drone: str) -> CdrLayout:
    layout = CdrLayout().stamp(WORLD).text(drone)
    layout.number("position", "f8", 3).number("orientation", "f8", 4).number("pose_covariance", "f8", 36)
    return layout.number("linear", "f8", 3).number("angular", "f8", 3).number("twist_covariance", "f8", 36)


def _fill_truth(rows: NDArray[Any], of: Samples) -> None:
    rows["position"] = _columns(of, "sim.", "x", "y", "z")
    rows["orientation"] = quat_xyzw(of("sim.roll"), of("sim.pitch"), of("sim.yaw"))
    rows["linear"] = _columns(of, "sim.", "vx", "vy", "vz")
    rows["angular"] = _columns(of, "sim.", "wx", "wy", "wz")


def _fill_estimate(rows: NDArray[Any], of: Samples) -> None:
    rows["position"] = _columns(of, "stateEstimate.", "x", "y", "z")
    rows["orientation"] = _columns(of, "stateEstimate.", "qx", "qy", "qz", "qw")
    rows["linear"] = _columns(of, "stateEstimate.", "vx", "vy", "vz")
    rows["angular"] = np.radians(_columns(of, "gyro.", "x", "y", "z"))
    # 0 means unknown, as without a Kalman filter
    rows["pose_covariance"][:, _DIAGONAL] = np.nan_to_num(_columns(of, "kalman.", "varX", "varY", "varZ"))


def _imu(drone: str) -> CdrLayout:
    layout = CdrLayout().stamp(drone)
    # -1 says that an inertial sensor knows no attitude
    layout.constant("f8", 0, 0, 0, 1).constant("f8", -1, *[0] * 8)
    layout.number("angular", "f8", 3).constant("f8", *[0] * 9)
    return layout.number("linear", "f8", 3).constant("f8", *[0] * 9)


def _fill_imu(rows: NDArray[Any], of: Samples) -> None:
    rows["angular"] = np.radians(_columns(of, "gyro.", "x", "y", "z"))
    rows["linear"] = GRAVITY * _columns(of, "acc.", "x", "y", "z")


def _battery(drone: str) -> CdrLayout:
    nan = float("nan")
    layout = CdrLayout().stamp(drone).number("voltage", "f4").constant("f4", nan).number("current", "f4")
    layout.constant("f4", nan, nan, nan).number("percentage", "f4")
    layout.number("status", "u1").constant("u1", _UNKNOWN, _LITHIUM_POLYMER, True)
    return layout.constant("u4", 0).constant("u4", 0).text("").text("")


_LITHIUM_POLYMER = 3
_DISCHARGING = 2


def _fill_battery(rows: NDArray[Any], of: Samples) -> None:
    rows["voltage"] = of("pm.vbat")
    rows["current"] = -of("sim.current")  # negative when it discharges
    rows["percentage"] = of("sim.charge")
    rows["status"] = _DISCHARGING


def _setpoint(drone: str) -> CdrLayout:
    del drone
    return CdrLayout().stamp(WORLD).number("position", "f8", 3).number("orientation", "f8", 4)


def _fill_setpoint(rows: NDArray[Any], of: Samples) -> None:
    rows["position"] = _columns(of, "ctrltarget.", "x", "y", "z")
    yaw = of("ctrltarget.yaw")
    rows["orientation"] = quat_xyzw(np.zeros_like(yaw), np.zeros_like(yaw), yaw)


def _motors(drone: str) -> CdrLayout:
    layout = CdrLayout().stamp(drone).constant("u4", len(_MOTORS))
    for motor in _MOTORS:
        layout.text(motor)
    layout.constant("u4", 0).constant("u4", len(_MOTORS)).number("speed", "f8", len(_MOTORS))
    return layout.constant("u4", len(_MOTORS)).number("duty", "f8", len(_MOTORS))


def _fill_motors(rows: NDArray[Any], of: Samples) -> None:
    rows["speed"] = _RAD_PER_S_PER_RPM * _columns(of, "sim.rpm", "1", "2", "3", "4")
    rows["duty"] = _columns(of, "motor.", *_MOTORS) / _FULL_DUTY


def _transform(drone: str) -> CdrLayout:
    layout = CdrLayout().constant("u4", 1).stamp(WORLD).text(drone)
    return layout.number("position", "f8", 3).number("orientation", "f8", 4)


def _fill_transform(rows: NDArray[Any], of: Samples) -> None:
    rows["position"] = _columns(of, "sim.", "x", "y", "z")
    rows["orientation"] = quat_xyzw(of("sim.roll"), of("sim.pitch"), of("sim.yaw"))


_TRUTH = ("sim.x", "sim.y", "sim.z", "sim.roll", "sim.pitch", "sim.yaw")

TOPICS = (
    Topic("odom", "nav_msgs/Odometry", _TRUTH, _odometry, _fill_truth),
    Topic("estimate", "nav_msgs/Odometry", ("stateEstimate.x", "stateEstimate.qw"), _odometry, _fill_estimate),
    Topic("imu", "sensor_msgs/Imu", ("gyro.x", "acc.x"), _imu, _fill_imu),
    Topic("battery", "sensor_msgs/BatteryState", ("pm.vbat",), _battery, _fill_battery),
    Topic("setpoint", "geometry_msgs/PoseStamped", ("ctrltarget.x",), _setpoint, _fill_setpoint),
    Topic("motors", "sensor_msgs/JointState", ("motor.m1",), _motors, _fill_motors),
)
"""Topics of every drone, named ``/{id}/{name}``."""

TRANSFORM = Topic("/tf", "tf2_msgs/TFMessage", _TRUTH, _transform, _fill_transform)
"""One topic that all drones share."""

DEBUG, INFO, WARN, ERROR, FATAL = 10, 20, 30, 40, 50
_LEVELS = {"collision": WARN, "fault": WARN, "crash": ERROR, "failure": ERROR}


def event_message(event: Mapping[str, Any], nanoseconds: int) -> bytes:
    """Return an event as ``rcl_interfaces/Log``."""
    details = " ".join(f"{key}={value}" for key, value in (event.get("details") or {}).items())
    layout = CdrLayout().stamp().constant("u1", _LEVELS.get(event["kind"], INFO))
    layout.text(event.get("drone") or WORLD).text(f"{event['kind']} {details}".strip())
    rows = layout.text("").text("").constant("u4", 0).rows(1)
    rows["sec"], rows["nanosec"] = divmod(nanoseconds, 1_000_000_000)
    return rows.tobytes()


def quat_xyzw(roll: NDArray[np.float64], pitch: NDArray[np.float64], yaw: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return quaternions, shape (T, 4), from angles (deg); pitch with the firmware's sign, positive lifts the nose."""
    r, p, y = (np.radians(angle) / 2 for angle in (roll, -np.asarray(pitch), yaw))
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
    return np.stack(
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ],
        axis=-1,
    )


def _columns(of: Samples, prefix: str, *names: str) -> NDArray[np.float64]:
    return np.stack([of(prefix + name) for name in names], axis=-1)
