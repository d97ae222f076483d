"""Drones over the radio, simulated and real, through the official cflib: `RadioHandler` and its family."""

from crazychoir_fw.onboard.thrust import ThrustCalibration
from crazychoir_fw.radio import crazyflie  # noqa: F401 (first: its error says what to install)
from crazychoir_fw.radio.connection import ReconnectPolicy
from crazychoir_fw.radio.drone import RadioDrone
from crazychoir_fw.radio.handler import RadioHandler
from crazychoir_fw.radio.link import LinkState
from crazychoir_fw.radio.logs import LogValue
from crazychoir_fw.radio.modes import Mode
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.poses import Odometry
from crazychoir_fw.radio.safety_area import SafetyArea
from crazychoir_fw.radio.thrust_commands import RadioHandlerFPQR, RadioHandlerFRPY
from crazychoir_fw.radio.vel import RadioHandlerVel, RadioHandlerVelLightHouse
from crazychoir_fw.radio.xyz import RadioHandlerXYZ, RadioHandlerXYZLightHouse

__all__ = [
    "LinkState",
    "LogValue",
    "Mode",
    "Odometry",
    "Options",
    "RadioDrone",
    "RadioHandler",
    "RadioHandlerFPQR",
    "RadioHandlerFRPY",
    "RadioHandlerVel",
    "RadioHandlerVelLightHouse",
    "RadioHandlerXYZ",
    "RadioHandlerXYZLightHouse",
    "ReconnectPolicy",
    "SafetyArea",
    "ThrustCalibration",
]
