"""In which parts of their flights all drones are: arrays for a round, made anew only when a phase has changed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crazychoir_fw.flight.agent import Agent, DronePhase


class SwarmPhases:
    """The phases of agents, as of the last `look`; whoever holds an agent may set its phase."""

    def __init__(self, agents: Sequence[Agent]) -> None:
        """Take the agents, and look."""
        self._agents = list(agents)
        self._seen: list[DronePhase] | None = None
        self.look()

    def look(self) -> None:
        """Bring everything up to date."""
        phases = [agent.phase for agent in self._agents]
        if phases == self._seen:
            return
        self._seen = phases
        self.numbers = np.array([phase.number for phase in phases], float)
        """Their numbers in logs, shape (N,)."""
        self.turning = np.array([phase.has_motors_on for phase in phases], bool)
        """Whose motors turn, shape (N,)."""
        self.turning.flags.writeable = False  # everybody is given this one
        self.up = [agent for agent in self._agents if agent.is_up]
        """Whose motors turn."""
        self.is_anybody_landing = DronePhase.LANDING in phases
