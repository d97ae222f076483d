"""Many guidances of one process, decided together: the same numbers in a fraction of the time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.errors import RangeError
from crazychoir_fw.guidance.bearing_formation import BearingFormation
from crazychoir_fw.guidance.cf_guidance import CFGuidance, Phase
from crazychoir_fw.guidance.distributed_feedback import CFDistributedFeedback
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.messages import Reference

Array = NDArray[np.float64]

_STILL = np.zeros(3)
_STILL.flags.writeable = False


class GuidanceGroup:
    """Steps agents that live in one process: all send, then all receive and decide.

    Messages travel as ever. Where every round is complete and nobody is missed, the laws of all followers of a bearing
    formation are evaluated as one product of a matrix and a vector; otherwise each decides by itself. Both ways may
    differ by rounding, below 1e-12 m/s^2.
    """

    def __init__(self, agents: Sequence[CFGuidance]) -> None:
        """Take the agents.

        Args:
            agents: In any order; neighbors of theirs may be elsewhere.

        Raises:
            RangeError: If two have the same number.
        """
        self.agents = list(agents)
        numbers = [agent.agent_id for agent in self.agents]
        if len(set(numbers)) != len(numbers):
            raise RangeError(f"agents have the numbers {numbers}, allowed: each once")
        self._place = {number: place for place, number in enumerate(numbers)}
        self._feedback = [agent for agent in self.agents if isinstance(agent, CFDistributedFeedback)]
        self._together = len(self._feedback) == len(self.agents) and all(map(self._knows, self._feedback))
        self._followers = [
            agent for agent in self._feedback if isinstance(agent, BearingFormation) and not agent.is_leader
        ]
        self._law = self._integral = np.zeros((0, 0))
        if self._together:
            self._law, self._integral = self._made_law()

    def _knows(self, agent: CFDistributedFeedback) -> bool:
        """Return whether a group can decide for an agent: by the law that it knows, on agents that it has."""
        return (
            isinstance(agent, BearingFormation)
            and type(agent).evaluate_input is BearingFormation.evaluate_input
            and type(agent).respond is BearingFormation.respond
            and type(agent).finish_round is CFDistributedFeedback.finish_round
            and not agent.legacy
            and agent.schedule is None
            and agent.communicator.synchronous_mode
            and all(neighbor in self._place for neighbor in agent.communicator.in_neighbors)
        )

    def _made_law(self) -> tuple[Array, Array]:
        """Return the matrices that take positions and velocities of all to inputs and rates of trims of followers."""
        size = len(self.agents)
        feedback = np.zeros((len(self._followers), 3, 2, size, 3))
        integral = np.zeros((len(self._followers), 3, size, 3))
        for row, agent in enumerate(self._followers):
            neighbors = agent.communicator.in_neighbors
            law = agent.law_of(neighbors)
            places = [*(self._place[neighbor] for neighbor in neighbors), self._place[agent.agent_id]]
            feedback[row][:, :, places] = law.feedback.reshape(3, 2, -1, 3)
            integral[row][:, places] = law.integral.reshape(3, -1, 3)
        rows = 3 * len(self._followers)
        return feedback.reshape(rows, 6 * size), integral.reshape(rows, 3 * size)

    def step(self, now: float) -> list[Outputs]:
        """Return what each agent asks for at a time (s), in the order of the agents."""
        for agent in self._feedback:
            agent.begin_round(now)
        if self._together and self._is_plain():
            return self._step_together(now)
        return [self._step_alone(agent, now) for agent in self.agents]

    def _step_alone(self, agent: CFGuidance, now: float) -> Outputs:
        if isinstance(agent, CFDistributedFeedback) and agent.round_open and agent.is_complete(now):
            return agent.finish_round(now)
        # a round that is not complete goes on; those without rounds just step
        return agent.step(now)

    def _is_plain(self) -> bool:
        """Return whether everybody has what everybody sent in this very round, and is in formation."""
        label = self.agents[0].communicator.current_label  # type: ignore[attr-defined]
        for agent in self._feedback:
            communicator = agent.communicator
            if not (
                agent.phase is Phase.FLIGHT
                and agent.round_open
                and not agent.is_troubled
                and communicator.current_label == label
                and communicator.has_round()
            ):
                return False
        return True

    def _step_together(self, now: float) -> list[Outputs]:
        for agent in self._feedback:
            agent.end_round(now)
        poses = [agent.current_pose for agent in self.agents]
        vectors = [pose.position for pose in poses]  # type: ignore[union-attr]
        vectors += [_STILL if pose.velocity is None else pose.velocity for pose in poses]  # type: ignore[union-attr]
        stacked = np.concatenate(vectors)
        inputs = (self._law @ stacked).reshape(-1, 3)
        rates = (self._integral @ stacked[: 3 * len(poses)]).reshape(-1, 3)
        accelerations = {
            agent.agent_id: agent.integrated(u, rate, now)
            for agent, u, rate in zip(self._followers, inputs, rates, strict=True)
        }
        return [
            agent.decided(now, Reference(acceleration=accelerations[agent.agent_id]))
            if agent.agent_id in accelerations
            else agent.decided(now, None)
            for agent in self._feedback
        ]
