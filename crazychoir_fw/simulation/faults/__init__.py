"""Faults as data: what goes wrong with which drone, when, and for how long.

`schedule.py` puts them on the agenda of a world.
"""

from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.kinds import (
    BatteryFault,
    Gust,
    ImuFault,
    Kick,
    MotorFault,
    PayloadDrop,
    PositioningFault,
)
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
