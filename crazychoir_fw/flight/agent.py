"""One drone as the layers see it: what decides and plans for it, and in which part of its flight it is."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint

_PHASE = attrgetter("phase")
_FLOOR_M = 0.1  # what starts higher does not start on a floor


class DronePhase(enum.Enum):
    """Where in its flight a drone is."""

    GROUND = "ground"
    """Motors off, before its first button."""
    FLYING = "flying"
    LANDING = "landing"
    LANDED = "landed"
    """Motors off again."""
    FAILED = "failed"
    """Motors off for good."""
    STOPPED = "stopped"
    """Motors off by the STOP button, wherever the drone was."""

    def __init__(self, word: str) -> None:
        """Count the phases; thirty drones ask a hundred times per second, and hashing a member is slow."""
        del word
        self.number = len(type(self).__members__)
        """Number in logs, from 0."""
        self.has_motors_on = self.number in (1, 2)


class Planner(Protocol):
    """What turns points into references: a trajectory handler of the planning layer."""

    kind: str

    def set_trajectory(self, points: list[TrajectoryPoint], pose: Pose, now: float) -> None:
        """Plan from a pose through points."""

    def evaluate(self, now: float) -> Reference | None:
        """Return the present reference."""

    def is_active(self, now: float) -> bool:
        """Tell whether the trajectory has not ended."""


@dataclass
class Agent(Stateful):
    """The layers of one drone but for its controller, which may be shared with others."""

    index: int
    """Number of the drone."""
    name: str
    guidance: Any
    """What decides; see `crazychoir_fw.guidance`."""
    planner: Planner | None = None
    """What plans, for drones that follow trajectories."""
    is_watched: bool = False
    """Whether the agent is observed only: its guidance runs and publishes, but this process sends it no commands."""
    phase: DronePhase = DronePhase.GROUND
    reference: Reference | None = None
    """What it follows at present."""
    home: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    """Where it stood when its motors began to turn (m, world), shape (3,)."""
    floor: float = 0.0
    """Height of what it lands on (m)."""
    has_flown: bool = False
    """Whether it was clearly off the floor since its motors began to turn."""
    low_since: float | None = None
    """Time from which it has been on the floor without a command to land (s)."""
    in_round: bool = False
    """Whether its guidance waits for neighbors."""
    lost: frozenset[int] = frozenset()
    """Neighbors that its guidance does not hear."""
    failure: str | None = None
    """Why it cannot fly, a sentence."""

    @property
    def is_up(self) -> bool:
        """Whether its motors turn."""
        return self.phase.has_motors_on

    def begin_at(self, position: NDArray[np.float64]) -> None:
        """Note where it stands while its motors begin to turn (m, world)."""
        self.home = position.copy()
        self.floor = float(position[2]) if position[2] < _FLOOR_M else 0.0


class SwarmPhases:
    """The phases of agents as arrays, as of the last `look`; any code may set the phase of an agent."""

    def __init__(self, agents: Sequence[Agent]) -> None:
        """Take the agents, and look."""
        self._agents = list(agents)
        self._seen: list[DronePhase] | None = None
        self.look()

    def look(self) -> None:
        """Bring everything up to date."""
        phases = list(map(_PHASE, self._agents))
        if phases == self._seen:
            return
        self._seen = phases
        self.numbers = np.array([phase.number for phase in phases], float)
        """Their numbers in logs, shape (N,)."""
        self.turning = np.array([phase.has_motors_on for phase in phases], bool)
        """Whether the motors of each drone turn, shape (N,)."""
        self.turning.flags.writeable = False  # all callers share this array
        self.up = [agent for agent in self._agents if agent.is_up]
        """Agents whose motors turn."""
        self.is_anybody_landing = DronePhase.LANDING in phases
