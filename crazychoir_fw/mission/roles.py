"""What a mission says of each drone: its name, start and mass, its guidance, its place, and what it follows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw import guidance, planning
from crazychoir_fw.guidance.law import LawContext
from crazychoir_fw.guidance.metrics import Metrics
from crazychoir_fw.mission.communicators import graph_of
from crazychoir_fw.mission.factory import class_of

if TYPE_CHECKING:
    from crazychoir_fw.mission.layers import GuidanceLayer
    from crazychoir_fw.mission.schema import LayeredMission


def names_of(mission: LayeredMission) -> list[str]:
    """Return the names of all drones."""
    return [drone.id for drone in mission.fleet]


def starts_of(mission: LayeredMission) -> NDArray[np.float64]:
    """Return where the drones start (m, world), shape (N, 3)."""
    return np.array([(*drone.position, 0.0)[:3] for drone in mission.fleet])


def guidance_of(mission: LayeredMission, i: int) -> GuidanceLayer:
    """Return what the mission says about the guidance of a drone."""
    return mission.layers.guidance_of(mission.fleet[i].id)


def formation_of(mission: LayeredMission, i: int = 0) -> NDArray[np.float64] | None:
    """Return the formation of a drone (m), shape (N, 3), if there is one; drones of other guidance are at 0."""
    layer = guidance_of(mission, i)
    if layer.formation is None:
        return None
    names = names_of(mission)
    members = names if layer.drones is None else layer.drones
    chosen = layer.formation if isinstance(layer.formation, list) else layer.formation.of(len(members))
    places = np.zeros((len(names), 3))
    for name, place in zip(members, chosen, strict=True):
        places[names.index(name)] = place if len(place) == 3 else (*place, layer.height)
    return places


def leads(mission: LayeredMission, i: int) -> bool:
    """Tell whether a drone leads the formation."""
    return mission.fleet[i].id in guidance_of(mission, i).leaders


def follows_trajectory(mission: LayeredMission, i: int) -> bool:
    """Tell whether a drone follows the references of a trajectory handler, and not those of its guidance."""
    layers, name = mission.layers, mission.fleet[i].id
    if layers.planning_of(name) is None:
        return layers.control_of(name) is None
    return leads(mission, i) or not guidance_class(mission, i).references_itself


def is_only_watched(mission: LayeredMission, i: int) -> bool:
    """Tell whether no part of this process commands a drone, because only motion capture knows it."""
    drone = mission.fleet[i]
    return mission.backend == "mixed" and drone.uri is None and drone.mocap is not None


def takeoff_time_of(mission: LayeredMission) -> float:
    """Return the time of the take-off (s): that of the first button."""
    for order in (order for phase in mission.flight for order in phase.orders):
        if order.name == "takeoff" and order.maneuver.duration > 0.0:
            return float(order.maneuver.duration)
    return 5.0


def team_of(mission: LayeredMission, i: int) -> list[int]:
    """Return the numbers of all drones with the guidance of a drone."""
    layer, names = guidance_of(mission, i), names_of(mission)
    return list(range(len(names))) if layer.drones is None else [names.index(name) for name in layer.drones]


def masses_of(mission: LayeredMission) -> list[float]:
    """Return what the vehicles of a mission weigh, as far as their file tells (kg)."""
    from crazychoir_fw.simulation.integrator.platforms import platform_mass

    masses = []
    for drone in mission.fleet:
        mass = platform_mass(drone.platform) if drone.mass is None else drone.mass
        masses.append(mass + (float(drone.payload["mass"]) if drone.payload else 0.0))
    return masses


def guidance_class(mission: LayeredMission, i: int = 0) -> type[guidance.CFGuidance]:
    """Return the class of the guidance of a drone."""
    return guidance_of(mission, i).law(mission.layers.path_of(mission.fleet[i].id) + ".class")


def options_of_drone(mission: LayeredMission, i: int) -> dict[str, Any]:
    """Return the options that the mission sets for the guidance of a drone."""
    layer = guidance_of(mission, i)
    return {**layer.options, **layer.options_by_drone.get(mission.fleet[i].id, {})}


def context_of(mission: LayeredMission, number: int) -> LawContext:
    """Return what the mission says of the drones of an entry of guidance."""
    layer, names = mission.layers.guidances[number], names_of(mission)
    members = tuple(range(len(names))) if layer.drones is None else tuple(map(names.index, layer.drones))
    return LawContext(
        guidance_class(mission, members[0]),
        tuple(names),
        members,
        graph_of(mission),
        tuple(i for i in members if leads(mission, i)),
        formation_of(mission, members[0]),
        layer.height,
        {i: options_of_drone(mission, i) for i in members},
    )


def metrics_of(mission: LayeredMission) -> list[Metrics]:
    """Return how a flight is judged and drawn, by what its laws say of themselves."""
    found: dict[Any, Metrics | None] = {}
    for number, layer in enumerate(mission.layers.guidances):
        law = layer.law()
        if law.metrics.scope == "alone" and len(mission.layers.guidances) > 1:
            continue
        key = law.metrics if law.metrics.scope == "swarm" else number
        if key not in found:
            found[key] = law.metrics.of(context_of(mission, number))
    return [one for one in found.values() if one is not None]


def what_it_follows(mission: LayeredMission, i: int) -> str:
    """Return what the references of a drone consist of: acceleration, position or fullstate."""
    if not follows_trajectory(mission, i):
        return str(guidance_class(mission, i).kind)
    name = mission.fleet[i].id
    layer = mission.layers.planning_of(name)
    if layer is None:
        return "fullstate"
    key = mission.layers.path_of(name, "planning")
    return str(class_of(layer, "planning", f"{key}.class", layer.kind, planning.TrajectoryHandler).kind)
