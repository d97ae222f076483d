"""The processes that a mission is split into."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight import agents

LAYERS = ("guidance", "planning", "control", "avoidance")
SENSING = "sensing"
"""Layer of one process for all drones: finds the neighbors of each drone."""
TABLE = "table"
"""Layer of no drone: the table of tasks or requests."""


@dataclass(frozen=True)
class Part:
    """The layers and drones of one process."""

    name: str
    agents: tuple[int, ...]
    layers: tuple[str, ...]


def parts_of(mission: Any, processes: str) -> list[Part]:
    """Return the processes of a mission.

    Args:
        mission: The mission.
        processes: ``per-node``: one per drone and layer; ``per-drone``; ``one``: all layers run in
            the process of the drones, and no other process is returned.
    """
    everybody = tuple(range(len(mission.fleet)))
    common = common_layers(mission)
    if processes == "one":
        return []
    names = agents.names_of(mission)
    shared = [Part(layer, everybody if layer == SENSING else (), (layer,)) for layer in common]
    if processes == "per-drone":
        return [*(Part(names[i], (i,), LAYERS) for i in everybody), *shared]
    single = [Part(f"{names[i]}/{layer}", (i,), (layer,)) for i in everybody for layer in layers_of_drone(mission, i)]
    return [*single, *shared]


def common_layers(mission: Any) -> list[str]:
    """Return the layers that one process runs for all drones."""
    return [*([SENSING] if mission.layers.safety is not None else []), *([TABLE] if has_table(mission) else [])]


def has_table(mission: Any) -> bool:
    """Return whether guidance works for a table, which is a node of its own."""
    return mission.layers.tasks is not None or mission.layers.delivery is not None


def layers_of_drone(mission: Any, i: int) -> list[str]:
    """Return which layers a drone has."""
    layers, name = mission.layers, mission.fleet[i].id
    has = {
        "guidance": True,
        "planning": layers.planning_of(name) is not None and agents.follows_trajectory(mission, i),
        "control": layers.control_of(name) is not None,
        "avoidance": agents.make_collision_avoidance(mission) is not None,
    }
    return [layer for layer in LAYERS if has[layer]]


def reference_answers(mission: Any, i: int) -> bool:
    """Return whether in lockstep the reference of a drone answers its step: there is one a step, from its guidance."""
    is_disturbed = mission.layers.communication_of(mission.fleet[i].id).is_disturbed
    return (
        "control" in layers_of_drone(mission, i) and "planning" not in layers_of_drone(mission, i) and not is_disturbed
    )


def one_command(mission: Any) -> str:
    """Return the command of all drones: fpqr, frpy, vel or xyz.

    Raises:
        MissionError: If they are commanded in different ways.
    """
    commands = mission.layers.commands
    if len(commands) > 1:
        raise MissionError(
            f"layers.control: drones are commanded by {', '.join(commands)}, but over ROS all must be alike"
        )
    return str(commands[0])
