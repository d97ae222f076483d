"""Every parameter of real drones against those that the same drones of a simulated world have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from cflib.crazyflie.param import ParamTocElement

from crazychoir_fw.onboard.variables import parameter_table
from crazychoir_fw.preflight.check import Check, check
from crazychoir_fw.radio.parameters import element_of, set_parameters

if TYPE_CHECKING:
    from crazychoir_fw.radio import RadioDrone
    from crazychoir_fw.simulation.drone import Drone

_OF_NO_FLIGHT = (
    "colorLedBot",
    "colorLedTop",
    "cpu",
    "health",
    "led",
    "led_deck_ctrl",
    "memTst",
    "ring",
    "sound",
    "system",
)
"""Groups of lights and sounds, tests, and the chip."""
_ACTS = ("kalman.resetEstimation", "lighthouse.bsCalibReset", "stabilizer.stop", "supervisor.infdmp")
"""What acts when it is written, and is no setting."""
_OF_THE_UNIT = ("imu_sensors.imuPhi", "imu_sensors.imuTheta", "imu_sensors.imuPsi")
"""How the sensors of one unit sit on its board."""
_PLACE = tuple(f"kalman.initial{axis}" for axis in ("X", "Y", "Z", "Yaw"))
"""Where an estimate begins: only drones without a positioning system stay with that."""
_ROUNDING = 1e-6
_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class Difference:
    """A parameter that a drone has otherwise than the mission."""

    drone: str
    name: str
    found: float
    """What the drone has."""
    wanted: float
    """What flew when the mission was simulated."""
    is_persistent: bool
    """Whether the drone can keep it when it is switched off."""
    is_asked: bool
    """Whether the mission names it."""
    is_applied: bool = False
    """Whether it was set to what is wanted."""


def differences(
    id_: str, drone: RadioDrone, likeness: Drone, asked: Mapping[str, float], written: Iterable[str]
) -> list[Difference]:
    """Return the parameters in which a drone is not the one of the mission.

    Args:
        id_: Its name in the mission.
        drone: The drone over the radio.
        likeness: The same drone in a simulated world.
        asked: Parameters that the mission names.
        written: Those that every flight over the radio writes itself.
    """
    toc = drone.cf.param.toc
    omitted = {*_ACTS, *_OF_THE_UNIT, *written}
    if likeness.config.positioning not in ("none", "flow"):
        omitted |= set(_PLACE)
    found = []
    for name in parameter_table(likeness.provider_number):
        element = element_of(toc, name)
        if element is None or element.access == ParamTocElement.RO_ACCESS:
            continue
        if name in omitted or name.partition(".")[0] in _OF_NO_FLIGHT:
            continue
        here, wanted = float(drone.get_parameter(name)), float(likeness.param[name])
        if not np.isclose(here, wanted, rtol=_ROUNDING, atol=0.0, equal_nan=True):
            found.append(Difference(id_, name, here, wanted, bool(element.is_persistent()), name in asked))
    return found


def missing(drone: RadioDrone, asked: Iterable[str]) -> list[str]:
    """Return which parameters of a mission a drone does not have."""
    return [name for name in asked if element_of(drone.cf.param.toc, name) is None]


def apply(drone: RadioDrone, found: Sequence[Difference]) -> list[Difference]:
    """Set what differs, until the drone is switched off; returns the differences, marked as applied.

    Raises:
        CrazychoirError: If the drone does not take or confirm a value.
    """
    who = f"{drone.agent_id} ({drone.uri})"
    values: dict[str, Any] = {one.name: int(one.wanted) if one.wanted.is_integer() else one.wanted for one in found}
    set_parameters(drone.cf, who, values, _TIMEOUT_S)
    return [replace(one, is_applied=True) for one in found]


def parameters_check(found: Sequence[Difference], lacking: Mapping[str, Sequence[str]]) -> Check:
    """Return the line about all drones.

    Args:
        found: All differences.
        lacking: By drone, parameters of the mission that it does not have.
    """
    problems = [f"{drone} has no {', '.join(names)}" for drone, names in lacking.items() if names]
    by_drone: dict[str, list[str]] = {}
    for one in found:
        if not one.is_applied:
            by_drone.setdefault(one.drone, []).append(one.name)
    for drone, names in by_drone.items():
        problems.append(f"{drone} differs in {', '.join(names[:3])}{f' and {len(names) - 3} more' * (len(names) > 3)}")
    good = f"as in the mission, {len(found)} set now" if found else "as in the mission"
    return check("parameters", problems, good)
