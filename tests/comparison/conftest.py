"""A simulated flight, and its log in every format that `crazychoir compare` reads."""

import csv

import numpy as np
import pytest
import yaml

from crazychoir_fw.comparison.usd_log import write_usd
from crazychoir_fw.recording.mcap_file import write_mcap
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.recorder import FlightRecorder

MISSION = {
    "name": "wave",
    "seed": 5,
    "drones": [{"id": "cf1", "position": [0.2, -0.1], "battery": 0.9}],
    "flight": [
        {"takeoff": {"height": 0.8, "duration": 2.0}},
        {"hover": {"duration": 2.0}},
        {"land": {"duration": 2.0}},
    ],
}

ONBOARD = (
    *(f"stateEstimate.{name}" for name in ("x", "y", "z", "vx", "vy", "vz", "roll", "pitch", "yaw")),
    *(f"ctrltarget.{name}" for name in ("x", "y", "z", "yaw")),
    *(f"motor.m{k}" for k in (1, 2, 3, 4)),
    *(f"controller.{name}" for name in ("roll", "pitch", "yaw", "cmd_thrust")),
    *(f"gyro.{axis}" for axis in "xyz"),
    "pm.vbat",
)
"""What a script with cflib would log."""


def target(time):
    """Where the drone is to be: take-off, hover, waves."""
    share = np.clip(time / 2.0, 0.0, 1.0)
    climb = 0.1 + 0.7 * share**2 * (3 - 2 * share)
    phase = max(time - 4.0, 0.0)
    return 0.2 + 0.3 * np.sin(0.9 * phase), -0.1 + 0.3 * (1 - np.cos(0.9 * phase)), climb


@pytest.fixture(scope="session")
def log():
    """The flight as we record it."""
    drone = MISSION["drones"][0]
    config = DroneConfig("cf1", position=tuple(drone["position"]), battery=drone["battery"])
    world = World([config], visuals=False, seed=MISSION["seed"])
    world.wait_until_ready()
    recorder = FlightRecorder(world)
    for row in range(1150):
        if row >= 50:
            world.drones[0].commander.send_position_setpoint(*target((row - 50) / 100), 0.0)
        world.step(10)
        recorder.sample()
    return recorder.finish({"mission": "wave"})


@pytest.fixture
def columns(log):
    """The onboard log, (T,) each."""
    return {name: log.signals[name][:, 0].astype(float) for name in ONBOARD}


@pytest.fixture
def mission_file(tmp_path):
    """The mission of the flight."""
    path = tmp_path / "wave.yaml"
    path.write_text(yaml.safe_dump(MISSION))
    return path


def write_csv(path, log, columns):
    """Write what a script with cflib writes: milliseconds, and a column per log variable."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["timestamp", *columns])
        for time, *row in zip(np.rint(1000 * log.time).astype(int), *columns.values(), strict=True):
            writer.writerow([time, *row])
    return path


def write_rosbag2(path, mcap):
    """Write the messages of an MCAP file as a rosbag2 of SQLite."""
    from mcap.reader import make_reader
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_JAZZY)
    connections = {}
    with mcap.open("rb") as file, Writer(path, version=9) as writer:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.topic not in connections:
                connections[channel.topic] = writer.add_connection(channel.topic, schema.name, typestore=types)
            writer.write(connections[channel.topic], message.log_time, message.data)
    return path


@pytest.fixture
def as_csv(tmp_path, log):
    """Writes columns as a script with cflib does, by default those of the flight."""

    def write(columns, of=log, name="f.csv"):
        return write_csv(tmp_path / name, of, columns)

    return write


@pytest.fixture
def file_of(tmp_path, log, columns):
    """Writes the flight in a format."""

    def write(kind):
        path = tmp_path / f"flight.{kind}"
        if kind == "csv":
            return write_csv(path, log, columns)
        if kind == "npz":
            log.save(path)
        elif kind == "usd":
            path = tmp_path / "log07"
            write_usd(path, "fixedFrequency", log.time, columns)
        else:
            mcap = tmp_path / "flight.mcap"
            write_mcap(log, mcap)
            return mcap if kind == "mcap" else write_rosbag2(path, mcap)
        return path

    return write
