"""Worlds of MuJoCo in which Crazyflies fly with their own onboard software."""

from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.episodes import Episodes
from crazychoir_fw.simulation.faults import (
    BatteryFault,
    Fault,
    Gust,
    ImuFault,
    Kick,
    MotorFault,
    PayloadDrop,
    PositioningFault,
    RadioFault,
)
from crazychoir_fw.simulation.motor_ctrl import MotorCtrl, MotorCtrlFPQR, MotorCtrlFRPY, MotorCtrlVel, MotorCtrlXYZ
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.replay import replay
from crazychoir_fw.simulation.snapshot import Snapshot
from crazychoir_fw.simulation.world import World, set_threads

__all__ = [
    "BatteryFault",
    "Drone",
    "DroneConfig",
    "Episodes",
    "Fault",
    "FlightRecorder",
    "Gust",
    "ImuFault",
    "Kick",
    "MotorCtrl",
    "MotorCtrlFPQR",
    "MotorCtrlFRPY",
    "MotorCtrlVel",
    "MotorCtrlXYZ",
    "MotorFault",
    "PayloadDrop",
    "PositioningFault",
    "RadioFault",
    "Snapshot",
    "World",
    "replay",
    "set_threads",
]
