"""`RoundGuidance`: guidance that exchanges messages with its neighbors, one round after the other."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.cf_guidance import CFGuidance
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.law import Needs, NodeFace, option
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.guidance.presence import Presence


class RoundGuidance(CFGuidance):
    """A round: `begin_round` sends, `is_complete` asks for the neighbors or the deadline, `finish_round` receives.

    Nothing waits: one thread hosts a whole swarm, and nodes begin and end rounds in callbacks.
    """

    needs = Needs(graph=True)
    node = NodeFace()

    deadline: float = option(0.05, "longest round", "s", above=0)

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone, that of the communicator.
            communicator: Carries messages to and from neighbors.
            options: Those that the class and its bases declare.

        Raises:
            RangeError: If a value is outside its range, or the communicator is that of another agent.
        """
        super().__init__(agent_id, **options)
        if communicator.rank != agent_id:
            raise RangeError(f"agent {agent_id}: the communicator is that of agent {communicator.rank}")
        self.communicator = communicator
        self.presence = Presence(communicator)
        """Which neighbors are present, and which are lost."""
        self.round_open = False
        self.round_begin = 0.0
        self.now = 0.0
        """Time of the latest step (s)."""

    @property
    def lost(self) -> frozenset[int]:
        """Neighbors that are silent."""
        return frozenset(self.presence.lost)

    # ---------------------------------------------------------------- to be overridden

    @abstractmethod
    def open_round(self, now: float) -> bool:
        """Send to the neighbors; False if no round is due."""

    @abstractmethod
    def has_round(self, now: float) -> bool:
        """Return whether all is there that the open round waits for."""

    @abstractmethod
    def close_round(self, now: float) -> None:
        """Take what came in the round that ends, complete or not."""

    @abstractmethod
    def decide(self, now: float) -> Outputs:
        """Return what to ask for, after a round or without one."""

    @property
    def longest_round(self) -> float:
        """Time after which the open round ends without those that are missing (s)."""
        return self.deadline

    def between_rounds(self, now: float) -> Outputs:
        """Return what to ask for while a round is open, or none is due."""
        return self.decide(now)

    # ---------------------------------------------------------------- a round

    def begin_round(self, now: float) -> bool:
        """Send, if a round is due; False if none is, or one is open."""
        self.now = now
        if self.round_open or not self.open_round(now):
            return False
        self.round_begin, self.round_open = now, True
        return True

    def is_complete(self, now: float) -> bool:
        """Return whether `finish_round` need not wait: all are there, the deadline is over, or no round is open."""
        return not self.round_open or self.has_round(now) or now - self.round_begin >= self.longest_round

    def finish_round(self, now: float) -> Outputs:
        """Receive, and return what to ask for; the round ends, complete or not."""
        self.now = now
        if self.round_open:
            self.round_open = False
            self.close_round(now)
        return self.decide(now)

    def step(self, now: float) -> Outputs:
        """Begin or finish a round, as far as that is possible now; never waits."""
        self.begin_round(now)
        if self.round_open and self.is_complete(now):
            return self.finish_round(now)
        return self.between_rounds(now)
