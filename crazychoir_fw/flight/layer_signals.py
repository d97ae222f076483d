"""What the layers of a swarm say, as signals of its log."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.flight.agent import Agent, SwarmPhases

Array = NDArray[np.float64]

_NAMES = tuple(
    f"layers.{name}"
    for name in ("x", "y", "z", "ax", "ay", "az", "command1", "command2", "command3", "command4", "phase")
)
_PLACES, _ACCELERATIONS, _COMMANDS, _PHASE = slice(0, 3), slice(3, 6), slice(6, 10), 10


class LayerSignals(Stateful):
    """Signals of the references, commands and phases of N drones."""

    unkept = ("_said", "_by_name")

    def __init__(self, agents: Sequence[Agent], phases: SwarmPhases) -> None:
        """Take the drones, and their phases as arrays."""
        self._phases = phases
        self._placed = [agent for agent in agents if _follows_places(agent)] or list(agents)
        self._said = np.full((len(_NAMES), len(agents)), np.nan)
        self._by_name = dict(zip(_NAMES, self._said, strict=True))

    def now(self, accelerations: Array, commands: Array) -> dict[str, Array]:
        """Return the signals of this instant by name, shape (N,) each, in arrays that the next call uses again.

        Args:
            accelerations: What guidance asks for (m/s^2, world), shape (N, 3).
            commands: Four numbers for each drone, shape (N, 4).
        """
        said, turning = self._said, self._phases.turning
        said[: _COMMANDS.start] = np.nan
        np.copyto(said[_ACCELERATIONS], accelerations.T, where=turning)
        for agent in self._placed:
            reference, i = agent.reference, agent.index
            if reference is None or not turning[i]:
                continue
            if reference.position is not None:
                said[_PLACES, i] = reference.position
            if reference.acceleration is not None:
                said[_ACCELERATIONS, i] = reference.acceleration
        said[_COMMANDS] = commands.T
        said[_PHASE] = self._phases.numbers
        return self._by_name


def _follows_places(agent: Agent) -> bool:
    """Return whether a drone follows places: those of a trajectory handler, or of guidance itself."""
    return agent.planner is not None or getattr(agent.guidance, "kind", "acceleration") != "acceleration"
