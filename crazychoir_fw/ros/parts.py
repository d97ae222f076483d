"""Into which processes a mission falls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from crazychoir_fw.errors import MissionError
from crazychoir_fw.experiment import agents

LAYERS = ("guidance", "planning", "control")


@dataclass(frozen=True)
class Part:
    """What one process does: some layers of some drones."""

    name: str
    agents: tuple[int, ...]
    layers: tuple[str, ...]


def parts_of(mission: Any, processes: str) -> list[Part]:
    """Return the processes of a mission.

    Args:
        mission: The mission.
        processes: ``per-node``: one per drone and layer; ``per-drone``; ``one`` for all layers of all drones.
    """
    count = len(mission.fleet)
    if processes == "one":
        return [Part("layers", tuple(range(count)), LAYERS)]
    names = agents.names_of(mission)
    if processes == "per-drone":
        return [Part(names[i], (i,), LAYERS) for i in range(count)]
    return [Part(f"{names[i]}/{layer}", (i,), (layer,)) for i in range(count) for layer in layers_of_drone(mission, i)]


def layers_of_drone(mission: Any, i: int) -> list[str]:
    """Return which layers a drone has."""
    layers, name = mission.layers, mission.fleet[i].id
    has = {
        "guidance": True,
        "planning": layers.planning_of(name) is not None and agents.follows_trajectory(mission, i),
        "control": layers.control_of(name) is not None,
    }
    return [layer for layer in LAYERS if has[layer]]


def one_command(mission: Any) -> str:
    """Return what all drones are commanded by: fpqr, frpy, vel or xyz.

    Raises:
        MissionError: If they are commanded in different ways.
    """
    commands = mission.layers.commands
    if len(commands) > 1:
        raise MissionError(
            f"layers.control: drones are commanded by {', '.join(commands)}, but over ROS all must be alike"
        )
    return str(commands[0])
