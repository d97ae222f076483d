"""Worlds of MuJoCo in which Crazyflies fly with their own onboard software."""

from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.drone_config import DroneConfig
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
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.world import World, set_threads

__all__ = [
    "BatteryFault",
    "Drone",
    "DroneConfig",
    "Fault",
    "FlightRecorder",
    "Gust",
    "ImuFault",
    "Kick",
    "MotorFault",
    "PayloadDrop",
    "PositioningFault",
    "RadioFault",
    "World",
    "set_threads",
]
