"""A flight of our own simulator, written as NanoBench writes flights of real drones."""

import csv
import gzip
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
from crazychoir_fw._core import ffi
from crazychoir_fw.comparison.nanobench import read_flight
from crazychoir_fw.comparison.phases import find_phases
from crazychoir_fw.comparison.signals import roll_pitch_yaw
from crazychoir_fw.simulation import DroneConfig, World

TRUTH = {
    "mass": 0.04085,
    "inertia": (3.0e-5, 3.0e-5, 5.4e-5),
    "drag.body": 0.0,
    "drag.rotor_xy": 1.6e-6,
    "flight_moment.x": 6.0e-4,
    "flight_moment.y": 7.5e-4,
    "flight_moment.thrust": 0.4007,
    "rotors.time_constant_up": 0.07,
    "rotors.time_constant_down": 0.07,
    "rotors.heat_loss": 0.08,
    "rotors.heat_time": 5.0,
    "rotors.heat_own_loss": 0.15,
    "rotors.heat_own_time": 1.5,
    "rotors.heat_thrust": 0.1002,
    "battery.resistance": 0.18,
}
OWN = {"rotors.thrust_scale": 0.95, "trim.torque": (4.0e-4, -3.0e-4, 5.0e-5)}
CAMERAS = {"mocap_latency_ms": 30, "mocap_std": 0.01}  # the deviation that the firmware has from the factory
LOGS = {
    **{f"motor_motor_m{i}": f"motor.m{i}" for i in (1, 2, 3, 4)},
    **{f"est_stateEstimate_{name}": f"stateEstimate.{name}" for name in ("x", "y", "z", "vx", "vy", "vz")},
    **{f"att_stateEstimate_{name}": f"stateEstimate.{name}" for name in ("roll", "pitch", "yaw")},
    **{f"sp_ctrltarget_{name}": f"ctrltarget.{name}" for name in "xyz"},
    **{f"pid_controller_{name}": f"controller.{name}" for name in ("roll", "pitch", "yaw", "cmd_thrust")},
    "pwr_pm_vbat": "pm.vbat",
}


def target(time):
    """Where the drone is to be: take-off, hover, a wavy circle at 0.6 m/s."""
    if time < 4.0:
        share = np.clip((time - 1.0) / 2.0, 0.0, 1.0)
        return 0.0, 0.0, float(0.1 + 0.9 * share**2 * (3 - 2 * share))
    phase = (time - 4.0) / 0.6 * 0.6 / 1.0
    return 0.6 * float(np.sin(phase)), 0.6 * float(1 - np.cos(phase)), 1.0 + 0.1 * float(np.sin(1.7 * phase))


def shaken(time):
    """The same with all that the position loop can follow about roll and pitch."""
    x, y, z = target(time)
    swing = 0.2 if time > 4.0 else 0.0
    return x + swing * np.sin(2 * np.pi * 0.9 * (time - 4)), y + swing * np.sin(2 * np.pi * 1.1 * (time - 4)), z


def record(path, seconds=14.0, course=target, thrust_max=None):
    """Fly and write a flight; `thrust_max` is that of another build of the firmware (N)."""
    config = DroneConfig(
        "cf1",
        vehicle={**TRUTH, **OWN},
        positioning="mocap_position",
        attributes=CAMERAS,
        noise=0.5,
    )
    world = World([config], visuals=False)
    drone = world.drones[0]
    if thrust_max is not None:
        ffi.cast("cf_builtin_t *", drone.struct.provider_state).power.thrust.thrust_max = thrust_max
    world.wait_until_ready()
    rows = []
    for row in range(round(seconds * 100)):
        if row >= 100:
            drone.commander.send_position_setpoint(*course(row / 100), 0.0)
        world.step(10)
        x, y, z, w = (drone.true_quat_wxyz[i] for i in (1, 2, 3, 0))
        angles = np.radians(roll_pitch_yaw(np.array([[x, y, z, w]])))[0]
        logs = {column: drone.log[name] for column, name in LOGS.items()}
        gyro = {f"imu_gyro_{axis}": rate for axis, rate in zip("xyz", drone.true_rates, strict=True)}
        pose = dict(zip(("px", "py", "pz"), drone.true_position, strict=True)) | {"qx": x, "qy": y, "qz": z, "qw": w}
        pose |= dict(zip(("roll", "pitch", "yaw"), angles, strict=True))
        rows.append({"t": 1.7e9 + row / 100, **pose, **gyro, **logs})
    with gzip.open(path, "wt", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    return path


@pytest.fixture(scope="session")
def synthetic_path(tmp_path_factory):
    return record(tmp_path_factory.mktemp("flights") / "synthetic.csv.gz")


@pytest.fixture(scope="session")
def synthetic(synthetic_path):
    flight = read_flight(synthetic_path)
    return flight, find_phases(flight)


@pytest.fixture(scope="session")
def shaken_flight(tmp_path_factory):
    return read_flight(record(tmp_path_factory.mktemp("shaken") / "shaken.csv.gz", course=shaken))


@pytest.fixture(scope="session")
def older_flight(tmp_path_factory):
    path = record(tmp_path_factory.mktemp("older") / "older.csv.gz", seconds=9.0, thrust_max=0.1125)
    flight = read_flight(path)
    return flight, find_phases(flight)


@pytest.fixture(scope="session")
def true_vehicle():
    return dict(TRUTH)


@pytest.fixture(scope="session")
def own_parameters():
    return dict(OWN)
