"""Between the clients of a mission and its drones: simulated Crazyradios, or perfect links."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crazychoir_fw.crtp.link_model import Link, SimulatedRadios
    from crazychoir_fw.mission.schema import Mission


def make_link(mission: Mission, seed: int | None = None) -> Link:
    """Return the radios of a mission; a `PerfectLink` when it has none.

    Args:
        mission: The mission.
        seed: Seed of losses and delays; by default that of the mission.
    """
    from crazychoir_fw.crtp.link_model import PerfectLink

    return simulated_radios(mission, seed) or PerfectLink()


def simulated_radios(mission: Mission, seed: int | None = None) -> SimulatedRadios | None:
    """Return the radios of a mission, if it has any."""
    if not mission.radios:
        return None
    from crazychoir_fw.crtp.link_model import SimulatedRadios

    drones = [drone.id for drone in mission.fleet]
    return SimulatedRadios(mission.radios, drones, mission.seed if seed is None else seed)
