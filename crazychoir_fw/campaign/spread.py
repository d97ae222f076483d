"""How flights of one mission differ where a campaign does not say: the spread of real vehicles, by platform.

Widths are those that the vehicle files call likely, with their sources (`crazychoir vehicle cf2`); how people place
drones and what batteries they fly with are choices of this module, each named so.
"""

from __future__ import annotations

from dataclasses import dataclass

from crazychoir_fw.mission.distributions import Distribution
from crazychoir_fw.mission.schema import Mission
from crazychoir_fw.onboard.vehicles import parameters

VEHICLE = (
    "rotors.thrust_scale",
    "rotors.efficiency",
    "rotors.time_constant_up",
    "trim.torque",
    "battery.resistance",
    "flight_moment.x",
    "flight_moment.y",
)
"""Parameters of vehicles that vary, where their platform says within which range."""

_YAW_TRIM = 0.17
"""Trim about the vertical axis, of that about the others (NANO: up to 1e-3 in roll and pitch, 1.7e-4 in yaw)."""

MASS_SHARE = 0.02
PLACE_M = 0.02
HEADING_DEG = 3.0
LEAST_CHARGE = 0.85


@dataclass(frozen=True)
class Varied:
    """A value that differs from flight to flight."""

    key: str
    """Key path, as `--set` takes it; the last key of a path into a list of numbers has its place, such as ``[0]``."""
    distribution: Distribution
    source: str = ""
    """Where the width comes from."""


def default_spread(mission: Mission) -> list[Varied]:
    """Return what varies of a mission that does not say: vehicles, mass, charge, places and headings of each drone."""
    found: list[Varied] = []
    for number, drone in enumerate(mission.fleet):
        where = f"drones[{number}]"
        found += _vehicle(where, drone.platform)
        mass = drone.mass if drone.mass is not None else float(parameters(drone.platform)["mass"].value)  # type: ignore[arg-type]
        found += [
            Varied(f"{where}.mass", _normal(mass, MASS_SHARE * mass), "choice: 2 %, battery and deck vary by that"),
            Varied(f"{where}.battery", Distribution("uniform", (LEAST_CHARGE, 1.0)), "choice: packs just charged"),
            Varied(f"{where}.position[0]", _normal(drone.position[0], PLACE_M), "choice: placed by hand"),
            Varied(f"{where}.position[1]", _normal(drone.position[1], PLACE_M), "choice: placed by hand"),
            Varied(f"{where}.yaw_deg", _normal(drone.yaw_deg, HEADING_DEG), "choice: placed by hand"),
        ]
    return found


def _vehicle(where: str, platform: str) -> list[Varied]:
    found = []
    table = parameters(platform)
    for name in VEHICLE:
        parameter = table[name]
        if parameter.likely is None:
            continue
        for axis in range(parameter.size):
            low, high = parameter.likely
            if name == "trim.torque" and axis == 2:
                low, high = _YAW_TRIM * low, _YAW_TRIM * high
            place = f"[{axis}]" if parameter.size > 1 else ""
            found.append(
                Varied(f"{where}.vehicle.{name}{place}", Distribution("uniform", (low, high)), parameter.source)
            )
    return found


def _normal(mean: float, std: float) -> Distribution:
    return Distribution("normal", (float(mean), std), low=mean - 3.0 * std, high=mean + 3.0 * std)
