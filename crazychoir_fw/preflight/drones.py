"""Drones over the radio, real ones or a served simulation, against the mission that they are to fly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from crazychoir_fw.common.errors import MissionError, StateError
from crazychoir_fw.flight.backends import READY_TIMEOUT, build_world
from crazychoir_fw.flight.real_drones import radio_parts
from crazychoir_fw.flight.roll_call import Part, problems_of
from crazychoir_fw.preflight import at_rest, parameters
from crazychoir_fw.preflight.check import Check, check, safety_area
from crazychoir_fw.preflight.firmware import decks, firmware_check, health_tests, self_tests
from crazychoir_fw.preflight.geometry import geometry
from crazychoir_fw.preflight.radio_load import radio_load
from crazychoir_fw.radio.supervisor import IS_FLYING, supervisor_bits

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission
    from crazychoir_fw.radio import RadioDrone
    from crazychoir_fw.simulation.drone import Drone

_PARAMETERS_S = 60.0
_ROLL_CALL = {
    "conditions": ("ready", "charged, and their motors may run"),
    "names": ("names", "the drones of the mission answer"),
    "mixture": ("kind", "all real, or all simulated"),
    "places": ("starts", "those of the mission"),
}


@dataclass(frozen=True)
class Findings:
    """What was found."""

    checks: list[Check]
    differences: list[parameters.Difference]
    """Parameters that drones have otherwise than the mission."""


def look_at(mission: LayeredMission, *, applies: bool = False, spins: bool = False) -> Findings:
    """Connect to the drones as a flight does, look at everything, and let them go.

    Args:
        mission: The mission, with the backend `hardware` or `mixed`.
        applies: Whether parameters that differ are set.
        spins: Whether motors are turned for the tests of propellers and battery.

    Raises:
        CrazychoirError: If drones or motion capture are not reached.
    """
    with ExitStack() as stack:
        world = build_world(mission, visuals=False)
        world.wait_until_ready(timeout_s=READY_TIMEOUT)
        parts = radio_parts(mission)
        if not parts:
            raise MissionError("no drone of the mission has a uri, so there is nothing to look at over the radio")
        for _, backend in parts:
            stack.callback(backend.close)
        return look(mission, parts, {drone.id: drone for drone in world.drones}, applies=applies, spins=spins)


def look(
    mission: LayeredMission,
    parts: Sequence[Part],
    likenesses: Mapping[str, Drone],
    *,
    applies: bool = False,
    spins: bool = False,
) -> Findings:
    """Look at drones that are connected; see `look_at`.

    Args:
        mission: The mission.
        parts: Numbers of drones, and the backend that they are connected by.
        likenesses: The same drones, simulated as in the mission.
        applies: Whether parameters that differ are set.
        spins: Whether motors are turned.

    Raises:
        StateError: If a drone flies.
        CrazychoirError: If a drone is lost, or takes no parameter.
    """
    drones = {mission.fleet[i].id: backend.handler[mission.fleet[i].id] for numbers, backend in parts for i in numbers}
    handlers = {mission.fleet[i].id: backend.handler for numbers, backend in parts for i in numbers}
    _refuse_flights(drones)
    wait = parts[0][1].wait_until
    wait(lambda: all(drone.cf.param.is_updated for drone in drones.values()), _PARAMETERS_S)
    found, line = _parameters(mission, drones, likenesses, applies)
    checks = [firmware_check(drones, likenesses), self_tests(drones), decks(drones, likenesses), line]
    checks += [check(*_titled(key, problems)) for key, problems in problems_of(mission, parts).items()]
    seen = at_rest.look([backend for _, backend in parts])
    checks.append(at_rest.positioning(seen, [backend.names for _, backend in parts]))
    checks += _around(mission, parts, drones, likenesses)
    checks += [at_rest.links(seen, drones), radio_load(mission, handlers)]
    if spins:
        checks += health_tests(drones, wait)
    return Findings(checks, found)


def _around(
    mission: LayeredMission, parts: Sequence[Part], drones: Mapping[str, RadioDrone], likenesses: Mapping[str, Drone]
) -> list[Check]:
    """Look at base stations, if drones see some, and at the safety area, if the mission has one."""
    swept = {one.id: drones[one.id] for one in mission.fleet if one.positioning == "lighthouse" and one.id in drones}
    rooms = geometry(swept, likenesses)
    found = [] if rooms is None else [rooms]
    area = mission.hardware.safety_area
    if area is not None:
        at = np.vstack([backend.true_positions() for _, backend in parts])
        found.append(safety_area(area, [name for _, backend in parts for name in backend.names], at))
    return found


def _refuse_flights(drones: Mapping[str, RadioDrone]) -> None:
    for name, drone in drones.items():
        bits = supervisor_bits(drone.cf)
        if bits is not None and bits & IS_FLYING:
            raise StateError(f"{name} flies, but only drones on the floor are looked at")


def _titled(key: str, problems: Sequence[str]) -> tuple[str, Sequence[str], str]:
    name, good = _ROLL_CALL[key]
    return name, problems, good


def _parameters(
    mission: LayeredMission, drones: Mapping[str, RadioDrone], likenesses: Mapping[str, Drone], applies: bool
) -> tuple[list[parameters.Difference], Check]:
    found: list[parameters.Difference] = []
    lacking: dict[str, list[str]] = {}
    for drone in mission.fleet:
        if drone.id not in drones:
            continue
        flown = drones[drone.id]
        options = mission.hardware.radio
        written = {
            *flown.presets,
            *options.get("parameters", {}),
            *options.get("agent_parameters", {}).get(drone.id, {}),
        }
        lacking[drone.id] = parameters.missing(flown, drone.parameters)
        differing = parameters.differences(drone.id, flown, likenesses[drone.id], drone.parameters, written)
        found += parameters.apply(flown, differing) if applies else differing
    return found, parameters.parameters_check(found, lacking)
