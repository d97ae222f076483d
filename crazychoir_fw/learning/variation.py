"""How the drones of a task differ: the `vary:` block of a campaign file, drawn once per variant.

Keys are those of campaigns and of `--set` that speak of all drones: ``defaults.mass``, ``defaults.battery``,
``defaults.noise``, ``defaults.vehicle.rotors.thrust_scale``, ``defaults.vehicle.trim.torque[0]``,
``defaults.parameters.NAME``, ``defaults.attributes.NAME`` and ``wind.velocity``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.plain_yaml import read_yaml
from crazychoir_fw.mission.distributions import Distribution, read_distribution
from crazychoir_fw.onboard.vehicles import parameters
from crazychoir_fw.simulation import DroneConfig

_FIELDS = ("mass", "battery", "noise")
_GROUPS = ("parameters", "attributes")
_VEHICLE = re.compile(r"(?:defaults\.vehicle\.|(?=wind\.))(?P<name>[\w.]+)(?:\[(?P<axis>\d)\])?$")
_ALLOWED = (
    "defaults.mass, defaults.battery, defaults.noise, defaults.vehicle.NAME, defaults.parameters.NAME, "
    "defaults.attributes.NAME, wind.velocity"
)


def read_vary(given: str | Path | Mapping[str, Any]) -> dict[str, Distribution]:
    """Return the distributions of a `vary:` block.

    Args:
        given: The block, or the path of a campaign file that has one.

    Raises:
        RangeError: If the file has none, or a key is none that speaks of all drones.
        MissionError: If a distribution is none; the text says what is allowed.
    """
    if isinstance(given, str | Path):
        content = read_yaml(Path(given), RangeError)
        if not isinstance(content, Mapping) or not isinstance(content.get("vary"), Mapping):
            raise RangeError(f"vary: {given} has no block 'vary', allowed: a campaign file with one, or the block")
        given = content["vary"]
    if not isinstance(given, Mapping):
        raise RangeError(f"vary is {given!r}, allowed: a mapping from keys to distributions, or a campaign file")
    found = {str(key): read_distribution(f"vary.{key}", value) for key, value in given.items()}
    for key, distribution in found.items():
        _apply(DroneConfig("drone"), key, distribution.at(0.5))
    return found


def varied(base: DroneConfig, vary: Mapping[str, Distribution], number: int, seed: int) -> dict[str, Any]:
    """Return the fields of a drone in which variant `number` differs from `base`.

    As in a campaign of design ``monte_carlo``, what a variant draws depends on seed and number alone.
    """
    shares = np.random.default_rng((seed, number)).random(len(vary))
    changed = DroneConfig(**{**vars(base), "vehicle": _plain(base.vehicle)})
    for (key, distribution), share in zip(vary.items(), shares, strict=True):
        _apply(changed, key, distribution.at(float(share)))
    return vars(changed)


def _plain(vehicle: Any) -> dict[str, Any]:
    from crazychoir_fw.onboard import vehicles

    return dict(vehicles.overrides(vehicle)) if vehicle else {}


def _apply(drone: DroneConfig, key: str, value: Any) -> None:
    """Set what a key names.

    Raises:
        RangeError: If it names nothing of a drone.
    """
    match key.split(".", 2):
        case ["defaults", field] if field in _FIELDS:
            setattr(drone, field, value)
            return
        case ["defaults", group, name] if group in _GROUPS:
            setattr(drone, group, {**getattr(drone, group), name: value})
            return
    found = _VEHICLE.match(key)
    table = parameters(drone.platform)
    if found is None or found["name"] not in table:
        raise RangeError(f"vary names '{key}', allowed: {_ALLOWED}")
    vehicle = dict(drone.vehicle)  # type: ignore[arg-type]
    if found["axis"] is None:
        vehicle[found["name"]] = value
    else:
        whole = list(vehicle.get(found["name"], table[found["name"]].value))  # type: ignore[arg-type]
        if int(found["axis"]) >= len(whole):
            raise RangeError(f"vary names '{key}', allowed: [0] to [{len(whole) - 1}]")
        whole[int(found["axis"])] = float(value)
        vehicle[found["name"]] = tuple(whole)
    drone.vehicle = vehicle
