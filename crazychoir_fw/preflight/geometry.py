"""What drones know of base stations: the same for all of a mission, and enough to fly."""

from __future__ import annotations

import struct
import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from cflib.crazyflie.mem import LighthouseMemHelper, MemoryElement

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.preflight.check import Check, check

if TYPE_CHECKING:
    from crazychoir_fw.radio import RadioDrone
    from crazychoir_fw.simulation.drone import Drone

SAME_M = 0.01
"""Distance (m) of one base station in the memories of two drones, beyond which they do not fly in one room."""
_TIMEOUT_S = 5.0
_PAGE_BYTES = 0x100
_ORIGIN = struct.Struct("<3f36x?")

Stations = dict[int, np.ndarray]
"""Position (m, world) by number, shape (3,), of those that are known."""


def geometry(drones: Mapping[str, RadioDrone], likenesses: Mapping[str, Drone]) -> Check | None:
    """Return whether drones with the lighthouse deck know the same base stations.

    Args:
        drones: Those that the mission positions by lighthouse.
        likenesses: The same drones in a simulated world.

    Returns:
        None without such drones.
    """
    if not drones:
        return None
    known = {name: stations_of(drone) for name, drone in drones.items()}
    problems = [f"{name} knows no base station" for name, stations in known.items() if not stations]
    first = next((name for name, stations in known.items() if stations), None)
    if first is None:
        return check("geometry", problems, "")
    for name, stations in known.items():
        if stations and name != first and (why := difference(known[first], stations)) is not None:
            problems.append(f"{name} and {first} differ: {why}")
    why = difference(simulated_stations(likenesses[first]), known[first])
    places = "; ".join(f"{number}: ({x:.2f}, {y:.2f}, {z:.2f})" for number, (x, y, z) in known[first].items())
    told = "as simulated" if why is None else f"other than simulated ({why})"
    return check("geometry", problems, f"base stations {places}, {told}")


def difference(one: Stations, other: Stations) -> str | None:
    """Return in what two rooms differ, or None."""
    if one.keys() != other.keys():
        return f"base stations {_listed(one)} and {_listed(other)}"
    for number, at in one.items():
        away = float(np.linalg.norm(at - other[number]))
        if away > SAME_M:
            return f"base station {number} is {away:.2f} m away"
    return None


def _listed(stations: Stations) -> str:
    return ", ".join(map(str, stations)) or "none"


def simulated_stations(drone: Drone) -> Stations:
    """Return the base stations that a simulated drone knows."""
    found: Stations = {}
    page = ffi.new("uint8_t[]", _ORIGIN.size)
    for number in range(lib.CF_LIGHTHOUSE_STATIONS):
        kind = MemoryElement.TYPE_LH
        if lib.cf_read_memory(drone.struct, kind, number * _PAGE_BYTES, _ORIGIN.size, page) == lib.CF_OK:
            x, y, z, is_valid = _ORIGIN.unpack(bytes(page))
            if is_valid:
                found[number] = np.array([x, y, z])
    return found


def stations_of(drone: RadioDrone) -> Stations:
    """Return the base stations that a drone knows; none where it has no memory of them, or does not answer in time."""
    if len(drone.cf.mem.get_mems(MemoryElement.TYPE_LH)) != 1:
        return {}
    told: dict[int, Any] = {}
    is_read = threading.Event()

    def take(found: dict[int, Any]) -> None:
        told.update(found)
        is_read.set()

    LighthouseMemHelper(drone.cf).read_all_geos(take)
    if not is_read.wait(_TIMEOUT_S):
        return {}
    return {number: np.array(one.origin, float) for number, one in told.items() if one.valid}
