"""From a mission to the agents of its drones: one process builds them all here, ROS processes one each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw import guidance, planning
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.flight.control_laws import GRAVITY
from crazychoir_fw.flight.controllers import make_controller, make_groups
from crazychoir_fw.flight.safety_filters import make_collision_avoidance, make_safety_filter, make_sensing
from crazychoir_fw.guidance.gains import FORMATION_GAINS, FormationGains
from crazychoir_fw.guidance.graph import NeighborSchedule
from crazychoir_fw.guidance.law import arguments_of
from crazychoir_fw.mission.communicators import graph_of, make_communicators, schedule_of
from crazychoir_fw.mission.factory import build, changed_gains, class_of
from crazychoir_fw.mission.roles import (
    follows_trajectory,
    formation_of,
    guidance_class,
    guidance_of,
    is_only_watched,
    leads,
    masses_of,
    metrics_of,
    names_of,
    options_of_drone,
    starts_of,
    takeoff_time_of,
    team_of,
    what_it_follows,
)

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission

__all__ = [
    "GRAVITY",
    "follows_trajectory",
    "formation_of",
    "graph_of",
    "guidance_class",
    "guidance_of",
    "is_only_watched",
    "leads",
    "make_agents",
    "make_collision_avoidance",
    "make_controller",
    "make_groups",
    "make_guidance",
    "make_safety_filter",
    "make_sensing",
    "make_trajectory_handler",
    "masses_of",
    "metrics_of",
    "names_of",
    "schedule_of",
    "starts_of",
    "takeoff_time_of",
    "team_of",
    "what_it_follows",
]


def make_guidance(mission: LayeredMission, i: int, communicator: Any, schedule: NeighborSchedule | None = None) -> Any:
    """Return what decides for one drone.

    Args:
        mission: The mission.
        i: Its number.
        communicator: How it talks to others.
        schedule: Its neighbors, if they change.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    layer, name = guidance_of(mission, i), mission.fleet[i].id
    cls, key = guidance_class(mission, i), mission.layers.path_of(name)
    arguments: dict[str, Any] = {
        "agent_id": i,
        "communicator": communicator,
        "init_pos": starts_of(mission)[i],
        "height": layer.height,
        "takeoff_time": takeoff_time_of(mission),
        "update_frequency": float(mission.layers.rate),
        "is_leader": leads(mission, i),
        "deadline": mission.layers.communication_of(name).deadline_s,
        "silence": mission.layers.communication_of(name).silence_s,
    }
    if schedule is not None:
        arguments["schedule"] = schedule
    formation = formation_of(mission, i)
    if formation is not None:
        arguments["formation"] = formation
    if layer.gains is not None:
        arguments["gains"] = layer.gains if isinstance(layer.gains, str) else _formation_gains(key, layer.gains)
    if mission.layers.delivery is not None:
        arguments["slots"] = len(mission.layers.delivery.requests)
    if layer.goals is not None:
        arguments["goals"] = [tuple(row) for row in layer.goals.get(name, [])]
    asked = arguments_of(cls)
    if "graph" in asked:
        arguments["graph"] = graph_of(mission)
    if "team" in asked:
        arguments["team"] = team_of(mission, i)
    # those of a formation are distances
    if "weights" in asked and "formation" not in asked and graph_of(mission).is_undirected:
        arguments["weights"] = graph_of(mission).metropolis_hastings()[i].tolist()
    return build(cls, key, arguments, options_of_drone(mission, i))


def _formation_gains(key: str, given: Mapping[str, Any]) -> Any:
    """Return a set of formation gains that differs from another one."""
    return changed_gains(f"{key}.gains", given, FORMATION_GAINS, FormationGains, "webots")


def make_trajectory_handler(mission: LayeredMission, i: int) -> Any:
    """Return what plans for one drone, or None for one that follows no trajectory of ours.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    name = mission.fleet[i].id
    layer, key = mission.layers.planning_of(name), mission.layers.path_of(name, "planning")
    if layer is None or not follows_trajectory(mission, i):
        return None
    cls = class_of(layer, "planning", f"{key}.class", layer.kind, planning.TrajectoryHandler)
    return build(cls, key, {"update_frequency": float(mission.layers.rate)}, layer.options)


def make_agents(
    mission: LayeredMission, clock: Callable[[], float], positions: Callable[[], NDArray[np.float64]] | None = None
) -> list[Agent]:
    """Return guidance and trajectory handler of every drone, talking to each other in this process.

    Args:
        mission: The mission.
        clock: Time of the backend (s).
        positions: Returns where all drones are (m, world), shape (N, 3), for graphs that depend on it.

    Raises:
        CrazychoirError: If one cannot be made as the mission says; the message names key and drone.
    """
    schedule = schedule_of(mission, clock(), positions)
    communicators = make_communicators(mission, guidance.InProcessTransport(), clock, schedule=schedule)
    agents = []
    for i, name in enumerate(names_of(mission)):
        is_watched = is_only_watched(mission, i)
        planner = None if is_watched else make_trajectory_handler(mission, i)
        agents.append(Agent(i, name, make_guidance(mission, i, communicators[i], schedule), planner, is_watched))
    return agents
