"""Faults as data: what goes wrong with which drone, when, and for how long.

One small file per kind; `schedule.py` puts them on the agenda of a world.
"""

from crazychoir_fw.simulation.faults.battery import BatteryFault
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.gust import Gust
from crazychoir_fw.simulation.faults.imu import ImuFault
from crazychoir_fw.simulation.faults.kick import Kick
from crazychoir_fw.simulation.faults.motor import MotorFault
from crazychoir_fw.simulation.faults.payload import PayloadDrop
from crazychoir_fw.simulation.faults.positioning import PositioningFault
from crazychoir_fw.simulation.faults.radio import RadioFault
from crazychoir_fw.simulation.faults.schedule import FaultSchedule

KINDS: dict[str, type[Fault]] = {
    kind.kind: kind
    for kind in (MotorFault, ImuFault, PositioningFault, RadioFault, BatteryFault, PayloadDrop, Kick, Gust)
}
"""Every kind of fault by its word in mission files and logs."""

__all__ = [
    "KINDS",
    "BatteryFault",
    "Fault",
    "FaultSchedule",
    "Gust",
    "ImuFault",
    "Kick",
    "MotorFault",
    "PayloadDrop",
    "PositioningFault",
    "RadioFault",
]
