"""Mass and rotor drag of the airframes, for an integrator without onboard software."""

from __future__ import annotations

from crazychoir_fw._core import lib
from crazychoir_fw.onboard.core import platform_names

_DRAG = {
    "cf2": (0.01351483, 0.01351483, 0.01677452),
    "cf21bl": (0.02149163, 0.02149163, 0.02359736),
}
"""Linear drag along body x, y, z (N s/m): flight fits of docs/reference/vehicle.md#7."""


def platform_mass(platform: str) -> float:
    """Return the mass that the onboard software of an airframe believes in (kg)."""
    return float(lib.cf_platform_facts(platform_names().index(platform)).mass)


def platform_drag(platform: str) -> tuple[float, float, float]:
    """Return the drag of an airframe along body x, y, z (N s/m)."""
    return _DRAG[platform]
